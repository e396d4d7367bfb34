"""Other threads' requests: done between two cycles, and never left hanging."""

from __future__ import annotations

import threading
from concurrent.futures import CancelledError
from contextlib import closing

import pytest
from sampling_harness import (
    SimulatedPlug,
    assert_values_are_the_units,
    enough,
    make_sampler,
    of,
    settled,
    take,
)

from mikas.errors import (
    EchoOnly,
    LinkLost,
    NoConnection,
    NoEcho,
    NotSupported,
    PortNotFound,
    UnknownParameter,
)
from mikas.sampling.events import CycleFailed, LineState, Sampled, StateChanged
from mikas.sampling.jobs import JobQueue
from mikas.virtual.bus import AdapterKind
from virtual_harness import make_bus

METHODS = ["single", "batch", "list", "stream", "stroke0"]


def faults(ecu):
    return [fault.code for fault in ecu.faults()]


@pytest.mark.parametrize("method", METHODS)
def test_jobs_go_in_between_by_every_method(method):
    sampler = make_sampler(SimulatedPlug(make_bus(rpm=5200)), method=method)
    early = sampler.call(faults)
    with closing(sampler.run()) as events:
        take(events, enough)
        asked = sampler.call(faults)
        failing = sampler.call(lambda ecu: ecu.read("nonsense"))
        cancelled = sampler.call(lambda ecu: ecu.faults())
        cancelled.cancel()
        after = take(events, enough)
    assert early.result(0) == asked.result(0) == [0x0D, 0x35, 0x40, 0x0D]
    assert isinstance(failing.exception(0), UnknownParameter)
    with pytest.raises(CancelledError):
        cancelled.result(0)
    assert_values_are_the_units(after)
    assert not of(CycleFailed, after)


@pytest.mark.parametrize("method", METHODS)
def test_a_steady_flow_of_them_does_not_stop_the_sampling_nor_the_other_way_round(method):
    sampler = make_sampler(SimulatedPlug(make_bus(rpm=5200)), "FREQ", "TWAT", method=method)
    done = []

    def one(ecu):
        done.append(ecu.tester.link.now())
        ecu.memory.ram.read_block(0, 16)
        if len(done) < 100:
            sampler.call(one)

    with closing(sampler.run()) as events:
        take(events, enough)
        sampler.call(one)
        reported = take(events, lambda e: len(done) == 100)
        samples = of(Sampled, reported)
        took = samples[-1].time - samples[0].time
        after = take(events, enough)
    assert len(samples) >= 95  # one between any two of them
    assert took < 100 * 0.1  # no stream is started and ended for each
    assert len(of(Sampled, after)) == 40
    assert not of(CycleFailed, reported + after)


@pytest.mark.parametrize(("method", "rate"), [("stroke0", None), ("batch", 0.05), ("stream", 0.05)])
def test_jobs_do_not_wait_for_a_slow_cycle(method, rate):
    """An engine that stands still sends no stream; at one sample in 20 s there is time."""
    plug = SimulatedPlug(make_bus(rpm=850))
    sampler = make_sampler(plug, "FREQ", "TWAT", method=method, rate=rate)
    waited = []
    with closing(sampler.run()) as events:
        take(events, lambda e: len(of(Sampled, e)) == 1)
        plug.bus.ecu.responder.car.rpm = 0
        for _ in range(2):
            asked_at = plug.now()
            asked = sampler.call(lambda ecu: ecu.tester.link.now())
            take(events, lambda e, asked=asked: asked.done())
            waited.append(asked.result(0) - asked_at)
    assert max(waited) < 2


def test_while_the_ecu_is_silent_jobs_fail_with_its_error():
    bus = make_bus()
    car = bus.ecu.responder.car
    plug = SimulatedPlug(bus)
    sampler = make_sampler(plug, method="stream")
    with closing(sampler.run()) as events:
        take(events, enough)
        car.on = False
        asked = sampler.call(faults)
        asked_at = plug.now()
        take(events, lambda e: bool(of(StateChanged, e)))
        assert isinstance(asked.exception(0), EchoOnly)
        assert plug.now() - asked_at < 6
        later = sampler.call(faults)
        plug.at(plug.now() + 4, lambda: setattr(car, "on", True))
        take(events, enough)
        assert isinstance(later.exception(0), NoConnection)
        again = sampler.call(faults)
        take(events, enough)
        assert len(again.result(0)) == 4


