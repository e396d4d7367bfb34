"""`mikas.browser.green_threads` through what is made of it: Python's own `threading` and above.

Order is made by locks and events; a time limit is only waited for where it is what is tested.
"""

from __future__ import annotations

import _thread
import gc
import queue
import sys
import threading
import time
from concurrent.futures import CancelledError, ThreadPoolExecutor, wait

import pytest
from pyodide.code import run_js
from pyodide.ffi import JsException

from mikas.browser.suspension import get_ident, suspend, yield_turn

SHORT = 0.01  # s; what is waited for never comes
LONG = 60


def run(*functions):
    """Each on a thread of its own, until all have ended; what they return."""
    results = [None] * len(functions)

    def into(place, function):
        results[place] = function()

    threads = [
        threading.Thread(target=into, args=(place, function))
        for place, function in enumerate(functions)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return results


@pytest.mark.parametrize("make", [threading.Lock, threading.RLock, _thread.allocate_lock])
def test_a_lock_is_held_by_one(make):
    lock, inside, most = make(), 0, 0

    def work():
        nonlocal inside, most
        for _ in range(20):
            with lock:
                inside += 1
                most = max(most, inside)
                yield_turn()
                inside -= 1

    run(*[work] * 5)
    assert most == 1


def test_who_has_waited_longest_gets_the_lock():
    lock, got = threading.Lock(), []

    def work(number):
        with lock:
            got.append(number)

    lock.acquire()
    threads = [threading.Thread(target=work, args=(number,)) for number in range(5)]
    for thread in threads:
        thread.start()
    yield_turn()
    assert got == []
    lock.release()
    assert not lock.acquire(blocking=False)  # it is handed over, not free
    for thread in threads:
        thread.join()
    assert got == [0, 1, 2, 3, 4]


def test_a_lock_that_is_held_is_waited_for_as_long_as_said():
    lock = threading.Lock()
    assert lock.acquire()
    assert lock.locked()
    assert not lock.acquire(timeout=0)
    assert not lock.acquire(blocking=False)
    assert not lock.acquire(timeout=SHORT)
    lock.release()
    assert lock.acquire(timeout=SHORT)  # nobody who gave up is still in the row
    lock.release()
    assert not lock.locked()
    with pytest.raises(RuntimeError):
        lock.release()


def test_a_lock_is_given_in_time_again_and_again():
    """Whoever gives up and whoever releases meet in every order."""
    lock, kept = threading.Lock(), []

    def work():
        for number in range(30):
            if lock.acquire(timeout=number % 3 / 1000):
                kept.append(number)
                yield_turn()
                lock.release()

    run(*[work] * 4)
    assert kept
    assert lock.acquire(blocking=False)


def test_an_rlock_belongs_to_its_thread():
    lock = threading.RLock()
    with lock, lock:
        assert run(lambda: lock.acquire(blocking=False)) == [False]

        def release():
            with pytest.raises(RuntimeError):
                lock.release()

        run(release)
    assert run(lambda: lock.acquire(blocking=False) and not lock.release()) == [True]


def test_a_condition_wakes_as_many_as_it_is_told_to():
    condition, waiting, woken = threading.Condition(), threading.Semaphore(0), []

    def work(number):
        with condition:
            waiting.release()
            condition.wait()
            woken.append(number)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for _ in threads:
        waiting.acquire()
    with condition:
        assert not condition.wait_for(lambda: False, timeout=SHORT)
        condition.notify(1)
        condition.wait_for(lambda: woken, timeout=SHORT)
    assert len(woken) == 1
    with condition:
        condition.notify_all()
    for thread in threads:
        thread.join()
    assert sorted(woken) == [0, 1, 2, 3]


def test_an_event_is_waited_for_as_long_as_said():
    event = threading.Event()
    assert not event.wait(SHORT)
    assert not event.wait(0)
    assert not event.wait(-1)
    assert run(lambda: event.wait(LONG), event.set) == [True, None]
    assert event.wait(0)


def test_a_barrier_and_a_semaphore():
    barrier, places, inside, most = threading.Barrier(3), threading.Semaphore(2), 0, 0

    def work():
        nonlocal inside, most
        barrier.wait()
        with places:
            inside += 1
            most = max(most, inside)
            yield_turn()
            inside -= 1

    run(work, work, work)
    assert most == 2


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


def test_each_thread_has_its_own_number_name_and_values():
    own = threading.local()
    own.value = "main"

    def work():
        assert not hasattr(own, "value")
        own.value = get_ident()
        yield_turn()
        assert own.value == get_ident() == threading.get_ident() == _thread.get_ident()
        return threading.current_thread().ident, threading.current_thread().name

    here = threading.current_thread()
    seen = run(*[work] * 5)
    assert len(set(seen)) == 5
    assert own.value == "main"
    assert threading.current_thread() is here
    assert all(ident not in threading._active for ident, _ in seen)


def test_a_thread_is_joined_once_it_has_ended():
    gate = threading.Event()
    thread = threading.Thread(target=gate.wait)
    with pytest.raises(RuntimeError):
        thread.join()
    thread.start()
    assert thread.is_alive()
    thread.join(SHORT)
    assert thread.is_alive()
    gate.set()
    thread.join()
    assert not thread.is_alive()
    thread.join()  # again, at once
    with pytest.raises(RuntimeError):
        thread.start()
    with pytest.raises(RuntimeError):
        threading.current_thread().join()


def test_an_exception_ends_its_thread_alone(monkeypatch):
    seen = []
    monkeypatch.setattr(threading, "excepthook", lambda args: seen.append(args.exc_value))

    def broken():
        yield_turn()
        raise ValueError("the bug of this test")

    def ended():
        raise SystemExit(3)

    assert run(broken, lambda: "well", ended)[1] == "well"
    assert [str(error) for error in seen if not isinstance(error, SystemExit)] == [
        "the bug of this test"
    ]


def test_a_bare_thread_says_its_error(monkeypatch):
    seen, over = [], threading.Event()
    monkeypatch.setattr(sys, "excepthook", lambda _, error, __: (seen.append(error), over.set()))
    assert _thread.start_new_thread(divmod, (1, 0)) != get_ident()
    over.wait()
    assert isinstance(seen[0], ZeroDivisionError)


def test_an_exception_is_where_it_was_after_a_wait():
    """What `raise` and `sys.exc_info` see is of the thread, not of who ran meanwhile."""

    def work(number):
        for _ in range(10):
            try:
                raise ValueError(number)
            except ValueError:
                yield_turn()
                assert sys.exc_info()[1].args == (number,)
                try:
                    raise
                except ValueError as again:
                    assert again.args == (number,)
        assert sys.exc_info()[1] is None

    run(*[lambda number=number: work(number) for number in range(5)])


def test_threads_that_wake_each_other_leave_turns_to_the_browser():
    rung, one, other = threading.Event(), threading.Semaphore(0), threading.Semaphore(0)
    threading.Thread(target=rung.set).start()

    def answer():
        while not rung.is_set():
            one.acquire()
            other.release()

    thread = threading.Thread(target=answer)
    thread.start()
    while not rung.is_set():
        one.release()
        other.acquire()
    one.release()
    thread.join()


def test_what_is_waited_for_may_fail():
    # Fields of an object: of a promise that is returned, Pyodide makes a future of its loop.
    promises = run_js("""
        const failed = Promise.reject(new Error("no port"))
        const odd = Promise.reject("no error")
        for (const it of [failed, odd]) it.catch(() => {})
        ;({ failed, odd, kept: Promise.resolve(7) })
    """)
    with pytest.raises(JsException, match="no port"):
        suspend(promises.failed)
    with pytest.raises(RuntimeError, match="no error"):
        suspend(promises.odd)
    assert run(lambda: suspend(promises.kept)) == [7]


def test_sleep_sleeps():
    before = time.perf_counter()
    time.sleep(SHORT)
    assert time.perf_counter() - before > SHORT * 0.9
    time.sleep(0)
    with pytest.raises(ValueError, match="negative"):
        time.sleep(-1)


def test_a_timer_may_be_cancelled():
    rung = threading.Event()
    late = threading.Timer(LONG, rung.set)
    late.start()
    late.cancel()
    late.join()
    assert not rung.is_set()
    threading.Timer(0, rung.set).start()
    assert rung.wait(LONG)


class Knot:
    """Garbage that only the collector finds; `gone` counts."""

    gone = 0

    def __init__(self):
        self.own = self

    def __del__(self):
        Knot.gone += 1


def test_many_deep_stacks_while_garbage_is_collected():
    """Frames of suspended stacks hold objects that the collector must neither miss nor take.

    Each level goes through a function in C, so the stacks of WebAssembly are deep, too.
    """
    count, depth, rounds = 40, 150, 5
    Knot.gone = 0
    stop = threading.Event()

    def descend(level, seen):
        held = [level, {"of": level}, Knot]
        if level:
            [result] = map(descend, [level - 1], [[*seen[-3:], held]])
        else:
            result = 0
            for _ in range(rounds):
                Knot()
                yield_turn()
                result += 1
        assert held == [level, {"of": level}, Knot]
        return result

    def collect():
        while not stop.is_set():
            gc.collect(0)
            yield_turn()
            gc.collect()
            yield_turn()

    collector = threading.Thread(target=collect)
    collector.start()
    try:
        assert run(*[lambda: descend(depth, [])] * count) == [rounds] * count
    finally:
        stop.set()
        collector.join()
    gc.collect()
    assert Knot.gone == count * rounds


def test_generators_and_context_managers_span_waits():
    lock = threading.Lock()

    def numbers():
        with lock:
            for number in range(5):
                yield_turn()
                yield number

    def work():
        return sum(numbers())

    assert run(*[work] * 6) == [10] * 6
    assert not lock.locked()


@pytest.mark.parametrize(
    "through", [lambda call: call(), lambda call: min([0], key=lambda _: call())]
)
def test_too_deep_a_recursion_is_an_error_of_its_thread(through):
    def descend(level):
        return through(lambda: descend(level + 1)) + 1

    def work():
        with pytest.raises(RecursionError):
            descend(0)
        yield_turn()
        return "alive"

    assert run(work, work) == ["alive", "alive"]
