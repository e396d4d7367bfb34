"""One change of the connection at a time; one plan at a time."""

from __future__ import annotations

import asyncio
import threading
from types import SimpleNamespace

import pytest

from mikas.client.connecting import ConnectionOptions
from mikas.dashboard.errors import Busy
from mikas.dashboard.session.connection import Connection, SamplingPlanner
from mikas.dashboard.session.history import History
from mikas.dashboard.session.manager import ConnectionManager
from mikas.dashboard.session.monitor import ConnectionMonitor
from mikas.dashboard.settings import PlanSettings, Settings


async def lend(it):
    async with it.lent():
        raise AssertionError("the port was lent twice")


@pytest.mark.parametrize(
    "second",
    [lambda it: it.connect("sim:"), ConnectionManager.disconnect, lend],
    ids=["connect", "disconnect", "lend"],
)
def test_who_comes_second_is_refused_not_kept_waiting(tmp_path, second):
    async def tried():
        it = ConnectionManager(
            Settings(tmp_path, state=tmp_path),
            Connection(ConnectionMonitor(History())),
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
    """A lock that tells when somebody has to wait for it."""

    def __init__(self, waited_for):
        self._lock, self._waited_for = threading.Lock(), waited_for

    def __enter__(self):
        if not self._lock.acquire(blocking=False):
            self._waited_for.set()
            self._lock.acquire()

    def __exit__(self, *_):
        self._lock.release()


def test_of_two_plans_at_once_the_one_that_is_sampled_is_the_one_that_is_told(monkeypatch):
    sampled, told, over = [], [], threading.Event()

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
    connection = SimpleNamespace(thread=sampling)
    monitor = SimpleNamespace(set_names=lambda every: told.append(list(every)))
    planner = SamplingPlanner(connection, monitor, ConnectionOptions())
    monkeypatch.setattr(planner, "_lock", Lock(over), raising=False)
    planner.sample(PlanSettings({"TWAT": 1}))
    thread.join()
    assert sampled == told == [["TWAT"], ["FREQ"]]
    assert planner.request.names == sampled[-1]