@pytest.mark.parametrize(
    ("spoil", "error", "state"),
    [
        (lambda plug: plug.pull(), (LinkLost, PortNotFound), LineState.NO_PORT),
        (lambda plug: plug.unsupply(), NoEcho, LineState.NO_ECHO),
    ],
)
def test_without_an_adapter_jobs_fail_soon(spoil, error, state):
    plug = SimulatedPlug(make_bus())
    sampler = make_sampler(plug, method="batch")
    with closing(sampler.run()) as events:
        take(events, enough)
        spoil(plug)
        asked = [sampler.call(faults)]
        reported = take(events, lambda e: bool(of(StateChanged, e)))
        assert of(StateChanged, reported)[-1].state is state
        asked.append(sampler.call(faults))
        plug.at(plug.now() + 5, plug.mend)
        take(events, enough)
        asked.append(sampler.call(faults))
        take(events, enough)
    assert isinstance(asked[0].exception(0), error)
    assert isinstance(asked[1].exception(0), error)
    assert len(asked[2].result(0)) == 4


def test_the_end_of_sampling_fails_waiting_jobs():
    sampler = make_sampler(SimulatedPlug(make_bus()), method="batch")
    with closing(sampler.run()) as events:
        take(events, enough)
        waiting = sampler.call(faults)
    assert isinstance(waiting.exception(0), LinkLost)
    assert isinstance(sampler.call(faults).exception(0), LinkLost)
    with closing(sampler.run()) as events:  # started again, it looks after them again
        take(events, enough)
        again = sampler.call(faults)
        take(events, enough)
    assert len(again.result(0)) == 4


def test_jobs_fail_with_the_error_that_ends_sampling():
    sampler = make_sampler(SimulatedPlug(make_bus()), "0x99", method="batch")
    waiting = sampler.call(lambda ecu: sampler.call(faults)), sampler.call(faults)
    with pytest.raises(NotSupported):
        list(sampler.run())
    for future in waiting:
        assert isinstance(future.exception(0), NotSupported)


def test_ctrl_c_in_a_job_fails_the_waiting_callers():
    sampler = make_sampler(SimulatedPlug(make_bus()), method="stream")

    def interrupted(ecu):
        raise KeyboardInterrupt

    events = sampler.run()
    take(events, enough)
    futures = sampler.call(interrupted), sampler.call(faults)
    with pytest.raises(KeyboardInterrupt):
        next(events)
    assert isinstance(futures[0].exception(0), KeyboardInterrupt)
    assert isinstance(futures[1].exception(0), LinkLost)


def test_jobs_are_done_while_methods_are_measured():
    plug = SimulatedPlug(make_bus())
    sampler = make_sampler(plug)
    with closing(sampler.run()) as events:
        take(events, lambda e: len(of(Sampled, e)) == 1)
        asked = sampler.call(lambda ecu: ecu.tester.link.now())
        began = plug.now()
        take(events, settled)
    assert asked.result(0) - began < 2


def test_jobs_of_many_threads_are_all_done():
    jobs = JobQueue("sim:")
    threads = [
        threading.Thread(target=lambda: futures.append(jobs.submit(lambda ecu: ecu)))
        for _ in range(50)
    ]
    futures: list = []
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    jobs.run("the unit")
    assert [future.result(0) for future in futures] == ["the unit"] * 50


def test_a_job_that_loses_the_ecu_leaves_the_others_for_later():
    jobs = JobQueue("sim:")

    def lost(ecu):
        raise EchoOnly

    first, second = jobs.submit(lost), jobs.submit(str)
    with pytest.raises(EchoOnly):
        jobs.run("unit")
    assert first.exception(0)
    assert not second.done()
    jobs.run("unit")
    assert second.result(0) == "unit"


def test_an_adapter_without_supply_has_its_own_line_state():
    plug = SimulatedPlug(make_bus(adapter=AdapterKind(supplied=False)))
    sampler = make_sampler(plug)
    asked = sampler.call(faults)
    with closing(sampler.run()) as events:
        (reported,) = take(events, lambda e: True)
    assert reported.state is LineState.NO_ECHO
    assert isinstance(asked.exception(0), NoEcho)
