"""The alarms of a report: as the sampler's own rule has them, from values and from events."""

from __future__ import annotations

import re
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from report_harness import START, found, measured, rows

from mikas.catalog import Level, load, shipped
from mikas.i18n import Text
from mikas.recording.table.channels import Rows
from mikas.report import page
from mikas.report.findings import Outcome
from mikas.report.measurements.alarms import AlarmCollector, Limit, limits_of, worst
from mikas.report.sections.summary import summary_sentence
from mikas.sampling.alarms import Alarms, Side
from mikas.sampling.events import AlarmChanged, LineState, StateChanged

LEVELS = tuple(Level)


@pytest.fixture(scope="module")
def catalog(tmp_path_factory):
    own = tmp_path_factory.mktemp("own") / "own.toml"
    own.write_text(
        "[parameter.TWAT.limits]\ndanger_high = 110\nwarning_low = 60\ndanger_low = 50\n"
        '[parameter.DET.limits]\nwhen_true = "danger"\n'
    )
    return load(own)


def by_the_scalar_rule(catalog, name, times, values):
    """Return (times, seconds, peak, still) by limit, by the rule that the sampler uses."""
    alarms, found_, last = Alarms(catalog), {}, {}
    limits = [each for each in limits_of(catalog) if each.name == name]
    for time, value in zip(times, values, strict=True):
        alarms.update({name: value}, time)
        state = alarms.states[name]
        if np.isnan(value):
            continue
        for limit in limits:
            on = state.side == limit.side and LEVELS.index(state.level) >= LEVELS.index(limit.level)
            was, before = last.get(limit, (False, -inf))
            count, seconds, peak = found_.get(limit, (0, 0.0, -inf))
            if was and 0 < time - before <= 15:
                seconds += time - before
            if on:
                count, peak = count + (not was), max(peak, limit.sign * value)
            last[limit] = (on, time)
            found_[limit] = (count, seconds, peak)
    return {
        limit: (count, pytest.approx(seconds), limit.sign * peak, last[limit][0])
        for limit, (count, seconds, peak) in found_.items()
        if count
    }


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(["TWAT", "UACC", "DET"]),
    st.lists(
        st.tuples(
            st.sampled_from([0.1, 1.0, 14.0, 16.0, 200.0]),
            st.sampled_from([nan, 9, 9.5, 10, 10.4, 10.5, 17.9, 18, 18.1, 17.5, 49, 50, 53, 59, 60])
            | st.sampled_from([61, 63, 97, 98, 100, 101, 107, 108, 110, 111, 120]),
        ),
        min_size=1,
        max_size=40,
    ),
    st.integers(1, 39),
)
def test_the_columns_have_the_alarms_of_the_sampler_s_rule(catalog, name, steps, cut) -> None:
    times = START + np.cumsum([step for step, _ in steps])
    values = np.array([float(value) for _, value in steps])
    if name == "DET":
        values = np.where(np.isnan(values), nan, values > 60)
    collector = AlarmCollector(catalog)
    for part in (slice(cut), slice(cut, None)):
        collector.add(Rows(times[part], {name: values[part]}))
    alarms = collector.alarms(times[0], times[-1])
    assert {a.limit: (a.times, a.seconds, a.peak, a.still) for a in alarms} == by_the_scalar_rule(
        catalog, name, times, values
    )
    ranks = [LEVELS.index(alarm.limit.level) for alarm in alarms]
    assert ranks == sorted(ranks, reverse=True)
    assert len({(a.limit.name, a.limit.side) for a in alarms}) == len(worst(alarms))


def hot(times):
    return np.where((times >= 20) & (times < 30), 117.0, 88.0)


def test_an_alarm_is_in_the_verdict_the_outcome_and_a_section_of_its_own() -> None:
    it = found(rows(60, TWAT=hot))
    assert it.outcome is Outcome.ATTENTION
    assert "; an alarm was on: coolant temperature above 100\N{NO-BREAK SPACE}°C (highest 117" in (
        summary_sentence(it).en
    )
    assert (
        "; была тревога: температура охлаждающей жидкости (ДТОЖ) выше 100\N{NO-BREAK SPACE}°C"
        in (summary_sentence(it).ru)
    )
    text = page.render(it, "en")
    assert "<h2>Alarms</h2>" in text
    (entry,) = re.findall(r"<h2>Alarms</h2>\n<ul><li>(.*?)</li></ul>", text)
    assert entry.startswith(
        "Coolant temperature above 100\N{NO-BREAK SPACE}°C (warning): once, 10 s"
    )
    assert "highest 117\N{NO-BREAK SPACE}°C at " in entry
    assert "still on" not in entry


