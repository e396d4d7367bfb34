"""`mikas.browser.event_loop`: asyncio as it is, between threads that suspend."""

from __future__ import annotations

import asyncio
import contextvars
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import anyio
import anyio.to_thread
import pytest

from mikas.browser.event_loop import EventLoop
from mikas.browser.suspension import yield_turn

SHORT = 0.01
LONG = 60


def run(coroutine):
    """In an event loop on a thread of its own, as on the site."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, coroutine, loop_factory=EventLoop).result()


def test_timers_come_in_order():
    async def scenario():
        loop, came = asyncio.get_running_loop(), []
        now = loop.time()  # of all: between two calls more than a millisecond may pass
        for delay in (0.003, 0.001, 0.002):
            loop.call_at(now + delay, came.append, delay)
        loop.call_soon(came.append, 0)
        await asyncio.sleep(0.004)
        while len(came) < 4:
            await asyncio.sleep(0)
        return came

    assert run(scenario()) == [0, 0.001, 0.002, 0.003]


def test_locks_queues_and_events_of_asyncio_work():
    async def scenario():
        lock, line, event = asyncio.Lock(), asyncio.Queue(2), asyncio.Event()
        inside, got = [], []

        async def put():
            for number in range(10):
                await line.put(number)
            event.set()

        async def take():
            while len(got) < 10:
                async with lock:
                    inside.append(1)
                    got.append(await line.get())
                    assert len(inside) == 1
                    inside.pop()

        async with asyncio.TaskGroup() as group:
            group.create_task(put())
            group.create_task(take())
            await event.wait()
        return got

    assert run(scenario()) == list(range(10))


def test_other_threads_wake_the_loop():
    async def scenario():
        loop, got = asyncio.get_running_loop(), asyncio.Queue()

        def tell(number):
            for _ in range(20):
                loop.call_soon_threadsafe(got.put_nowait, number)
                yield_turn()

        threads = [threading.Thread(target=tell, args=(number,)) for number in range(5)]
        for thread in threads:
            thread.start()
        return sorted([await got.get() for _ in range(100)])

    assert run(scenario()) == sorted([*range(5)] * 20)


def test_a_thread_asks_a_loop_and_waits():
    async def answer(number):
        await asyncio.sleep(0)
        return number + 1

    async def scenario():
        loop = asyncio.get_running_loop()

        def ask():
            return [
                asyncio.run_coroutine_threadsafe(answer(number), loop).result()
                for number in range(5)
            ]

        return await asyncio.gather(*[asyncio.to_thread(ask) for _ in range(3)])

    assert run(scenario()) == [[1, 2, 3, 4, 5]] * 3


def test_work_in_threads_lets_the_loop_run():
    async def scenario():
        begun, gate = threading.Event(), threading.Event()

        def hold():
            begun.set()
            gate.wait()
            return threading.current_thread().name

        held = asyncio.create_task(asyncio.to_thread(hold))
        await asyncio.to_thread(begun.wait)
        for _ in range(5):
            await asyncio.sleep(0)
        assert not held.done()
        gate.set()
        return await held, await anyio.to_thread.run_sync(lambda: threading.current_thread().name)

    held, own = run(scenario())
    assert held.startswith("asyncio_")
    assert own == "AnyIO worker thread"


def test_anyio_calls_back_from_its_threads():
    async def scenario():
        def work():
            return [anyio.from_thread.run(answer, number) for number in range(5)]

        async def answer(number):
            await anyio.sleep(0)
            return number * 2

        import anyio.from_thread

        async with anyio.create_task_group() as group:
            group.start_soon(anyio.sleep, 0)
            return await anyio.to_thread.run_sync(work)

    assert run(scenario()) == [0, 2, 4, 6, 8]


def test_a_work_in_a_thread_is_not_awaited_by_who_is_cancelled():
    async def scenario():
        gate = threading.Event()
        held = asyncio.create_task(asyncio.to_thread(gate.wait))
        await asyncio.sleep(0)
        held.cancel()
        with pytest.raises(asyncio.CancelledError):
            await held
        gate.set()

    run(scenario())


def test_cancellation_and_time_limits():
    async def scenario():
        cleaned = []

        async def for_ever():
            try:
                await asyncio.Event().wait()
            finally:
                await asyncio.sleep(0)
                cleaned.append(1)

        with pytest.raises(TimeoutError):
            await asyncio.wait_for(for_ever(), SHORT)
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(SHORT):
                await for_ever()
        with anyio.move_on_after(SHORT) as scope:
            await asyncio.Event().wait()
        assert scope.cancelled_caught
        done, waiting = await asyncio.wait([asyncio.create_task(for_ever())], timeout=SHORT)
        assert not done
        waiting.pop().cancel()
        task = asyncio.create_task(for_ever())
        await asyncio.sleep(0)
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        async with asyncio.timeout(LONG):
            await asyncio.sleep(0)
        return len(cleaned)

    assert run(scenario()) == 4


def test_an_error_of_one_task_ends_its_group():
    async def scenario():
        async def broken():
            await asyncio.sleep(0)
            raise ValueError("the bug of this test")

        async with asyncio.TaskGroup() as group:
            group.create_task(asyncio.Event().wait())
            group.create_task(broken())

    with pytest.raises(ExceptionGroup) as caught:
        run(scenario())
    assert caught.group_contains(ValueError, match="the bug of this test")


def test_each_thread_and_each_task_has_its_own_context():
    number = contextvars.ContextVar("number", default=0)

    async def work(own):
        number.set(own)
        await asyncio.sleep(0)
        assert number.get() == own
        assert await asyncio.to_thread(number.get) == own
        await asyncio.sleep(0)
        return number.get()

    async def scenario():
        return await asyncio.gather(*[work(own) for own in range(1, 5)])

    assert run(scenario()) == [1, 2, 3, 4]
    assert number.get() == 0


def test_several_loops_run_at_once():
    async def scenario(number):
        own = asyncio.get_running_loop()
        for _ in range(10):
            await asyncio.sleep(0)
            await asyncio.to_thread(yield_turn)
            assert asyncio.get_running_loop() is own
            assert asyncio.current_task().get_name() == str(number)
        return number

    def of_one(number):
        async def named():
            return await asyncio.create_task(scenario(number), name=str(number))

        return asyncio.run(named(), loop_factory=EventLoop)

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(of_one, range(4))) == [0, 1, 2, 3]
    with pytest.raises(RuntimeError):
        asyncio.get_running_loop()


def test_a_loop_that_is_never_idle_leaves_turns_to_others():
    other = threading.Event()

    async def scenario():
        threading.Thread(target=other.set).start()
        while not other.is_set():
            await asyncio.sleep(0)  # there is always something to do

    run(scenario())


def test_a_wake_up_amid_a_run_is_not_lost():
    async def scenario():
        loop, came = asyncio.get_running_loop(), asyncio.Event()
        loop.call_soon_threadsafe(came.set)
        yield_turn()  # the whole loop stands
        await came.wait()

    run(scenario())


def test_what_is_left_at_the_end_is_ended():
    ended = []

    async def numbers():
        try:
            yield 1
        finally:
            await asyncio.sleep(0)
            ended.append("generator")

    async def for_ever():
        try:
            await asyncio.Event().wait()
        finally:
            ended.append("task")

    async def scenario():
        left = asyncio.create_task(for_ever())
        await asyncio.sleep(0)
        generator = numbers()
        await anext(generator)
        await asyncio.to_thread(time.sleep, 0)
        return left, generator

    run(scenario())
    assert sorted(ended) == ["generator", "task"]
