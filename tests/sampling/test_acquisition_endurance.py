"""Long drives with a bad line: the memory stays flat, the clock does not drift, no value is wrong.

`make bench` does the same for eight hours.
"""

from __future__ import annotations

import gc
import tracemalloc
from contextlib import closing

import pytest
from sampling_harness import SimulatedPlug, assert_values_are_the_units, ecu_factory

from mikas.catalog import shipped
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import CycleFailed, Sampled
from mikas.virtual.fault_injector import FaultInjector, LineFault
from virtual_harness import make_bus

LINE_FAULTS = {
    LineFault.LOST: 0.004,
    LineFault.DAMAGED: 0.01,
    LineFault.LATE: 0.002,
    LineFault.CUT: 0.003,
    LineFault.DOUBLED: 0.001,
    LineFault.NOISE: 0.002,
    LineFault.ECHO: 0.002,
}


@pytest.mark.parametrize("method", ["batch", "stream"])
def test_minutes_of_a_bad_line_leave_nothing_behind(method, tmp_path):
    plug = SimulatedPlug(make_bus(fault_injector=FaultInjector(LINE_FAULTS, seed=1)))
    names = ["FREQ", "TWAT/10", "INJ", "FUEL_USED"]
    made = Acquisition(plug, ecu_factory(tmp_path), shipped(), names, method=method)
    sizes, times, gaps = [], [], 0
    tracemalloc.start()
    try:
        with closing(made.run()) as events:
            for stretch in range(1, 7):
                while plug.now() < 4 * stretch:
                    event = next(events)
                    if isinstance(event, Sampled):
                        times.append(event.time)
                        if len(times) % 10 == 0:
                            made.call(lambda ecu: None)
                        assert_values_are_the_units([event])
                    gaps += isinstance(event, CycleFailed)
                count = len(times)
                last, times = times[-1], sorted(times)
                assert times[-1] == last
                assert len(set(times)) == count
                times = times[-1:]
                del event
                gc.collect()
                sizes.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert sizes[-1] - sizes[3] < 20_000  # what is kept of the latest failures settles first
    assert plug.now() - times[-1] < 5


@pytest.mark.parametrize("method", ["batch", "stream"])
def test_a_rate_does_not_drift(method):
    times = sample_times(method, {}, 600)
    assert times[-1] - times[100] == pytest.approx(49.9, abs=0.03)


def test_a_rate_is_kept_on_a_bad_line():
    times = sample_times("batch", {LineFault.DAMAGED: 0.01}, 1800)
    assert (times[-1] - times[0]) / 1799 == pytest.approx(0.1, rel=0.05)


def sample_times(method: str, rates: dict[LineFault, float], count: int) -> list[float]:
    plug = SimulatedPlug(make_bus(fault_injector=FaultInjector(rates, seed=2)))
    made = Acquisition(plug, ecu_factory(), shipped(), ["FREQ"], method=method, rate=10.0)
    times: list[float] = []
    with closing(made.run()) as events:
        while len(times) < count:
            event = next(events)
            if isinstance(event, Sampled):
                times.append(event.time)
    return times
