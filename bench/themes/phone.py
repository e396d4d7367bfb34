"""The page on a phone, its cable by WebUSB: first value, stream, memory."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any

from bench.plain_browser import PlainPage, plain_browser
from bench.rows import Row, Scope, Theme
from bench.site_rig import FLAGS, SiteBench, missing, site_bench

if TYPE_CHECKING:
    from playwright.sync_api import Page

_PHONE: dict[str, Any] = {
    "user_agent": "Mozilla/5.0 (Linux; Android 14; K) AppleWebKit/537.36 (KHTML, like Gecko) "
    "Chrome/156.0.0.0 Mobile Safari/537.36",
    "viewport": {"width": 412, "height": 840}, "device_scale_factor": 2,
    "has_touch": True, "is_mobile": True,
}  # fmt: skip
_CHIP = "FT232R"
_PERIOD = 0.02  # s
_LOOK = 10  # periods until the processes are looked for again
_IDLE = 65  # s: the reader has ended by then
_STREAM = 35.0  # sets/s that the wire carries: docs/protocol.md, §5

_METHOD = f"""\
`make site` in Chromium without a window, with a phone's name, size and touch. The cable is a model
of an {_CHIP} in a USB socket of its computer: Chromium's own WebUSB, with a virtual unit behind it,
in this process."""
_VALUE = """\
from the navigation of a second visit, all files kept by the service worker, to the first value on
the screen; a cable that the browser remembers is connected to without a touch;"""
_THROTTLED = "the page's own thread at a quarter of its speed (`Emulation.setCPUThrottlingRate`)."
_STOPPED = "all threads of the page's process, its workers too, stopped three quarters of the time."
_PSS = """\
Pss of the page's process, with all its workers, after a collection of their garbage; without
Playwright, for which the browser would keep the bytes of all files there. Beside it: before the
collection, which Chromium itself puts off while the computer has memory."""
_HAS_VALUE = """\
[...document.querySelectorAll("#screen [data-value]")].some((it) => /[0-9]/.test(it.textContent))"""


def run(scope: Scope) -> Iterator[Theme]:
    lacking = missing()
    if not lacking:
        from static_site import usb_sockets_rig

        lacking = usb_sockets_rig.missing()
    if lacking:
        print(f"phone: nothing was measured: {lacking}", file=sys.stderr)
        return
    with site_bench() as bench, _cable(bench):
        rows = _first(bench, scope)
        rows += _memory(bench, scope)
    yield Theme("The page on a phone", _METHOD, rows)


@contextmanager
def _cable(bench: SiteBench) -> Iterator[None]:
    from static_site.usb_sockets_rig import UsbSockets, usb_cable

    sockets = UsbSockets(bench.computer)
    try:
        with TemporaryDirectory() as folder, usb_cable(sockets, Path(folder), _CHIP):
            yield
    finally:
        sockets.close()


def _first(bench: SiteBench, scope: Scope) -> list[Row]:
    runs, seconds = scope.of(5, 1), scope.of(30, 10)
    values: dict[str, list[float]] = {"throttled": [], "stopped": []}
    with bench.page(**_PHONE) as page:
        page.wait_for_function("() => navigator.serviceWorker?.controller != null")
        devtools = page.context.new_cdp_session(page)
        for _ in range(runs):
            devtools.send("Emulation.setCPUThrottlingRate", {"rate": 4})
            values["throttled"].append(_value(bench, page))
            devtools.send("Emulation.setCPUThrottlingRate", {"rate": 1})
            with _slowed():
                values["stopped"].append(_value(bench, page))
                sets = _sets(page, seconds)
    return [
        Row("first value, a quarter of the speed", values["throttled"], "s", 1, at_most=6,
            how=f"{_VALUE} {_THROTTLED}"),
        Row("first value, stopped three quarters of the time", values["stopped"], "s", 1,
            at_most=12, how=_STOPPED),
        Row("stream, stopped three quarters of the time", [100 * sets / _STREAM], "%", 1,
            at_least=95, aside=f"{sets:.1f} sets/s"),
    ]  # fmt: skip


def _value(bench: SiteBench, page: Page) -> float:
    page.goto("about:blank")
    began = perf_counter()
    page.goto(f"{bench.url}#/live")
    page.wait_for_function(f"() => {_HAS_VALUE}", polling="raf")
    return perf_counter() - began


def _sets(page: Page, seconds: int) -> float:
    """Sets a second, after some time for the method."""
    page.wait_for_timeout(8000)
    before = _state(page)
    page.wait_for_timeout(1000 * seconds)
    after = _state(page)
    sets: float = (after["samples"] - before["samples"]) / (after["now"] - before["now"])
    return sets


def _state(page: Page) -> dict[str, Any]:
    state: dict[str, Any] = page.evaluate("async () => (await fetch('api/state')).json()")
    return state


def _memory(bench: SiteBench, scope: Scope) -> list[Row]:
    with _started_again(bench) as page:
        page.send("Page.navigate", url=f"{bench.url}#/live")
        page.wait_for(_HAS_VALUE)
        page.press("Record")
        sleep(scope.of(60, 10))
        page.press("Stop recording")
        live = _in_use(page)
        page.evaluate("location.hash = '/recordings'")
        page.press("Open")
        page.wait_for("document.querySelector('[aria-label=Player]')")
        sleep(3)
        reading = _in_use(page)
        page.press("More player controls")
        page.press("Close the recording")
        page.evaluate("location.hash = '/live'")
        sleep(_IDLE)
        after, workers = _in_use(page), _workers()
    return [
        Row("memory in use, live and recording", [live[0]], "MiB", 0, at_most=250,
            aside=f"{live[1]:.0f} MiB before", how=_PSS),
        Row("memory in use, a recording opened", [reading[0]], "MiB", 0,
            aside=f"{reading[1]:.0f} MiB before"),
        Row("memory in use, a minute later", [after[0]], "MiB", 0, at_most=250,
            aside=f"{after[1]:.0f} MiB before; {workers} worker"),
    ]  # fmt: skip


def _in_use(page: PlainPage) -> tuple[float, float]:
    """MiB after a collection of garbage, and before it."""
    before = _pss()
    page.collect_garbage()
    sleep(1)  # freed pages go back to the system a little later
    return _pss(), before


@contextmanager
def _started_again(bench: SiteBench) -> Iterator[PlainPage]:
    """The page of a browser that has just been started, and has kept the files of the site."""
    with TemporaryDirectory() as folder:
        started = (bench.program, Path(folder), FLAGS, _PHONE)
        with plain_browser(*started) as page:
            page.send("Page.navigate", url=bench.url)
            page.wait_for("navigator.serviceWorker?.controller != null")
        with plain_browser(*started) as page:
            yield page


def _renderers() -> list[int]:
    """The processes of this process' browser that show pages."""
    parents, shown = {}, []
    for process in Path("/proc").iterdir():
        if process.name.isdigit():
            with suppress(OSError):
                stat = (process / "stat").read_text("utf-8").rpartition(")")[2].split()
                parents[int(process.name)] = int(stat[1])
                if b"--type=renderer" in (process / "cmdline").read_bytes():
                    shown.append(int(process.name))
    return [it for it in shown if os.getpid() in _line(it, parents)]


