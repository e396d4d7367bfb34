"""A dashboard that is open to the network, and samples and records while clients misbehave.

The owner is at 127.0.0.1, the network at the other addresses of 127.0.0.0/8. The owner's page is
open. A finding is an error that was reported, a page that lost its connection, a gap or a missing
sample in the recording, or a connection whose place was not given back.
"""

from __future__ import annotations

import json
import logging
import math
import ssl
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final
from unittest.mock import patch

import httpx
from websockets.sync.client import connect
from websockets.sync.connection import Connection

from mikas.dashboard.app import create_app
from mikas.dashboard.connections import STALL_SECONDS
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.network.listening import listen
from mikas.dashboard.security.access import Access
from mikas.dashboard.security.certificate import own_certificate
from mikas.dashboard.server import Server
from mikas.dashboard.settings import PlanSettings, Settings
from mikas.link.clocks import WallClock
from mikas.link.virtual import RealTimeVirtualLink, follower_of
from mikas.virtual.build import build_bus

TOKEN: Final = "a-token-of-the-test"
HOST: Final = "garage"
_OWNER: Final = "127.0.0.1"
_PATIENCE: Final = 60.0
_PIECE_OF_TIME: Final = 0.02  # s that pass at most between two looks at the line's clock
_NAMES: Final = ("FREQ", "TWAT", "UACC", "INJ", "DET")
_ME: Final = {"X-Mikas-Client": "owner-0001"}
_MOST_MESSAGES: Final = 5000


class Finding(AssertionError):
    """The clients have done something to others."""


class SteadyClock(WallClock):
    """Time that does not pass while this process gets no turn: a busy machine makes no gap."""

    __slots__ = ("_lock", "_now", "_read")

    def __init__(self) -> None:
        super().__init__()
        self._lock, self._now, self._read = threading.Lock(), time.time(), time.perf_counter()
        self.date = self.now

    def now(self) -> float:
        with self._lock:
            before, self._read = self._read, time.perf_counter()
            self._now += min(self._read - before, _PIECE_OF_TIME)
            return self._now


@dataclass
class ServerClock:
    """Seconds; `passed` is added by hand."""

    passed: float = 0.0

    def __call__(self) -> float:
        return time.monotonic() + self.passed


