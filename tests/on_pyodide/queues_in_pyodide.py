"""Queues and pools of threads on `mikas.browser.green_threads`: Python's own."""

from __future__ import annotations

import queue
import threading
from concurrent.futures import CancelledError, ThreadPoolExecutor, wait

import pytest

from .threads_rig import SHORT, run


@pytest.mark.parametrize("make", [queue.Queue, queue.LifoQueue, queue.SimpleQueue])
def test_a_queue_hands_over_everything_once(make):
    line = make()
    with pytest.raises(queue.Empty):
        line.get(timeout=SHORT)
    with pytest.raises(queue.Empty):
        line.get(block=False)

    def put():
        for number in range(100):
            line.put(number)

    def take():
        return [line.get() for _ in range(100)]

    got = run(take, put, take, put)
    assert sorted(got[0] + got[2]) == sorted([*range(100)] * 2)


def test_a_full_queue_is_waited_for():
    line = queue.Queue(1)
    line.put(1)
    with pytest.raises(queue.Full):
        line.put(2, timeout=SHORT)
    assert run(lambda: line.put(2), lambda: [line.get(), line.get()])[1] == [1, 2]


def test_a_pool_works_cancels_and_closes():
    gate, begun = threading.Event(), threading.Event()

    def hold():
        begun.set()
        gate.wait()
        return "held"

    with ThreadPoolExecutor(1) as pool:
        first, second = pool.submit(hold), pool.submit(hold)
        begun.wait()
        assert second.cancel()
        assert not first.cancel()
        with pytest.raises(TimeoutError):
            first.result(timeout=SHORT)
        gate.set()
        assert first.result() == "held"
        with pytest.raises(CancelledError):
            second.result()
    with pytest.raises(RuntimeError):
        pool.submit(hold)


def test_the_work_of_a_pool_raises_where_it_is_awaited():
    with ThreadPoolExecutor(8) as pool:
        done = [pool.submit(divmod, 7, number) for number in range(3)]
        wait(done)
        with pytest.raises(ZeroDivisionError):
            done[0].result()
        assert [each.result() for each in done[1:]] == [(7, 0), (3, 1)]
        assert list(pool.map(abs, range(-50, 0))) == list(range(50, 0, -1))