def test_without_an_alarm_the_page_has_no_word_of_it() -> None:
    it = found(rows(60, TWAT=100.0))
    assert it.measured.alarms == ()
    assert "alarm" not in summary_sentence(it).en
    assert "Тревоги" not in page.render(it, "ru")


def event(
    time, level, value, *, before="none", limit=100.0, better=False, side="high", name="TWAT"
):
    text = Text("x", "х")
    return AlarmChanged(START + time, name, level, before, side, value, limit, text, better)


def test_an_alarm_of_a_channel_whose_values_were_not_kept_is_made_of_its_events() -> None:
    events = [
        event(10, "warning", 101.0),
        event(14, "danger", 112.0, before="warning", limit=110.0),
        event(16, "warning", 106.0, before="danger", limit=110.0, better=True),
        event(30, "none", 96.0, before="warning", better=True),
    ]
    (worse, milder) = measured(rows(60, TWAT=None), events=events).alarms
    assert worse.limit == Limit("TWAT", Level.DANGER, Side.HIGH, 110.0)
    assert milder.limit == Limit("TWAT", Level.WARNING, Side.HIGH, 100.0)
    assert (worse.times, worse.seconds, worse.peak, worse.by_event) == (1, 2.0, 112.0, True)
    assert (milder.times, milder.seconds, milder.peak, milder.still) == (1, 20.0, 112.0, False)
    assert [alarm.limit.level for alarm in worst([worse, milder])] == [Level.DANGER]


def test_values_and_the_event_of_one_alarm_are_one_alarm() -> None:
    events = [event(20, "warning", 117.0), event(30, "none", 88.0, before="warning", better=True)]
    (alarm,) = measured(rows(60, TWAT=hot), events=events).alarms
    assert (alarm.times, alarm.seconds, alarm.by_event) == (1, pytest.approx(10), False)


def test_a_limit_of_the_time_counts_though_the_catalog_has_another_now() -> None:
    events = [event(20, "danger", 95.0, limit=90.0)]
    (alarm,) = measured(rows(60, TWAT=lambda t: np.where(t < 20, 88, 95.0)), events=events).alarms
    assert (alarm.limit.value, alarm.peak, alarm.still) == (90.0, 95.0, True)
    assert alarm.seconds == pytest.approx(39.9)


def test_an_alarm_without_values_ends_with_the_line_and_with_the_data() -> None:
    broken = StateChanged(START + 25, LineState.NO_PORT)
    (alarm,) = measured(rows(60, TWAT=None), events=[event(-30, "warning", 104.0), broken]).alarms
    assert (alarm.began, alarm.seconds, alarm.still) == (START, 25.0, False)
    (alarm,) = measured(rows(60, TWAT=None), events=[event(50, "warning", 104.0)]).alarms
    assert (alarm.seconds, alarm.still) == (pytest.approx(9.9), True)
    assert measured(rows(60, TWAT=None), events=[event(99, "warning", 104.0)]).alarms == ()


@pytest.mark.parametrize(
    "damaged",
    [
        event(1, "none", None), event(1, "warning", None, limit=nan), event(1, "x", 1.0),
        event(1, "warning", 1.0, side="up"), event(1, "warning", 1.0, name="NEVER"),
        event(1, "warning", 1.0, limit=None),
    ],
)  # fmt: skip
def test_a_damaged_event_is_no_alarm(damaged) -> None:
    assert measured(rows(60), events=[damaged]).alarms == ()


def test_a_file_may_name_thousands_of_limits() -> None:
    events = [event(n / 100, "warning", 1.0 + n, limit=float(n)) for n in range(3000)]
    assert len(limits_of(shipped(), events)) < 80
