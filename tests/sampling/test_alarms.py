"""Alarms: levels with hysteresis, on both sides; what is missing changes nothing."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import AlarmLimits, Level, load, shipped
from mikas.client.parameters.derived import DerivedChannels
from mikas.client.parameters.readings import decode
from mikas.i18n import Text
from mikas.sampling.alarms import Alarms, AlarmState, Side
from mikas.sampling.events import AlarmChanged
from protocol_codes import with_limits

NONE, WARNING, DANGER = Level
BOTH = AlarmLimits(danger_low=9, warning_low=11, warning_high=15, danger_high=16, hysteresis=0.5)


def voltage(limits: AlarmLimits = BOTH) -> Alarms:
    return Alarms(with_limits(shipped(), UACC=limits))


def levels(alarms: Alarms, *values: float | None) -> list[tuple[Level, Side | None]]:
    states = []
    for time, value in enumerate(values):
        alarms.update({"UACC": value}, float(time))
        state = alarms.states["UACC"]
        states.append((state.level, state.side))
    return states


def test_a_level_ends_behind_its_hysteresis() -> None:
    low, high = Side.LOW, Side.HIGH
    assert levels(voltage(), 14, 15, 15.1, 14.6, 14.5, 16.1, 15.6, 15.5, 14.6, 14.5) == [
        (NONE, None), (NONE, None), (WARNING, high), (WARNING, high), (NONE, None),
        (DANGER, high), (DANGER, high), (WARNING, high), (WARNING, high), (NONE, None),
    ]  # fmt: skip
    assert levels(voltage(), 11, 10.9, 11.4, 11.5, 8.9, 9.4, 9.5, 17, 8) == [
        (NONE, None), (WARNING, low), (WARNING, low), (NONE, None),
        (DANGER, low), (DANGER, low), (WARNING, low), (DANGER, high), (DANGER, low),
    ]  # fmt: skip


def test_without_hysteresis_the_limit_itself_is_inside() -> None:
    alarms = voltage(AlarmLimits(warning_high=15))
    assert [level for level, _ in levels(alarms, 15, 15.1, 15)] == [NONE, WARNING, NONE]


def test_limits_of_danger_alone_have_no_warning() -> None:
    alarms = voltage(AlarmLimits(danger_low=9, hysteresis=1))
    assert [level for level, _ in levels(alarms, 9.5, 8.9, 9.9, 10)] == [NONE, DANGER, DANGER, NONE]


def test_each_change_of_a_level_is_an_event() -> None:
    alarms = voltage()
    events = []
    for time, value in enumerate([14, 15.5, 16.5, 15.2, 14, 8, 20]):
        events += alarms.update({"UACC": value}, 100.0 + time)
    reported = [(each.time, each.level, each.before, each.better, each.side, each.value, each.limit)
            for each in events]  # fmt: skip
    assert reported == [
        (101, WARNING, NONE, False, Side.HIGH, 15.5, 15),
        (102, DANGER, WARNING, False, Side.HIGH, 16.5, 16),
        (103, WARNING, DANGER, True, Side.HIGH, 15.2, 16),
        (104, NONE, WARNING, True, Side.HIGH, 14, 15),
        (105, DANGER, NONE, False, Side.LOW, 8, 9),
        (106, DANGER, DANGER, False, Side.HIGH, 20, 16),
    ]
    assert [each.text for each in events[1:5]] == [
        Text("Battery voltage 16.5 V is above 16 V: danger",
             "Напряжение бортсети 16,5 В выше 16 В: опасность"),
        Text("Battery voltage 15.2 V: no longer danger, still warning",
             "Напряжение бортсети 15,2 В: уже не опасность, но ещё предупреждение"),
        Text("Battery voltage 14.0 V: back within 15 V",
             "Напряжение бортсети 14,0 В: снова в пределах 15 В"),
        Text("Battery voltage 8.0 V is below 9 V: danger",
             "Напряжение бортсети 8,0 В ниже 9 В: опасность"),
    ]  # fmt: skip
    assert all(each.name == "UACC" for each in events)


def test_a_missing_value_leaves_the_state_as_it_is() -> None:
    alarms = voltage()
    parameter = alarms.states["UACC"].channel
    assert alarms.states["UACC"] == AlarmState(parameter)
    alarms.update({"UACC": 14}, 1.0)
    alarms.update({"UACC": 15.5}, 2.0)
    alarms.update({"UACC": 15.4}, 3.0)
    expected = AlarmState(parameter, WARNING, Side.HIGH, 15, value=15.4)
    assert alarms.states["UACC"] == expected
    for missing in ({}, {"UACC": None}, {"UACC": math.nan}, {"UACC": math.inf}):
        assert alarms.update(missing, 4.0) == []
        assert alarms.states["UACC"] == expected
    alarms.update({"UACC": 14.6}, 5.0)  # still held: the gap did not end it
    assert alarms.states["UACC"].level is WARNING


def test_the_limits_of_the_catalog_raise_alarms() -> None:
    alarms = Alarms(shipped())
    assert list(alarms.states) == ["TWAT", "FREQ", "UACC", "DET", "DUTY"]
    events = alarms.update({"TWAT": 101, "FREQ": 840, "UACC": 9.5, "THR": 999}, 0.0)
    assert [(each.name, each.level) for each in events] == [
        ("TWAT", WARNING),
        ("UACC", WARNING),
    ]


def test_a_flag_raises_its_alarm(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text("[parameter.DET.limits]\nwhen_true = 'danger'\n", encoding="utf-8")
    catalog = load(path)
    alarms = Alarms(with_limits(catalog, RXX=AlarmLimits(when_true=WARNING)))
    knock = catalog.parameter("DET")
    events = []
    for time, raw in enumerate([b"\0", b"\x40", b"\x40", b"\0", b"\0", b"\0"]):
        events += alarms.update({"DET": decode(knock, raw, time, "corrected"), "RXX": True}, time)
    assert [(each.time, each.name, each.level, each.side) for each in events] == [
        (0, "RXX", WARNING, Side.HIGH),
        (1, "DET", DANGER, Side.HIGH),
        (5, "DET", NONE, Side.HIGH),
    ]
    assert [each.text for each in events[1:]] == [
        Text("Knock present: danger", "Детонация: опасность"),
        Text("Knock present: over", "Детонация: прекратилось"),
    ]


def test_the_alarm_of_a_flag_lasts_three_seconds_after_it_was_last_set() -> None:
    """A knock is shown for an eighth of a second; each knock makes no alarm of its own."""
    alarms = Alarms(shipped())
    flags = {1.0: 1, 1.1: 0, 3.5: 1, 3.6: 0, 6.4: 0, 6.6: 0, 9.0: 1, 9.1: 0}
    events = [each for time, value in flags.items() for each in alarms.update({"DET": value}, time)]
    assert [(each.time, each.level) for each in events] == [
        (1.0, WARNING),
        (6.6, NONE),
        (9.0, WARNING),
    ]
    assert alarms.states["DET"].level is WARNING
    alarms.update({"DET": 0}, 8.0)  # a clock that was set back: the knock is not in its past
    assert alarms.states["DET"].level is NONE


def test_only_fresh_readings_count_and_in_the_corrected_sense() -> None:
    alarms = voltage()
    parameter = shipped().parameter("UACC")
    reading = decode(parameter, parameter.encode(14.2), 10.0, "literal")
    assert reading.value < 10
    assert alarms.update({"UACC": reading}, 11.1) == []
    assert alarms.states["UACC"].value is None
    assert alarms.update({"UACC": reading}, 11.0) == []
    assert alarms.states["UACC"].value == 14.2


def test_a_derived_channel_raises_its_alarm() -> None:
    derived, alarms = DerivedChannels(shipped(), ["DUTY"]), Alarms(shipped())
    sample = {
        name: decode(parameter, parameter.encode(value), 0, "corrected")
        for name, value in {"INJ": 25, "FREQ": 5200}.items()
        for parameter in [shipped().parameter(name)]
    }
    (event,) = alarms.update(derived.update(sample, 0), 0)
    assert event.name == "DUTY"
    assert event.text.en == "Injector duty 108.3 % is above 100 %: danger"


volts = st.one_of(
    st.none(), st.floats(5, 20), st.sampled_from([8.9, 9, 9.5, 11, 11.5, 14.5, 15, 15.5, 16, 16.1])
)


@given(st.lists(volts))
def test_by_any_course_a_level_is_never_milder_than_its_value(values: list[float | None]) -> None:
    alarms = voltage()
    level, side = NONE, None
    for time, value in enumerate(values):
        before = alarms.states["UACC"]
        events: list[AlarmChanged] = alarms.update({"UACC": value}, float(time))
        state = alarms.states["UACC"]
        if value is None:
            assert (state.level, state.value) == (before.level, before.value)
            assert not events
            continue
        # never milder than the value alone, and within the hysteresis never worse than before
        alone = DANGER if not 9 <= value <= 16 else WARNING if not 11 <= value <= 15 else NONE
        inside = DANGER if not 9.5 < value < 15.5 else WARNING if not 11.5 < value < 14.5 else NONE
        order = list(Level)
        assert order.index(alone) <= order.index(state.level) <= order.index(inside)
        if order.index(state.level) > order.index(alone):
            assert order.index(before.level) >= order.index(state.level)
        # events tell each change, and nothing else
        assert len(events) == ((state.level, state.side) != (level, side))
        for event in events:
            assert (event.before, event.level) == (level, state.level)
            assert event.text.en
            assert event.text.ru
        level, side = state.level, state.side


def test_of_an_instruments_channel_an_alarm_ends_with_its_values() -> None:
    limits = AlarmLimits(danger_high=1.2)
    alarms = Alarms([replace(shipped().instruments["LAMBDA"], alarm_limits=limits)])
    [begun] = alarms.update({"LAMBDA": 1.3}, 1.0)
    assert (begun.level, begun.limit) == (DANGER, 1.2)
    [ended] = alarms.lose(["LAMBDA", "AFR"], 2.0)
    assert (ended.level, ended.before, ended.better) == (NONE, DANGER, True)
    assert ended.text.en == "Mixture λ, measured: no value any more"
    assert alarms.lose(["LAMBDA"], 3.0) == []
    assert len(alarms.update({"LAMBDA": 1.3}, 4.0)) == 1