def _line(process: int, parents: dict[int, int]) -> Iterator[int]:
    """Yield the process' parent, that one's parent, and so on."""
    while above := parents.get(process):
        yield above
        process = above


def _pss() -> float:
    """MiB of the largest one: the page's. Others are empty, kept for the next page."""
    found = []
    for process in _renderers():
        with suppress(OSError):
            text = Path(f"/proc/{process}/smaps_rollup").read_text("ascii")
            found.append(int(text.partition("\nPss:")[2].split()[0]) / 1024)
    return max(found)


def _workers() -> int:
    """The workers of all pages, by the names of their threads."""
    tasks = (it for process in _renderers() for it in Path(f"/proc/{process}/task").iterdir())
    return sum((it / "comm").read_text("utf-8").startswith("DedicatedWorker") for it in tasks)


@contextmanager
def _slowed() -> Iterator[None]:
    """Let the page's process run a quarter of the time, all its threads."""
    over = threading.Event()

    def stop_and_go() -> None:
        while not over.is_set():
            running = _renderers()  # another page may have another one
            for _ in range(_LOOK):
                for sent, part in ((signal.SIGSTOP, 0.75), (signal.SIGCONT, 0.25)):
                    for process in running:
                        with suppress(ProcessLookupError):
                            os.kill(process, sent)
                    sleep(_PERIOD * part)

    thread = threading.Thread(target=stop_and_go)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
