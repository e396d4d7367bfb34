"""What the benchmarks of the dashboard share: a unit that counts its answers, the program as a
process of its own, and the browser.

The unit is in this process, on a paced pty: each response carries the next number in place of the
coolant's temperature, and the moment is kept when its last byte has left the wire.
"""

from __future__ import annotations

import asyncio
import json
import os
import shutil
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, cast

from bench.rig import everything
from mikas.catalog import shipped
from mikas.framing import encode
from mikas.link.clocks import WallClock
from mikas.virtual import serve
from mikas.virtual.build import build_bus
from mikas.virtual.ecu import EcuEvent

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from mikas.virtual.responder import Car

COUNTER = "TWAT"
"""A byte, shown as a whole number: byte − 40 (§4)."""
RATE = 30.0  # sets a second
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip


class CountingUnit:
    """A virtual unit on a pty. `sent`: by number, when the last byte of its response was sent."""

    def __init__(self) -> None:
        self.url = ""
        self.sent: dict[int, float] = {}
        self._count = 0
        self._told = 0
        clock = WallClock()
        self._bus = build_bus({}, start=clock.now(), watcher=self._watch)
        responder = self._bus.ecu.responder
        self._car = responder.car
        self._code = shipped().parameter(COUNTER).code
        responder.car = cast("Car", self)  # all but a few things are the car's own
        self._clock = clock

    def __getattr__(self, name: str) -> object:
        return getattr(self._car, name)

    def raw(self, code: int, now: float) -> bytes:
        """The car's datum, or the next number."""
        if code != self._code:
            return self._car.raw(code, now)
        self._count += 1
        return bytes([self._count % 256])

    def _watch(self, happening: EcuEvent) -> None:
        if happening.kind == "response" and self._count > self._told:
            self._told = self._count
            wire = len(encode(happening.data)) * self._bus.byte_time
            self.sent[self._count] = happening.time + wire

    async def serve(self, ready: threading.Event, over: asyncio.Event) -> None:
        port = serve.PtyPort(self._bus, self._clock.now)
        self.url = port.url
        ready.set()
        await over.wait()
        port.close()


@contextmanager
def counting_unit() -> Iterator[CountingUnit]:
    unit, ready, over = CountingUnit(), threading.Event(), asyncio.Event()
    loops: list[asyncio.AbstractEventLoop] = []

    async def main() -> None:
        loops.append(asyncio.get_running_loop())
        await unit.serve(ready, over)

    thread = threading.Thread(target=serve.run, args=(main(),))
    thread.start()
    ready.wait()
    try:
        yield unit
    finally:
        loops[0].call_soon_threadsafe(over.set)
        thread.join()


@dataclass(frozen=True, slots=True)
class Program:
    """`mikas dash`, sampling all parameters `RATE` times a second."""

    url: str
    process: int


@contextmanager
def program(port: str, recordings: Path | None = None) -> Iterator[Program]:
    """`recordings`: the folder of recordings; a new one by default."""
    import httpx

    with TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "mikas", "--port", port, "dash", "--no-browser", "--json"]
        with subprocess.Popen(
            [*command, "--record", str(recordings or folder)],
            env=os.environ | {"XDG_STATE_HOME": folder},
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        ) as process:
            try:
                assert process.stdout is not None
                url = json.loads(process.stdout.readline())["url"]
                plan = {
                    "wanted": [{"name": it.parameter.name} for it in everything()],
                    "method": "list",
                    "rate": RATE,
                }
                me = {"X-Mikas-Client": "benchmark-1"}
                httpx.put(f"{url}api/plan", json=plan, headers=me).raise_for_status()
                httpx.post(f"{url}api/control/release", headers=me).raise_for_status()
                yield Program(url, process.pid)
            finally:
                process.terminate()


def chromium() -> str | None:
    """The system's own, or None."""
    names = ("chromium", "chromium-browser", "google-chrome")
    return next(filter(None, map(shutil.which, names)), None)


@contextmanager
def browser() -> Iterator[Browser]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        it = playwright.chromium.launch(executable_path=chromium(), args=list(_FLAGS))
        try:
            yield it
        finally:
            it.close()


def cpu_seconds(process: int) -> float:
    """What a process has used of the processor, all its threads."""
    after_name = Path(f"/proc/{process}/stat").read_text("utf-8").rpartition(")")[2].split()
    return (int(after_name[11]) + int(after_name[12])) / os.sysconf("SC_CLK_TCK")


def browser_seconds(it: Browser) -> Counter[str]:
    """What the browser's processes have used of the processor, by kind: `renderer`, `GPU` …"""
    found = it.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    seconds = Counter[str]()
    for process in found:
        seconds[process["type"]] += process["cpuTime"]
    return seconds
