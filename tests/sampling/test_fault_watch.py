"""The stored faults are read while sampling: at once when MINERR changes, else seldom."""

from __future__ import annotations

from contextlib import closing
from math import nan

import pytest
from sampling_harness import SimulatedPlug

from mikas.client.connecting import ConnectionOptions
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import CycleFailed, FaultReading, Sampled
from mikas.sampling.fault_watch import FaultWatch, appeared
from mikas.sampling.gaps import GapTracker
from mikas.virtual.build import build_bus

OPTIONS = ConnectionOptions()


def watched(method, *, seconds, changes=(), in_streams=15.0, **settings):
    """The readings of so many simulated seconds, when MINERR changed, and the gaps meanwhile."""
    plug = SimulatedPlug(build_bus({"scenario": "warm-idle", **settings}))
    car = plug.bus.ecu.responder.car
    for time, faults in changes:
        plug.at(time, lambda faults=faults: setattr(car, "faults", list(faults)))
    watch, tracker = FaultWatch(in_streams), GapTracker()
    rate = None if method == "stream" else 5.0
    names = ["FREQ", "TWAT", "MINERR"] if rate else ()
    made = Acquisition(plug, OPTIONS.create_ecu, OPTIONS.catalog, names, method=method, rate=rate)
    readings, seen, gaps = [], {}, []

    def read(ecu):
        readings.append(watch.read(ecu))

    with closing(made.run()) as events:
        for event in events:
            gaps += tracker.gaps_of(event)
            if isinstance(event, Sampled) and "MINERR" in event.fresh:
                seen.setdefault(float(event.fresh["MINERR"].value), event.time)
            if watch.is_due(event):
                made.call(read)
            assert not isinstance(event, CycleFailed)
            if event.time > seconds:
                break
    return readings, seen, gaps


@pytest.mark.parametrize("method", ["stream", "batch"])
def test_a_new_lowest_fault_is_read_at_once_and_another_soon(method):
    changes = [(4.0, [53]), (8.0, [53, 13]), (9.0, [53, 13, 71]), (33.0, [])]
    readings, seen, gaps = watched(method, seconds=36.0, changes=changes)
    codes = [reading.codes for reading in readings]
    firsts = {code: readings[at] for at, code in reversed(list(enumerate(codes)))}
    assert list(dict.fromkeys(codes)) == [(), (53,), (53, 13), (53, 13, 71)]
    assert codes[-1] == ()
    for lowest, code in ((53, (53,)), (13, (53, 13))):
        assert 0 < firsts[code].time - seen[lowest] < 0.5
    late = firsts[(53, 13, 71)].time - 9.0  # MINERR stays 13
    assert 0 < late < (15.6 if method == "stream" else 5.3)
    assert not gaps
    assert len(readings) < (8 if method == "stream" else 13)


def test_nothing_is_read_again_while_nothing_is_stored_or_a_stream_is_not_to_be_disturbed():
    readings, *_ = watched("batch", seconds=30.0)
    assert len(readings) == 1
    readings, *_ = watched("stream", seconds=30.0, in_streams=None, faults="13,53")
    assert len(readings) == 1


def test_a_unit_that_is_silent_to_02_is_asked_twice_and_makes_no_gap():
    plug = SimulatedPlug(build_bus({"scenario": "warm-idle", "missing": "02"}))
    watch, tracker, asked, gaps = FaultWatch(), GapTracker(), [], []
    made = Acquisition(plug, OPTIONS.create_ecu, OPTIONS.catalog, ["FREQ"], method="batch", rate=5)
    with closing(made.run()) as events:
        for event in events:
            gaps += tracker.gaps_of(event)
            if watch.is_due(event):
                made.call(lambda ecu: asked.append(watch.read(ecu)))
            if event.time > 20.0:
                break
    assert asked == [None, None]
    assert watch.refused
    assert not gaps


TIMES = [0.0, 1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(
    ("lowest", "moment"),
    [
        ([0, 0, 13, 13, 13], (1.0, 2.0)),
        ([53, 53, 53, 13, 13], (2.0, 3.0)),
        ([nan, 53, nan, 13, 13], (1.0, 3.0)),
        ([12, 12, 12, 12, 12], (0.5, 4.5)),  # hidden by a lower one
        ([], (0.5, 4.5)),  # not sampled
    ],
)
def test_the_moment_of_a_fault_lies_between_the_last_value_without_and_the_first_with(
    lowest, moment
):
    assert appeared(13, 0.5, 4.5, TIMES[: len(lowest)], lowest) == moment


def test_a_change_that_another_reading_has_shown_is_not_read_again():
    """An erase reads the faults itself; MINERR follows."""
    plug = SimulatedPlug(build_bus({"scenario": "warm-idle", "faults": "17,41"}))
    watch, readings = FaultWatch(), []
    made = Acquisition(plug, OPTIONS.create_ecu, OPTIONS.catalog, ["MINERR"], method="batch")

    def erase(ecu):
        watch.know(FaultReading(ecu.tester.link.now(), ecu.erase_faults().after, erased=True))

    with closing(made.run()) as events:
        erased = False
        for event in events:
            if watch.is_due(event):
                made.call(lambda ecu: readings.append(watch.read(ecu)))
            if readings and not erased:
                erased = True
                made.call(erase)
            if event.time > 30.0:
                break
    assert [reading.codes for reading in readings] == [(17, 41)]
