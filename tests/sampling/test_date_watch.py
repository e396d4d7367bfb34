"""The date is compared with a clock: what is a sleep, what a date that was set, what neither."""

from __future__ import annotations

import pytest

from mikas.sampling.date_watch import DateWatch, Jump
from mikas.sampling.events import ClockChanged

DATE = 1_700_000_000.0
NIGHT = 43_200.0


def looks(*seen: tuple[float, float, bool]) -> list[Jump | None]:
    """What a watch finds at each clock, with the date so far ahead, and values or none."""
    watch = DateWatch()
    return [
        watch.look(DATE + now, DATE + now + ahead, broken=broken) for now, ahead, broken in seen
    ]


def test_a_date_that_runs_with_the_clock_is_no_jump_and_neither_is_its_drift():
    seen = [(it, it * 0.0001, it % 3 == 0) for it in range(0, 9000, 50)]
    assert looks(*seen) == [None] * len(seen)


@pytest.mark.parametrize("ppm", [500, -500, 50])
@pytest.mark.parametrize("step", [2.0, 60.0, 3600.0])
def test_drift_is_noted_seldom_as_a_set_date_and_no_date_is_wrong_for_more(ppm, step):
    day = 86_400
    count = int(day / step)
    watch, noted = DateWatch(), 0.0
    for number in range(count + 1):
        now = number * step
        drift = now * ppm * 1e-6
        found = watch.look(DATE + now, DATE + now + drift, broken=number % 7 == 0)
        if found is not None:
            assert not found.slept
            assert abs(found.seconds) >= 9.9
            noted += found.seconds
        assert abs(noted - drift) < 11.5
    assert watch.conclude() is None


@pytest.mark.parametrize("rate", [0.083, 0.3, 0.006])
@pytest.mark.parametrize("seconds", [60.0, -60.0])
def test_a_date_that_is_slewed_to_another_is_noted_once_when_it_rests(rate, seconds):
    lasts = abs(seconds) / rate
    moments = [it * 0.5 for it in range(int((lasts + 30) / 0.5))]
    seen = [(it, seconds * max(0.0, min(1.0, (it - 10) / lasts)), False) for it in moments]
    [found] = [it for it in looks(*seen) if it]
    assert found.seconds == pytest.approx(seconds, abs=0.2)


def test_a_jump_while_values_come_sets_the_date_after_some_seconds():
    first, *found = looks((0, 0, False), (1, NIGHT, False), (3, NIGHT, False), (5, NIGHT, False))
    assert (first, found[:2]) == (None, [None, None])
    assert found[2] == Jump(DATE + 1, NIGHT, DATE + 1, DATE + 1 + NIGHT, slept=False)


@pytest.mark.parametrize("since", [False, True])
def test_a_jump_while_no_values_come_or_just_before_is_a_sleep(since):
    *_, found = looks((0, 0, since), (1, NIGHT, since), (2, NIGHT, True))[: 2 if since else 3]
    assert found is not None
    assert found.slept


@pytest.mark.parametrize("seconds", [-NIGHT, -2.0, 31 * 86400.0])
def test_no_sleep_goes_back_or_is_of_months(seconds):
    [_, found] = looks((0, 0, True), (1, seconds, True))
    assert found is not None
    assert (found.seconds, found.slept) == (seconds, False)


def test_a_date_that_was_set_before_the_first_look_is_a_jump():
    *_, found = looks((0, NIGHT, False), (3, NIGHT, False), (5, NIGHT, False))
    assert found == Jump(DATE, NIGHT, DATE, DATE + NIGHT, slept=False)


def test_a_date_that_is_set_to_and_fro_is_no_jump():
    assert looks((0, 0, False), (1, NIGHT, False), (2, 0, False), (9, 0, False)) == [None] * 4


def test_the_end_of_a_session_decides():
    watch = DateWatch()
    watch.look(DATE, DATE, broken=False)
    watch.look(DATE + 1, DATE - 99, broken=False)
    jump = watch.conclude()
    assert jump is not None
    assert (jump.seconds, jump.slept) == (-100, False)
    assert watch.conclude() is None
    assert watch.look(DATE + 9, DATE - 91, broken=False) is None


@pytest.mark.parametrize(
    ("seconds", "length"),
    [(5, "5 s"), (75.4, "1 min 15 s"), (NIGHT, "12 h 0 min"), (1e8, "1157 d 9 h")],
)
def test_a_change_is_said_in_words(seconds, length):
    words = [
        ClockChanged(0.0, sign * seconds, slept=slept, before=0.0, after=0.0).text
        for sign, slept in ((1, True), (1, False), (-1, False))
    ]
    assert [length in text.en for text in words] == [True] * 3
    assert ["slept" in words[0].en, "ahead" in words[1].en, "back" in words[2].en] == [True] * 3
