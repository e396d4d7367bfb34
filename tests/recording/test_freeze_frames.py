"""Freeze frames: the values around a fault's first appearance, with the true times."""

from __future__ import annotations

import json
from math import isnan, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.recording.freeze_frames import Breaks, frame_from, frame_of, new_faults
from mikas.recording.table.channels import Rows
from mikas.sampling.events import FaultReading, Gap, UnitFound

TIMES = [float(second) for second in range(100)]


def rows(**columns):
    return Rows(np.array(TIMES), {name: np.array(column) for name, column in columns.items()})


def test_the_moment_lies_between_two_values_of_minerr_and_ten_seconds_are_kept():
    lowest = [0.0 if time < 50 else 13.0 for time in TIMES]
    twat = [time if time % 2 == 0 else nan for time in TIMES]
    frame = frame_of(13, 40.0, 55.0, rows(MINERR=lowest, TWAT=twat, UOZ=[nan] * 100))
    assert (frame.without, frame.seen) == (49.0, 50.0)
    assert frame.times == tuple(TIMES[44:56])
    assert "UOZ" not in frame.values
    then = frame.then
    assert (then["TWAT"].value, then["TWAT"].low, then["TWAT"].high) == (50.0, 50.0, 50.0)


def test_a_fault_hidden_by_a_lower_one_is_known_as_well_as_it_was_read():
    frame = frame_of(71, 40.0, 45.0, rows(MINERR=[13.0] * 100, FREQ=TIMES))
    assert (frame.without, frame.seen) == (40.0, 45.0)
    then = frame.then["FREQ"]
    assert (then.value, then.low, then.high) == (45.0, 40.0, 45.0)


@pytest.mark.parametrize(("before", "read"), [(10.0, 90.0), (200.0, 210.0)])
def test_there_is_none_where_the_moment_or_the_values_are_unknown(before, read):
    assert frame_of(13, before, read, rows(FREQ=TIMES)) is None


def test_what_was_erased_and_comes_back_is_new():
    readings = [
        FaultReading(1.0, (13, 53)),
        FaultReading(2.0, (), erased=True),
        FaultReading(3.0, (53,)),
        FaultReading(4.0, (53, 13)),
    ]
    assert list(new_faults(readings)) == [(53, 2.0, 3.0), (13, 3.0, 4.0)]


def test_a_frame_survives_its_file():
    frame = frame_of(13, 40.0, 45.0, rows(FREQ=[nan, *TIMES[1:]], TWAT=[nan] * 44 + [1.0] * 56))
    again = frame_from(json.loads(json.dumps(frame.as_json(), allow_nan=False)))
    assert (again.id, again.then) == (frame.id, frame.then)
    assert [isnan(value) for value in again.values["TWAT"]].count(True) == 9


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=8,
)
KEYS = ("code", "without", "seen", "times", "values")


@settings(max_examples=50)
@given(st.dictionaries(st.sampled_from(KEYS), JSON) | JSON)
def test_any_file_is_a_frame_or_none(stored):
    frame = frame_from(stored)
    assert frame is None or frame.then is not None


def missing(begin, end, column=TIMES):
    return [nan if begin < time < end else value for time, value in zip(TIMES, column, strict=True)]


def test_no_value_from_before_a_gap_is_of_the_moment():
    held, twat = missing(42, 48), missing(42, 46)
    breaks = Breaks.of([Gap(42.0, 42.0, 46.0)])
    frame = frame_of(13, 40.0, 46.5, rows(FREQ=held, TWAT=twat), breaks)
    assert set(frame.then) == {"TWAT"}  # FREQ was not read again yet
    assert (frame.then["TWAT"].value, frame.then["TWAT"].low) == (46.0, 40.0)
    again = frame_from(json.loads(json.dumps(frame.as_json(), allow_nan=False)))
    assert set(again.then) == {"TWAT"}
    assert frame_of(13, 40.0, 45.5, rows(FREQ=held, TWAT=twat), breaks) is None


def test_the_last_value_is_of_a_moment_right_before_the_gap():
    breaks = Breaks.of([Gap(42.0, 42.0, None)])
    assert frame_of(13, 40.0, 42.1, rows(FREQ=missing(42, 48)), breaks).then["FREQ"].value == 42.0
    assert frame_of(13, 40.0, 42.7, rows(FREQ=missing(42, 48)), breaks) is None


def test_no_row_is_of_another_car_and_no_value_of_an_older_connection():
    found = UnitFound(42.0, 0x0A, None, another=True)
    frame = frame_of(13, 43.0, 45.0, rows(FREQ=TIMES), Breaks.of([found]))
    assert frame.times[0] == 42.0
    before = frame_of(13, 38.0, 40.0, rows(FREQ=TIMES), Breaks.of([found]))
    assert before.times[-1] == 41.0
    older = Breaks(connections=(42.5,))
    assert frame_of(13, 38.0, 42.9, rows(FREQ=missing(42, 48)), older) is None
    assert frame_of(13, 38.0, 43.0, rows(FREQ=TIMES), older).then["FREQ"].value == 43.0
