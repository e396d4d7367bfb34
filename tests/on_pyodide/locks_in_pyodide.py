"""Locks of `mikas.browser.green_threads`, and what Python's `threading` makes of them."""

from __future__ import annotations

import _thread
import threading

import pytest

from mikas.browser.suspension import yield_turn

from .threads_rig import LONG, SHORT, run


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


def test_a_barrier_gathers_and_a_semaphore_limits():
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
