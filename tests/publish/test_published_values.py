"""A value passes for the present one only for so long as its channel is usually read."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mikas.publish.values import LatestValues

STEPS = st.lists(st.tuples(st.floats(0.01, 30), st.booleans()), max_size=40)


@given(STEPS, st.floats(0, 200))
def test_a_value_holds_for_a_second_or_three_usual_intervals(steps, later):
    latest, now, read = LatestValues(["TWAT"]), 0.0, []
    for value, (step, cleared) in enumerate(steps):
        now += step
        if cleared:
            latest.clear()
            read = []
            continue
        latest.add_sample(now, {"TWAT": value})
        read.append((now, value))
    got = latest.at(now + later)
    if not read:
        assert got.values == {"TWAT": None}
        assert got.is_gap
        return
    time, value = read[-1]
    longest = max(1.0, 3 * 30.0)  # no step is longer
    if now + later - time > longest:
        assert got.values == {"TWAT": None}
    if later <= 1.0:
        assert got.values == {"TWAT": value}
    assert got.values["TWAT"] in (None, value)
    assert ("TWAT" in got.ages) is (got.values["TWAT"] is not None and now + later - time > 1.0)


def test_a_clock_that_was_set_back_makes_no_negative_age():
    latest = LatestValues(["TWAT"])
    latest.add_sample(5.0, {"TWAT": 80})
    assert latest.at(4.0).values == {"TWAT": 80}
