"""A job's turn on the line: a waiting one can be cancelled, a running one is waited for."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future

import pytest

from mikas.dashboard.errors import Busy
from mikas.dashboard.session.connection import run_in_turn
from mikas.sampling.jobs import JobQueue


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


class Running:
    """A session that has begun with a job before anybody waits for it."""

    def __init__(self, future):
        self.future = future

    def call(self, job):
        return self.future


def test_a_job_whose_turn_did_not_come_is_never_done():
    session, done = Waiting(), []
    with pytest.raises(Busy) as refused:
        asyncio.run(run_in_turn(session, done.append, 0.0))
    assert refused.value.status == 409
    session.jobs.run(None)
    assert done == []


def test_a_job_that_has_begun_is_waited_for_and_its_end_told():
    assert asyncio.run(run_in_turn(Running(UnderWay()), lambda _: None, 0.0)) == "written"
    with pytest.raises(ZeroDivisionError):
        asyncio.run(run_in_turn(Running(UnderWay(ZeroDivisionError())), lambda _: None, 0.0))


def test_who_has_gone_leaves_no_job_behind():
    session, done = Waiting(), []

    async def ask_and_go():
        asking = asyncio.create_task(run_in_turn(session, done.append, 60.0))
        while not session.jobs:
            await asyncio.sleep(0)
        asking.cancel()
        await asyncio.wait({asking})
        assert asking.cancelled()

    asyncio.run(ask_and_go())
    session.jobs.run(None)
    assert done == []
