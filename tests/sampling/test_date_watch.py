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
    return [watch.look(now, DATE + now + ahead, broken=broken) for now, ahead, broken in seen]


def test_a_date_that_runs_with_the_clock_is_no_jump_and_neither_is_its_drift():
    seen = [(it, it * 0.0001, it % 3 == 0) for it in range(0, 9000, 50)]
    assert looks(*seen) == [None] * len(seen)


def test_drift_of_a_day_is_corrected_second_by_second():
    found = [it for it in looks(*((it, it * 0.0001, False) for it in range(0, 86400, 5))) if it]
    assert [round(it.seconds, 1) for it in found] == [1.0] * 8
    assert not any(it.slept for it in found)


def test_a_jump_while_values_come_sets_the_date_after_some_seconds():
    first, *found = looks((0, 0, False), (1, NIGHT, False), (3, NIGHT, False), (5, NIGHT, False))
    assert (first, found[:2]) == (None, [None, None])
    assert found[2] == Jump(1, NIGHT, DATE + 1, DATE + 1 + NIGHT, slept=False)


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


def test_a_date_that_is_set_to_and_fro_is_no_jump():
    assert looks((0, 0, False), (1, NIGHT, False), (2, 0, False), (9, 0, False)) == [None] * 4


def test_the_end_of_a_session_decides():
    watch = DateWatch()
    watch.look(0, DATE, broken=False)
    watch.look(1, DATE - 99, broken=False)
    jump = watch.conclude()
    assert jump is not None
    assert (jump.seconds, jump.slept) == (-100, False)
    assert watch.conclude() is None
    assert watch.look(9, DATE - 91, broken=False) is None


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
