"""A job's turn on the line: a waiting one can be cancelled, a running one is waited for.
One change of the connection at a time; one plan at a time.
"""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace

import pytest

from mikas.catalog import shipped
from mikas.client.connecting import ConnectionOptions
from mikas.dashboard.errors import Busy
from mikas.dashboard.session.connection import Connection, SamplingPlanner, result_in_turn
from mikas.dashboard.session.history import History
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.dashboard.settings import PlanSettings, Settings
from mikas.sampling.jobs import JobQueue
from mikas.sampling.session import SamplingSession


class Waiting:
    """A session whose jobs wait until the test does them."""

    def __init__(self):
        self.jobs = JobQueue("sim:")
        self.jobs.open()
        self.call = self.jobs.submit


class UnderWay(Future):
    """A job that the line is at. It ends when somebody tries to take it back: not earlier."""

    def __init__(self, error=None):
        super().__init__()
        self.set_running_or_notify_cancel()
        self.error = error

    def cancel(self):
        taken_back = super().cancel()
        if self.error is None:
            self.set_result("written")
        else:
            self.set_exception(self.error)
        return taken_back


def test_a_job_whose_turn_did_not_come_is_never_done():
    session, done = Waiting(), []
    with pytest.raises(Busy) as refused:
        asyncio.run(result_in_turn(session.call(done.append), 0.0))
    assert refused.value.status == 409
    session.jobs.run(None)
    assert done == []


def test_a_started_job_is_waited_for_and_its_end_reported():
    assert asyncio.run(result_in_turn(UnderWay(), 0.0)) == "written"
    with pytest.raises(ZeroDivisionError):
        asyncio.run(result_in_turn(UnderWay(ZeroDivisionError()), 0.0))


def test_who_has_gone_leaves_no_job_behind():
    session, done = Waiting(), []

    async def ask():
        await result_in_turn(session.call(done.append), 60.0)

    async def ask_and_go():
        asking = asyncio.create_task(ask())
        while not session.jobs:
            await asyncio.sleep(0)
        asking.cancel()
        await asyncio.wait({asking})
        assert asking.cancelled()

    asyncio.run(ask_and_go())
    session.jobs.run(None)
    assert done == []


async def lend(it):
    async with it.lent():
        raise AssertionError("the port was lent twice")


@pytest.mark.parametrize(
    "second",
    [lambda it: it.connect("sim:"), Connection.disconnect, lend],
    ids=["connect", "disconnect", "lend"],
)
def test_who_comes_second_is_refused_not_kept_waiting(tmp_path, second):
    async def tried():
        it = Connection(
            Settings(tmp_path, state=tmp_path),
            ConnectionMonitor(History(), SamplingSession()),
            create=None,
            on_end=None,
        )
        async with it.lent():
            assert it.changing
            task = asyncio.create_task(second(it))
            await asyncio.sleep(0)  # its turn
            assert task.done()
            with pytest.raises(Busy, match="being changed"):
                task.result()
        assert not it.changing

    asyncio.run(tried())


class Lock:
    """A lock that reports when a thread has to wait for it."""

    def __init__(self, waited_for):
        self._lock, self._waited_for = threading.Lock(), waited_for

    def __enter__(self):
        if not self._lock.acquire(blocking=False):
            self._waited_for.set()
            self._lock.acquire()

    def __exit__(self, *_):
        self._lock.release()


def test_of_two_plans_at_once_the_sampled_one_is_reported(monkeypatch):
    sampled, reported, over = [], [], threading.Event()

    def second():
        planner.sample(PlanSettings({"FREQ": 1}))
        over.set()

    thread = threading.Thread(target=second)

    def reconfigure(names, method, rate):
        sampled.append(names)
        if names == ["TWAT"]:
            thread.start()
            assert over.wait(60)  # the second one has its way here, or waits for the first

    sampling = SimpleNamespace(acquisition=SimpleNamespace(reconfigure=reconfigure))
    monitor = SimpleNamespace(set_names=lambda every: reported.append(list(every)))
    connection = SimpleNamespace(thread=sampling, monitor=monitor)
    planner = SamplingPlanner(connection, ConnectionOptions())
    monkeypatch.setattr(planner, "_lock", Lock(over), raising=False)
    planner.sample(PlanSettings({"TWAT": 1}))
    thread.join()
    assert sampled == reported == [["TWAT"], ["FREQ"]]
    assert planner.request.names == sampled[-1]


def test_with_another_catalog_raw_codes_are_sampled_on():
    connection = SimpleNamespace(thread=None, monitor=SimpleNamespace(set_names=lambda every: None))
    own = replace(shipped(), derived={})
    planner = SamplingPlanner(connection, ConnectionOptions())
    planner.sample(PlanSettings({"TWAT": 1, "0x3F:2": 4, "FUEL_FLOW": 1}))
    planner.prefer(["0x3F:2", "FUEL_FLOW"])
    planner.use_catalog(own)
    assert planner.request.every == {"TWAT": 1, "0x3F:2": 4}
    assert planner.request.first == ("0x3F:2",)
