"""pytest in Pyodide: `run.mjs` calls `prepare`, then `run`."""

from __future__ import annotations

import asyncio
import gc
import sys
from functools import partial
from importlib.machinery import PathFinder
from threading import Thread
from types import ModuleType, SimpleNamespace

from mikas.browser import start
from mikas.browser.event_loop import EventLoop

OPTIONS = (
    "-p", "no:cacheprovider", "-p", "no:doctest", "-p", "no:faulthandler", "-p", "no:junitxml",
    "--rootdir=/repository", "--config-file=/repository/pyproject.toml",
    "--no-header", "--capture=sys", "--tb=short", "-vv",
    "-W", "ignore::pydantic.warnings.UnsupportedFieldAttributeWarning",  # as `start.prepare`
)  # fmt: skip


def prepare(waits, run_sync):
    """Put the browser's threads and arrays in place, as the site does, before all else."""
    start.prepare(waits, run_sync)
    # It has a part in Rust, and no wheel for Pyodide; the tests' own conftest.py sets it up.
    stub = ModuleType("hypothesis")
    stub.settings = SimpleNamespace(register_profile=_nothing, load_profile=_nothing)
    sys.modules["hypothesis"] = stub
    sys.meta_path.append(RestOfLibrary)


class RestOfLibrary:
    """Finds what the site leaves out of the standard library, and only tests need."""

    @staticmethod
    def find_spec(name, _path=None, target=None):
        folder = "/".join(("/tools/stdlib.zip", *name.split(".")[:-1]))
        return PathFinder.find_spec(name, [folder], target)


def _nothing(*_, **__):
    pass


class EachTest:
    """Watches the time of each test, and collects garbage as the site does."""

    def __init__(self, watch):
        self._watch = watch

    def pytest_runtest_logstart(self, nodeid):
        self._watch(nodeid)

    def pytest_runtest_logfinish(self):
        gc.collect(0)

    def pytest_fixture_post_finalizer(self, fixturedef):
        if fixturedef.scope == "module":
            gc.collect()


def run(watch, options):
    """Run pytest, on a thread; return its exit code. `watch` is told each test as it begins."""
    import pytest

    import arrays.without_numpy  # noqa: F401  (what tests take from numpy)

    # As on the site: not on Pyodide's own loop, which the main thread is in.
    asyncio.run = partial(asyncio.run, loop_factory=EventLoop)
    result = []
    arguments = [*OPTIONS, *options]
    thread = Thread(target=lambda: result.append(pytest.main(arguments, plugins=[EachTest(watch)])))
    thread.start()
    thread.join()
    return int(result[0])
