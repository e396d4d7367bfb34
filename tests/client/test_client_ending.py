"""A call ends early between two exchanges: its deadline, a cancelled task, a closed connection."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from client_harness import METHODS, STREAMS, bench, by_worker, ecu_on, lines

from mikas.cancellation import Cancellation, Cancelled
from mikas.client import AsyncEcu
from mikas.errors import DeadlinePassed, LinkClosed, LinkLost, MikasError, UsageError
from virtual_harness import DATA

ONE_EXCHANGE = 1.0  # s: the longest that may follow a deadline
LONG = {
    "block": lambda ecu, **how: ecu.memory.code.read_block(0, 0x10000, **how),
    "info": lambda ecu, **how: ecu.info(**how),
    "write": lambda ecu, **how: ecu.memory.xram.write_block(0, bytes(2048), **how),
}
SHORT = {
    "read": lambda ecu, **how: ecu.read(**how),
    "passport": lambda ecu, **how: ecu.passport(again=True, **how),
    "set_list": lambda ecu, **how: ecu.set_list("TWAT", **how),
    "read_list": lambda ecu, **how: ecu.read_list("TWAT", **how),
    "parameter": lambda ecu, **how: ecu.write_parameter("SSM", 30, **how),
    "faults": lambda ecu, **how: ecu.faults(**how),
    "speed": lambda ecu, **how: ecu.engine_speed(**how),
    "erase": lambda ecu, **how: ecu.erase_faults(**how),
    "goto": lambda ecu, **how: ecu.goto(0x8000, **how),
    "raw": lambda ecu, **how: ecu.raw(b"\x01", **how),
    "byte": lambda ecu, **how: ecu.memory.ram.read(0x40, **how),
    "write byte": lambda ecu, **how: ecu.memory.ram.write(0x40, 1, **how),
}


def in_step(ecu):
    """Whether the next answers belong to their requests, without a resynchronization."""
    before = ecu.tester.sync.found_again
    assert ecu.read("TWAT")["TWAT"].raw == DATA[0x1A]
    assert ecu.memory.ram.read(0x40) == ecu.memory.ram.read(0x40)
    return ecu.tester.sync.found_again == before


@pytest.mark.parametrize("name", LONG)
def test_a_deadline_ends_a_long_call_and_leaves_the_line_in_step(name):
    ecu = ecu_on(bench(), confirm=lambda _: True)
    began = ecu.tester.link.now()
    with pytest.raises(DeadlinePassed, match=r"given 0\.05 s") as caught:
        LONG[name](ecu, timeout=0.05)
    assert isinstance(caught.value, TimeoutError)
    assert isinstance(caught.value, MikasError)
    assert 0.05 <= ecu.tester.link.now() - began < 0.05 + ONE_EXCHANGE
    assert in_step(ecu)


@pytest.mark.parametrize("name", LONG | SHORT)
def test_without_any_time_nothing_is_sent(name):
    it = bench()
    ecu = ecu_on(it, confirm=lambda _: True)
    with pytest.raises(DeadlinePassed):
        (LONG | SHORT)[name](ecu, timeout=0)
    assert it.requests() == []
    assert in_step(ecu)


@pytest.mark.parametrize("name", LONG | SHORT)
@pytest.mark.parametrize("timeout", [-1, float("nan"), float("inf"), "1", True])
def test_a_wrong_timeout_is_refused(name, timeout):
    it = bench()
    with pytest.raises(UsageError, match="timeout"):
        (LONG | SHORT)[name](ecu_on(it, confirm=lambda _: True), timeout=timeout)
    assert it.requests() == []


@pytest.mark.parametrize("name", SHORT)
def test_enough_time_changes_nothing(name):
    ecu = ecu_on(bench(), confirm=lambda _: True)
    if name == "read_list":
        ecu.set_list("TWAT")
    SHORT[name](ecu, timeout=60)
    with pytest.raises(DeadlinePassed):  # the deadline of one call is none of the next one's
        ecu.memory.code.read_block(0, 0x10000, timeout=0.1)
    assert len(ecu.memory.code.read_block(0, 512)) == 512


def test_a_deadline_during_a_change_is_journalled(tmp_path):
    ecu = ecu_on(bench(), confirm=lambda _: True, journal=tmp_path / "journal")
    before = ecu.memory.xram.read_block(0, 2048)
    began = ecu.tester.link.now()
    ecu.memory.xram.write_block(0, before)
    enough = ecu.tester.link.now() - began
    with pytest.raises(DeadlinePassed):
        ecu.memory.xram.write_block(0, before, timeout=enough * 0.6)
    assert [entry["state"] for entry in lines(tmp_path / "journal")][-2:] == ["started", "failed"]


def test_the_earlier_of_two_deadlines_holds():
    ecu = ecu_on(bench())
    with ecu.tester.within(0.1), pytest.raises(DeadlinePassed, match=r"0\.1 s"):
        ecu.memory.code.read_block(0, 0x10000, timeout=30)
    with ecu.tester.within(30):
        with pytest.raises(DeadlinePassed, match=r"0\.1 s"):
            ecu.memory.code.read_block(0, 0x10000, timeout=0.1)
        assert ecu.read("TWAT")


def test_another_threads_call_has_a_deadline_of_its_own():
    ecu = ecu_on(bench())
    with ecu.tester.within(0), ThreadPoolExecutor(1) as threads:
        assert threads.submit(ecu.read, "TWAT").result()["TWAT"].raw == DATA[0x1A]


def at_request(it, number, act):
    """Call `act` in the middle of the request of this number."""
    write, sent = it.link.write, []

    def heard(data):
        write(data)
        sent.append(data)
        if len(sent) == number:
            act()

    it.link.write = heard
    return sent


def test_a_cancelled_sync_call_ends_before_its_next_exchange():
    it = bench()
    ecu = ecu_on(it)
    cancellation = Cancellation()
    sent = at_request(it, 3, cancellation.request)
    with pytest.raises(Cancelled):
        cancellation.run(lambda: ecu.memory.code.read_block(0, 0x10000))
    assert len(sent) == 3
    assert in_step(ecu)


@pytest.mark.parametrize("name", LONG)
def test_a_cancelled_task_frees_the_line_after_one_exchange(name):
    it = bench()

    async def scene():
        async with by_worker(it, confirm=lambda _: True) as ecu:
            loop, cancelled = asyncio.get_running_loop(), threading.Event()
            begun = threading.Event()

            def cancel():
                assert begun.wait(30)
                loop.call_soon_threadsafe(task.cancel)
                assert cancelled.wait(30)

            sent = at_request(it, 3, cancel)
            task = asyncio.ensure_future(LONG[name](ecu))
            begun.set()
            with pytest.raises(asyncio.CancelledError):
                await task
            await asyncio.sleep(0)
            cancelled.set()
            assert (await ecu.read("TWAT"))["TWAT"].raw == DATA[0x1A]
            assert len(sent) == 4
            assert await ecu.run(lambda: in_step(ecu.ecu))

    asyncio.run(scene())


def test_asyncio_timeout_ends_the_call():
    async def scene():
        async with await AsyncEcu.connect("sim:") as ecu:
            before = (await ecu.read("TWAT"))["TWAT"].raw
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(0.1):
                    await ecu.memory.code.read_block(0, 0x10000)
            began = ecu.ecu.tester.link.now()
            assert (await ecu.read("TWAT"))["TWAT"].raw == before
            assert ecu.ecu.tester.link.now() - began < 20  # s; the block takes 72

    asyncio.run(scene())


def test_close_ends_what_another_task_waits_for():
    it = bench()

    async def scene():
        async with by_worker(it) as ecu:
            loop, closed = asyncio.get_running_loop(), threading.Event()
            reached = asyncio.Event()

            def close():
                loop.call_soon_threadsafe(reached.set)
                assert closed.wait(30)

            sent = at_request(it, 3, close)
            reading = asyncio.ensure_future(ecu.memory.code.read_block(0, 0x10000))
            waiting = asyncio.ensure_future(ecu.read("TWAT"))
            await reached.wait()
            closing = asyncio.ensure_future(ecu.close())
            await asyncio.sleep(0)
            closed.set()
            await closing
            for each in (reading, waiting):
                with pytest.raises(LinkLost, match="is closed"):
                    await each
            assert len(sent) == 3

    asyncio.run(scene())


def test_close_in_another_thread_ends_a_sync_call():
    it = bench()
    ecu = ecu_on(it)
    at_request(it, 3, ecu.tester.end_calls)
    with pytest.raises(LinkLost, match="is closed"):
        ecu.memory.code.read_block(0, 0x10000)


def test_a_cancelled_close_closes_the_port_all_the_same():
    it = bench()

    async def scene():
        async with by_worker(it) as ecu:
            reached, go_on = asyncio.Event(), threading.Event()
            loop = asyncio.get_running_loop()

            def pause():
                loop.call_soon_threadsafe(reached.set)
                assert go_on.wait(30)

            at_request(it, 3, pause)
            reading = asyncio.ensure_future(ecu.memory.code.read_block(0, 0x10000))
            await reached.wait()
            closing = asyncio.ensure_future(ecu.close())
            await asyncio.sleep(0)
            closing.cancel()
            with pytest.raises(asyncio.CancelledError):
                await closing
            go_on.set()
            with pytest.raises(LinkClosed):
                await reading
            await ecu.close()  # waits for the first one
            with pytest.raises(LinkClosed):
                it.link.write(b"\x01")

    asyncio.run(scene())


def test_a_task_that_is_cancelled_again_and_again_ends_its_stream_all_the_same():
    it = bench()

    async def scene():
        async with by_worker(it) as ecu:

            async def streaming():
                async with ecu.stream("FREQ", "TWAT") as stream:
                    await anext(stream)
                    begun.set()
                    async for _ in stream:
                        pass

            begun = asyncio.Event()
            task = asyncio.ensure_future(streaming())
            await begun.wait()
            while not task.done():
                task.cancel()
                await asyncio.sleep(0)
            assert await ecu.read("TWAT")

    asyncio.run(scene())


@pytest.mark.parametrize("method", STREAMS)
@pytest.mark.parametrize("names", [["FREQ", "TWAT"], ["TWAT"]])
def test_close_ends_a_stream_within_a_second(method, names):
    it = bench()
    ecu = ecu_on(it)
    samples = ecu.watch(*names, method=method)
    for _ in range(3):
        next(samples)
    began = ecu.tester.link.now()
    ecu.close()
    assert ecu.tester.link.now() - began < ONE_EXCHANGE
    assert [each.kind for each in it.happenings].count("stream-end") == 1
    with pytest.raises(LinkClosed):
        next(samples)


@pytest.mark.parametrize("method", METHODS)
def test_a_watch_ends_with_the_reason_if_another_thread_closes(method):
    ecu = ecu_on(bench())
    samples = ecu.watch("FREQ", "TWAT", method=method)
    assert next(samples).readings
    with ThreadPoolExecutor(1) as threads:
        closing = threads.submit(ecu.close)
        with pytest.raises(LinkClosed):
            for _ in samples:
                pass
        closing.result()


def test_a_stream_ends_with_the_reason_if_another_thread_closes():
    ecu = ecu_on(bench())
    with ThreadPoolExecutor(1) as threads, ecu.stream("FREQ") as stream:
        next(stream)
        closing = threads.submit(ecu.close)
        with pytest.raises(LinkClosed):
            for _ in stream:
                pass
    closing.result()
