"""Lanes: slots, keys, the network's share, deadlines, cancellation. No work here ends by itself."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future
from contextlib import ExitStack
from threading import Event

import pytest

from mikas.cancellation import Cancelled, check_cancelled
from mikas.dashboard.errors import Busy, TookTooLong
from mikas.dashboard.library.lanes import Lane, LaneLimits, WorkThread

LIMITS = LaneLimits(slots=3, deadline=3600, places=4, per_address=2)
PHONE, TABLET = "192.168.0.7", "192.168.0.8"


class Endless:
    """Work that checks, but never ends; `began` and `ended` say where it is."""

    def __init__(self):
        self.began, self.ended = Event(), Event()

    def __call__(self):
        self.began.set()
        try:
            while not self.ended.wait(1e-3):  # leaves the computer to the other threads
                check_cancelled()
        finally:
            self.ended.set()


async def begun(lane, key, address=None, deadline=None):
    """A task whose work has begun."""
    work = Endless()
    task = asyncio.create_task(lane.run(work, key=key, address=address, deadline=deadline))
    await asyncio.to_thread(work.began.wait, 60)
    return task, work


async def end(*tasks):
    for task in tasks:
        task.cancel()
    return await asyncio.gather(*tasks, return_exceptions=True)


def test_a_crafted_file_takes_one_slot_and_the_others_are_read():
    async def scenario():
        lane = Lane(LIMITS)
        bad, work = await begun(lane, "bad")
        again = asyncio.create_task(lane.run(Endless(), key="bad", address=None))
        for number in range(20):
            assert await lane.run(lambda: 1, key=f"good {number}", address=None) == 1
        assert not again.done()
        assert not work.ended.is_set()
        await end(bad, again)
        assert work.ended.is_set()
        assert await lane.run(lambda: 2, key="bad", address=None) == 2  # the file's slot is free

    asyncio.run(scenario())


def test_work_is_cancelled_at_its_deadline():
    async def scenario():
        lane = Lane(LaneLimits(slots=2, deadline=0, places=4, per_address=2))
        for _ in range(5):  # more than there are slots
            work = Endless()
            with pytest.raises(TookTooLong) as failure:
                await lane.run(work, key="bad", address=None)
            assert work.ended.is_set()
        assert "mikas export FILE" in failure.value.advice.en
        assert "mikas export ФАЙЛ" in failure.value.advice.ru

    asyncio.run(scenario())


def test_work_ends_with_the_task_that_awaits_it():
    async def scenario():
        lane = Lane(LIMITS)
        task, work = await begun(lane, "a")
        await end(task)
        assert work.ended.is_set()
        tasks = [(await begun(lane, str(key)))[0] for key in range(3)]
        waiting, never = [], Endless()
        waiting.append(asyncio.create_task(lane.run(never, key="waits", address=None)))
        await asyncio.sleep(0)
        await end(*waiting)  # cancelled before its turn
        await end(*tasks)
        assert not never.began.is_set()
        assert await lane.run(lambda: 3, key="a", address=None) == 3

    asyncio.run(scenario())


def test_a_slot_is_kept_for_this_computer():
    async def scenario():
        lane = Lane(LIMITS)
        network = [(await begun(lane, "a", PHONE))[0], (await begun(lane, "b", TABLET))[0]]
        third = asyncio.create_task(lane.run(lambda: 1, key="c", address=PHONE))
        assert await lane.run(lambda: 2, key="d", address=None) == 2
        assert not third.done()
        await end(network[0])
        assert await third == 1
        await end(network[1])

    asyncio.run(scenario())


def test_places_are_counted_for_each_address_and_for_the_network():
    lane = Lane(LIMITS)
    with ExitStack() as held:
        for address in (PHONE, PHONE, TABLET):
            held.enter_context(lane.place(address))
        for address in (PHONE, "192.168.0.9"):  # of its own; and of all the network
            if address != PHONE:
                held.enter_context(lane.place(address))
            with pytest.raises(Busy), lane.place(address):
                pass
        for _ in range(LIMITS.places):  # this computer has its own
            held.enter_context(lane.place(None))
        with pytest.raises(Busy), lane.place(None):
            pass
    with lane.place(PHONE), lane.place(PHONE), lane.place(None):
        assert lane._places.total() == 3  # noqa: SLF001
    assert not lane._places  # noqa: SLF001


def test_the_end_of_the_program_ends_all_work():
    async def scenario():
        lane = Lane(LIMITS)
        tasks, works = zip(*[await begun(lane, str(key)) for key in range(3)], strict=True)
        waiting = asyncio.create_task(lane.run(lambda: 1, key="waits", address=None))
        await asyncio.sleep(0)
        await lane.close()
        assert all(work.ended.is_set() for work in works)
        for task in (*tasks, waiting):
            with pytest.raises(Busy, match="closing"):
                await task
        with pytest.raises(Busy, match="closing"):
            await lane.run(lambda: 1, key="late", address=None)

    asyncio.run(scenario())


def test_work_that_ignores_its_end_keeps_its_slot_but_not_its_client(monkeypatch):
    monkeypatch.setattr("mikas.dashboard.library.lanes._PATIENCE", 0)
    deaf = Event()

    async def scenario():
        lane = Lane(LIMITS)
        with pytest.raises(TookTooLong):  # a step in C, which nothing ends
            await lane.run(lambda: deaf.wait(60), key="deaf", address=None, deadline=0)
        again = asyncio.create_task(lane.run(deaf.is_set, key="deaf", address=None))
        assert await lane.run(lambda: 1, key="other", address=None) == 1
        assert not again.done()
        deaf.set()
        assert await again  # only after the first has really ended

    asyncio.run(scenario())


def test_a_loop_without_a_check_is_interrupted(monkeypatch):
    monkeypatch.setattr("mikas.dashboard.library.lanes._PATIENCE", 0)
    cleaned = []

    def loop():
        try:
            while True:
                pass
        finally:
            cleaned.append(1)

    async def scenario():
        lane = Lane(LIMITS)
        for number in range(1, 8):  # more than there are slots
            with pytest.raises(TookTooLong):
                await lane.run(loop, key="a", address=None, deadline=0)
            assert await lane.run(lambda: len(cleaned), key="a", address=None) == number

    asyncio.run(scenario())


def test_an_interrupt_reaches_the_work_or_nothing():
    """It is sent at any moment; whatever it meets, the end is reported, once."""
    for _ in range(300):
        began, outcome = Event(), Future()
        thread = WorkThread("short", began.set, outcome)
        thread.start()
        began.wait(60)
        thread.interrupt()
        thread.interrupt()
        thread.join(60)
        error = outcome.exception(0)
        assert error is None or isinstance(error, Cancelled)


def test_an_error_of_the_work_is_raised_where_it_is_awaited():
    def work():
        raise ValueError("so it is")

    async def scenario():
        lane = Lane(LIMITS)
        with pytest.raises(ValueError, match="so it is"):
            await lane.run(work, key="a", address=None)
        assert await lane.run(lambda: 1, key="a", address=None) == 1

    asyncio.run(scenario())
