"""What holds for every test: hypothesis' examples, what is collected, and Ctrl-C."""

from __future__ import annotations

import gc
import itertools
import os
import signal
import sys
import tempfile
import threading
from pathlib import Path

import pytest
from hypothesis import settings

# A pty exists on POSIX only. What needs one stands in a folder `posix`, or a module named so, and
# is not even imported elsewhere. (The marks match `/` too; they are relative to this folder.)
collect_ignore_glob = [] if os.name == "posix" else ["*posix*"]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Drop the single tests that need POSIX, too."""
    if os.name != "posix":
        items[:] = [item for item in items if item.get_closest_marker("posix") is None]


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Look for no garbage in what stays: it was a quarter of the time before the first test."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        if enabled:  # not in Pyodide (mikas.browser.start)
            gc.enable()


def pytest_unconfigure():
    """Take what stayed with the rest again: some libraries complain about it at the exit."""
    gc.unfreeze()


# A shared machine may stall for a second: no test is judged by its time. `ci` draws the same
# examples every time, so a red build is the change's fault.
settings.register_profile("default", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))

# What a shell starts in the background ignores Ctrl-C, and so would all that the tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


# What tests learn and change is not the user's: a folder for the process, and one for each test.
_STATE = tempfile.TemporaryDirectory(prefix="mikas-tests-", ignore_cleanup_errors=True)
os.environ["MIKAS_STATE"] = _STATE.name
_count = itertools.count()


@pytest.fixture(autouse=True)
def state_folder(monkeypatch):
    """The state folder of this test alone, not made yet."""
    folder = Path(_STATE.name) / str(next(_count))
    monkeypatch.setenv("MIKAS_STATE", str(folder))
    return folder


@pytest.fixture(autouse=True)
def said():
    """What the program says of things that it can't keep: in this test, and no other."""
    from mikas import unkept

    sentences = []
    with unkept.said_to(sentences.append):
        yield sentences


@pytest.fixture(autouse=True)
def english():
    """The language of messages, which another test of this process may have changed."""
    if language := sys.modules.get("mikas.cli.language"):
        language.set_language("en")


@pytest.fixture
def begun(monkeypatch):
    """The threads that this test's own thread begins: those of other tests may begin and end."""
    threads, start, own = [], threading.Thread.start, threading.current_thread()

    def recorded(thread):
        start(thread)
        if threading.current_thread() is own:
            threads.append(thread)

    monkeypatch.setattr(threading.Thread, "start", recorded)
    return threads


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config):
    """`-n auto`: two workers for each core, because tests in real time wait most of their time.

    `-n logical`: as many as cores, for tests that never wait.
    """
    return (os.cpu_count() or 1) * (2 if config.option.numprocesses == "auto" else 1)
