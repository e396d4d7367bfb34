"""Requests by the page without installation, over Web Serial and WebUSB, beside the desktop."""

from __future__ import annotations

import base64
import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from bench.rig import TURN_ROUND, everything, paced, sample
from bench.rows import Row, Scope, Theme
from bench.site_rig import SiteBench, ask, missing, site_bench, until_sampling
from mikas.catalog import shipped
from mikas.client.parameters.polling import FixedMethod
from mikas.commands import Datum, ReadParameters
from mikas.framing import encode
from mikas.link.base import BITS_PER_BYTE, Direction
from mikas.recording import CaptureReader
from mikas.recording.capture.reader import Packet

if TYPE_CHECKING:
    from playwright.sync_api import Page

_SETS: dict[FixedMethod, int] = {"single": 5, "batch": 18, "list": 30, "stream": 35}  # a second, §5
_OVER_USB = {"single": 90.0, "batch": 97.0, "list": 95.0, "stream": 95.0}
_TARGET = 95.0  # over Web Serial
_ALONE = {"single": ("UACC",), "batch": tuple(it.name for it in shipped().parameters)}
_SCENARIO = "warm-idle"
_SETTLE = 500  # ms from the start of a recording until a stream has gone on

_METHOD = """\
All 21 codes of [§4](../protocol.md#s4), as in the wire's tables, {seconds} s each, one after the
other on the same computer. The limit is the wire's time for what was carried, stuffing included
(bytes · 10 / 9600, and 2 ms a request, [§5](../protocol.md#s5)). The desktop is the sampler of
`mikas log` on a paced pty. The page is `make site`, its line's worker in Chromium without a window;
what it has recorded says what was carried, and when. Its cable is a fake FT232 for Chromium's own
Web Serial, on a pty paced at 9600 baud, or a model of a chip ([chips.md](chips.md)) for Chromium's
own WebUSB, which computes as well. JavaScript alone sends a request of one code (`single`) or all
(`batch`) as soon as the answer before has come, with no Python in its worker: what is missing there
is Chromium's way to the adapter, and the model's."""


def run(scope: Scope) -> Iterator[Theme]:
    seconds = scope.of(10, 5)
    if why := missing():
        print(f"page: not measured: {why}", file=sys.stderr)
        return
    rows: list[Row] = []
    with site_bench() as bench, _usb_sockets(bench) as sockets:
        for method, sets in _SETS.items():
            rows.append(_desktop(method, sets * seconds))
            with bench.cable(), bench.worker() as page:
                row = _row(f"`{method}`, page, Web Serial", page, "webserial:", method, seconds)
            rows.append(replace(row, at_least=_TARGET))
            if method in _ALONE:
                with bench.cable():
                    rows.append(_alone(bench, "serial", method, "Web Serial", seconds))
                with _usb_cable(sockets, "FT232R"):
                    rows.append(_alone(bench, "usb", method, "WebUSB, FT232R", seconds))
            for chip in _chips(scope, method):
                with _usb_cable(sockets, chip), bench.worker("usb") as page:
                    name = f"`{method}`, page, WebUSB, {chip}"
                    row = _row(name, page, "webusb:", method, seconds)
                rows.append(replace(row, at_least=_OVER_USB[method]))
        for method in () if scope.quick else ("list", "stream"):
            with bench.cable(latency_ms="16"), bench.worker() as page:
                name = f"`{method}`, page, Web Serial, adapter with 16 ms"
                row = _row(name, page, "webserial:", method, seconds)
            # A request for each set waits for the timer once: see the same row of the pty.
            rows.append(row if method == "list" else replace(row, at_least=_TARGET))
    yield Theme("The page beside the desktop", _METHOD.format(seconds=seconds), rows)


def _chips(scope: Scope, method: FixedMethod) -> tuple[str, ...]:
    """An FTDI has a timer, and sends status all the time; the others are alike in this."""
    return ("FT232R",) if scope.quick or method in {"batch", "stream"} else ("FT232R", "CH340")


