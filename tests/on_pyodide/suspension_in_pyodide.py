"""Stacks that `mikas.browser.suspension` suspends, and what must not be lost meanwhile."""

from __future__ import annotations

import gc
import sys
import threading

import pytest
from pyodide.code import run_js
from pyodide.ffi import JsException

from mikas.browser.suspension import suspend, yield_turn

from .threads_rig import run


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


class Knot:
    """Garbage that only the collector finds; `gone` counts."""

    gone = 0

    def __init__(self):
        self.own = self

    def __del__(self):
        Knot.gone += 1


def test_many_deep_stacks_survive_the_collection_of_garbage():
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

    gc.freeze()  # what was there before, as on the site; else each look takes half a second
    collector = threading.Thread(target=collect)
    collector.start()
    try:
        assert run(*[lambda: descend(depth, [])] * count) == [rounds] * count
    finally:
        stop.set()
        collector.join()
        gc.unfreeze()
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
