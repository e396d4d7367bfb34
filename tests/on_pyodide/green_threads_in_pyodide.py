"""Threads of `mikas.browser.green_threads`, through Python's own `threading`."""

from __future__ import annotations

import _thread
import sys
import threading
import time
from concurrent.futures import Future

import pytest

from mikas.browser.suspension import get_ident, yield_turn
from mikas.cancellation import check_cancelled
from mikas.dashboard.library.lanes import WorkThread

from .threads_rig import LONG, SHORT, run


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
    assert all(ident not in threading._active for ident, _ in seen)  # noqa: SLF001


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


def test_long_work_lets_the_others_run():
    working, rung, outcome = threading.Event(), threading.Event(), Future()

    def answer():
        working.wait()
        rung.set()

    def work():
        working.set()
        while not rung.is_set():
            check_cancelled()

    threading.Thread(target=answer).start()
    WorkThread("long", work, outcome).start()
    assert outcome.result() is None


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