@contextmanager
def _usb_sockets(bench: SiteBench) -> Iterator[Any]:
    from static_site.usb_sockets_rig import UsbSockets

    sockets = UsbSockets(bench.computer)
    try:
        yield sockets
    finally:
        sockets.close()


@contextmanager
def _usb_cable(sockets: Any, chip: str) -> Iterator[None]:  # noqa: ANN401  (of the tests)
    from static_site.usb_sockets_rig import usb_cable

    with TemporaryDirectory() as folder, usb_cable(sockets, Path(folder), chip, scenario=_SCENARIO):
        yield


def _desktop(method: FixedMethod, sets: int) -> Row:
    with paced() as plug:
        session = sample(plug, everything(), method, sets=sets, runs=1)
    [lap] = session.laps
    return Row(f"`{method}`, desktop", [lap.percent], "%", 1, aside=f"{lap.rate:.2f} sets/s")


def _row(what: str, page: Page, port: str, method: str, seconds: int) -> Row:
    connect = {"port": port, "method": method}
    ask(page, "line", "POST", "/api/connect", connect)
    until_sampling(page)
    page.wait_for_timeout(3000)
    ask(page, "line", "POST", "/api/recording/start", {"name": method})
    page.wait_for_timeout(_SETTLE)
    before = json.loads(ask(page, "line", "GET", "/api/state"))
    page.wait_for_timeout(seconds * 1000)
    after = json.loads(ask(page, "line", "GET", "/api/state"))
    ask(page, "line", "POST", "/api/recording/stop", {})
    content = page.evaluate("path => file('line', path)", f"/api/recordings/{method}.pcapng/file")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "taken.pcapng"
        path.write_bytes(base64.b64decode(content))
        packets = [it for it in CaptureReader(path) if isinstance(it, Packet)]
    sets = after["samples"] - before["samples"]
    rate = sets / (after["now"] - before["now"])
    percent = of_the_wire(packets, before["now"], after["now"])
    return Row(what, [percent], "%", 1, aside=f"{rate:.2f} sets/s")


def _alone(bench: SiteBench, access: str, method: str, over: str, seconds: int) -> Row:
    """Exchange the same request, over and over, in a worker without Python."""
    wanted = tuple(shipped().parameter(name) for name in _ALONE[method])
    request = encode(ReadParameters(tuple(Datum(it.code, it.size) for it in wanted)).body())
    asked = [access, list(request), seconds]
    with bench.page_of_a_person("bench.html") as page:
        took = page.evaluate(
            "([access, request, seconds]) => alone(access, request, seconds)", asked
        )
    limit = took["carried"] * BITS_PER_BYTE / 9600 + took["exchanges"] * TURN_ROUND
    late = (took["seconds"] - limit) / took["exchanges"]
    percent = 100 * limit / took["seconds"]
    aside = f"{1000 * late:.1f} ms an exchange"
    return Row(f"`{method}`, JavaScript alone, {over}", [percent], "%", 1, aside=aside)


def of_the_wire(packets: Sequence[Packet], begin: float, end: float) -> float:
    """Return the wire's time for what it carried from `begin` to `end`, in percent of that time.

    A recording begins and ends with other requests, between which a stream is stopped and the line
    waited for: they are not in, as they are not in what the desktop measures.
    """
    there = [it for it in packets if begin <= it.time <= end]
    received = [it for it in there if it.direction is Direction.RECEIVED]
    # The first packet began before; the last one's end is when it came.
    since, until = received[0].time, received[-1].time
    carried = sum(len(it.data) for it in received[1:])
    requests = sum(it.direction is Direction.SENT and since < it.time < until for it in there)
    limit = carried * BITS_PER_BYTE / 9600 + requests * TURN_ROUND
    return 100 * limit / (until - since)