class Reports(logging.Handler):
    """Everything that is reported, in words or with a traceback."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []
        self.setFormatter(logging.Formatter("%(name)s: %(message)s"))

    def check(self) -> None:
        """Raise what was reported, once."""
        lines, self.lines = self.lines, []
        if lines:
            raise Finding("\n".join(lines))

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(self.format(record))


@dataclass
class World:
    """`sweeps` is notified at each sweep of the server."""

    dashboard: Dashboard
    server: Server
    port: int
    tls: bool
    owner: httpx.Client
    page: Connection
    reports: Reports
    clock: ServerClock
    swept: threading.Condition = field(default_factory=threading.Condition)
    sweeps: int = 0

    def sweep(self, count: int) -> None:
        """Wait until the server has looked at its connections so many times more."""
        with self.swept:
            wanted = self.sweeps + count
            if not self.swept.wait_for(lambda: self.sweeps >= wanted, _PATIENCE):
                raise Finding("the server sweeps no more")

    def check(self) -> None:
        """Check that nothing was reported, and that the owner and its page are served."""
        self.reports.check()
        state = self.state()
        if state["line"] != "sampling" or not state["recording"]:
            raise Finding(f"{state['line']}, {state['recording']}")
        self.page.send('{"ping": "check"}')
        self._until(lambda it: it.get("pong") == "check")

    def more_samples(self, count: int) -> None:
        """Wait until so many more samples came to the page."""
        wanted = int(self.state()["samples"]) + count
        self._until(lambda it: it.get("state", {}).get("samples", 0) >= wanted)

    def free(self) -> None:
        """Let time pass, and check that all places are given back."""
        self.clock.passed += STALL_SECONDS
        self.sweep(2)
        self.clock.passed += STALL_SECONDS
        for _ in range(100):
            if len(self.server.guard) <= 2 and len(self.server.server_state.connections) <= 2:
                return  # the owner's two
            self.sweep(1)
        left = list(self.server.guard._open.values())  # noqa: SLF001  (to name them)
        raise Finding(f"{len(left)} places are not given back: {left}")

    def state(self) -> dict[str, Any]:
        """Return the state, as the owner sees it."""
        return self._sent("GET", "/api/state")

    def record(self) -> None:
        """Begin a recording."""
        self._sent("POST", "/api/recording/start")

    def check_recording(self) -> None:
        """End the recording, and compare it with what was measured."""
        name = self.state()["recording"]["file"]
        self._sent("POST", "/api/recording/stop")
        found = self._sent("GET", f"/api/recordings/{name}")
        if found["gaps"] or found["problems"]:
            raise Finding(f"{found['gaps']} gaps, {found['problems']}")
        rows = self._sent("GET", f"/api/recordings/{name}/rows?points=20000")
        recorded = _series(rows["times"], rows["values"][rows["names"].index("FREQ")])
        live = self.dashboard.history.rows(found["last"] - found["first"] + 60, ("FREQ",))
        shown = _series(live.times.tolist(), live.values["FREQ"].tolist())
        first, last = next(iter(recorded)), next(reversed(recorded))
        expected = {at: value for at, value in shown.items() if first <= at <= last}
        near = {(at + by, value) for at, value in recorded.items() for by in (-1, 0, 1)}
        lost = expected.items() - near  # what is recorded beyond them was a try of a method
        if lost or not expected:
            raise Finding(f"{len(lost)} of {len(expected)} samples are not recorded")

    def _sent(self, method: str, path: str) -> dict[str, Any]:
        body: object = {} if method == "POST" else None
        answer = self.owner.request(method, path, headers=_ME, json=body)
        if answer.status_code != 200:
            raise Finding(f"{path}: {answer.status_code} {answer.text}")
        got: dict[str, Any] = answer.json()
        return got

    def _until(self, accepted: Callable[[dict[str, Any]], bool]) -> None:
        for _ in range(_MOST_MESSAGES):
            if accepted(json.loads(self.page.recv(_PATIENCE))):
                return
        raise Finding("the page has not got what it waits for")


def _series(times: list[float], values: list[float | None]) -> dict[int, float]:
    """Return values by ms."""
    pairs = zip(times, values, strict=True)
    return {round(at * 1000): it for at, it in pairs if it is not None and not math.isnan(it)}


@contextmanager
def world(folder: Path, *, tls: bool) -> Iterator[World]:
    """Serve a new dashboard that samples and records, with its files in `folder`."""
    with ExitStack() as stack:
        for module in ("connections", "security.access"):
            stack.enter_context(
                patch(f"mikas.dashboard.{module}.is_loopback", lambda it: it == _OWNER)
            )
        stack.enter_context(patch("mikas.dashboard.server._TICKS", 1))
        reports = stack.enter_context(_reported())
        dashboard = _dashboard(folder)
        own = stack.enter_context(listen(0, lan=True))
        port, context, fingerprint = own.getsockname()[1], None, None
        if tls:
            made = own_certificate(folder / "dashboard.pem", (HOST,), datetime.now(UTC))
            context, fingerprint = made.context, made.fingerprint
        access = Access(port, lan=True, hosts=(HOST,), token=TOKEN, fingerprint=fingerprint)
        app = create_app(dashboard, access, folder=folder)
        ready, clock = threading.Event(), ServerClock()
        server = Server(app, ready=ready.set, tls=context)
        server.guard.clock = clock  # not a `TurnClock`: time passes by hand
        thread = threading.Thread(target=server.run, kwargs={"sockets": [own]})
        thread.start()
        try:
            if not ready.wait(_PATIENCE):
                raise Finding("the server does not start")
            url = f"http://{_OWNER}:{port}"
            owner = stack.enter_context(httpx.Client(base_url=url, timeout=60, verify=False))
            page = stack.enter_context(
                connect(
                    f"ws://{_OWNER}:{port}/api/live?client=owner-0001",
                    ping_interval=None,
                    max_queue=None,  # what it has not read yet holds up neither pings nor its end
                )
            )
            it = World(dashboard, server, port, tls, owner, page, reports, clock)
            _count_sweeps(it)
            it.more_samples(1)
            yield it
        finally:
            server.should_exit = True
            thread.join()
        reports.check()


def _dashboard(folder: Path) -> Dashboard:
    clock = SteadyClock()
    bus = build_bus({"scenario": "warm-idle"}, start=clock.now())
    follower_of(bus).clock = clock
    settings = Settings(
        folder / "recordings",
        state=folder / "state",
        find=list,
        open_port=lambda url: RealTimeVirtualLink(bus, url=url),
        wall=clock,
    )
    dashboard = Dashboard(settings, port="sim:", lan=True)
    dashboard.plan.request = PlanSettings(dict.fromkeys(_NAMES, 1), "batch", None)
    return dashboard


def _count_sweeps(it: World) -> None:
    sweep = it.server.guard.sweep

    def counted() -> None:
        sweep()
        with it.swept:
            it.sweeps += 1
            it.swept.notify_all()

    it.server.guard.sweep = counted  # type: ignore[method-assign]  # counts the turns of the clock


@contextmanager
def _reported() -> Iterator[Reports]:
    """Gather what is logged, and what ends a thread."""
    reports, root = Reports(), logging.getLogger()

    def ended(it: threading.ExceptHookArgs) -> None:
        reports.lines.append(f"a thread ended: {it.exc_value!r}")

    def ignored(it: Any) -> None:  # noqa: ANN401  (UnraisableHookArgs)
        reports.lines.append(f"ignored: {it.exc_value!r}")

    root.addHandler(reports)
    try:
        with (
            patch.object(threading, "excepthook", ended),
            patch.object(sys, "unraisablehook", ignored),
        ):
            yield reports
    finally:
        root.removeHandler(reports)


def clients_context() -> ssl.SSLContext:
    """Return a context that takes any certificate, as a person does who continues."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context
