"""The page without installation: its download and start, rates over its cable, long recordings."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, Any

from bench.dash_rig import browser_seconds, chromium
from bench.recorded import recorded
from bench.rig import TURN_ROUND
from bench.rows import Row, Scope, Theme
from mikas.link.base import BITS_PER_BYTE, Direction
from mikas.recording import CaptureReader
from mikas.recording.capture.reader import Packet

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page, Playwright

_ROOT = Path(__file__).parents[2]
_SITE = _ROOT / "build" / "site"
_PAGES = Path(__file__).parents[1] / "site_pages"
_METHODS = ("single", "batch", "list", "stream")
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip

_METHOD = """\
`make site`, served as files on this computer, in Chromium without a window. The cable is a fake
FT232 in a namespace: Chromium's own Web Serial, on a pty paced at 9600 baud, with a virtual unit at
its other end, in this process."""
_FIRST = "from the navigation of a second visit, all files kept by the service worker, to {what}"
_PAINT = "the browser's first contentful paint."
_VALUE = """\
the first value on the screen; the adapter is clicked as soon as it can be, 0.3 s of the time at
most are that click."""
_RATE = """\
{seconds} s recorded by the site and taken from it: the wire's time for what was carried, stuffing
included (bytes · 10 / 9600, and 2 ms a request, [§5](../protocol.md#s5)), over the time
that passed between the first packet and the last."""
_OPEN = """\
a recording of {hours:g} h, {megabytes:.0f} MB, in the reader's worker: its first decimated rows as
the chart asks for them, with nothing read before; the list's summary is the row before."""
_SAMPLING = "meanwhile the line's worker samples by stream; its longest step between two rows."
_CPU = """\
user and system time of Chromium's renderer over {seconds} s with Live's first preset at 1366x768,
the program in it, sampling by stream from the cable."""


def run(scope: Scope) -> Iterator[Theme]:
    if not (_SITE / "files.json").is_file():
        raise RuntimeError("build/site is missing: make site")
    rows = [_size()]
    if chromium() is not None and sys.platform == "linux":
        sys.path.insert(0, str(_ROOT / "tests"))
        from static_site import computer_rig

        if missing := computer_rig.missing():
            print(f"site: only the download's size: {missing}", file=sys.stderr)
        else:
            with _computer() as bench:
                rows += _start(bench, scope.of(7, 2))
                rows += _rates(bench, scope.of(30, 8))
                rows += _cpu(bench, scope)
                rows += _long(bench, scope)
    yield Theme("The page without installation", _METHOD, rows)


def _size() -> Row:
    files = json.loads((_SITE / "files.json").read_text("utf-8"))["files"]
    bare, packed = (sum(file[key] for file in files) / 1e6 for key in ("bytes", "compressed"))
    aside = f"{len(files)} files, {bare:.1f} MB as they are"
    return Row("the download, compressed", [packed], "MB", 2, at_most=10, aside=aside)


@dataclass(frozen=True, slots=True)
class _Bench:
    """A computer with fake adapters, its browser, and the site with the pages of the bench."""

    computer: Any
    playwright: Playwright
    program: str
    browser: Browser
    folder: Path
    url: str

    @contextmanager
    def cable(self, **settings: str) -> Iterator[None]:
        from static_site.wire_rig import cable

        with (
            TemporaryDirectory() as folder,
            cable(self.computer, Path(folder), scenario="warm-idle", **settings),
        ):
            yield

    @contextmanager
    def page(self, name: str = "", **options: Any) -> Iterator[Page]:
        context = self.browser.new_context(locale="en-GB", **options)
        yield self._opened(context, name)
        context.close()

    @contextmanager
    def page_of_a_person(self, name: str = "") -> Iterator[Page]:
        """A page whose files are kept on the disk, not in memory as in the others, where each
        write is another process' work: a millisecond.
        """
        with TemporaryDirectory() as folder:
            context = self.playwright.chromium.launch_persistent_context(
                folder, executable_path=self.program, args=list(_FLAGS), locale="en-GB"
            )
            yield self._opened(context, name)
            context.close()

    def _opened(self, context: BrowserContext, name: str) -> Page:
        page = context.new_page()
        page.set_default_timeout(60_000)
        page.goto(self.url + name)
        return page

    @contextmanager
    def worker(self, role: str = "line") -> Iterator[Page]:
        """A page that runs one worker of the site and asks it."""
        with self.page_of_a_person("bench.html") as page:
            self.begin(page, role)
            yield page

    def begin(self, page: Page, role: str) -> None:
        script = next((self.folder / "assets").glob("worker-*.js")).name
        page.evaluate("([url, role]) => begin(url, role)", [f"assets/{script}", role])


@contextmanager
def _computer() -> Iterator[_Bench]:
    from playwright.sync_api import sync_playwright

    from static_site import computer_rig
    from static_site.pages_rig import StaticHost

    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        site = folder / "site"
        shutil.copytree(_SITE, site)
        for name in ("bench.html", "bench.js"):
            shutil.copy(_PAGES / name, site)
        rolldown = _ROOT / "web" / "node_modules" / ".bin" / "rolldown"
        bundled = ["--format", "esm", "--file", str(site / "keep.js")]
        subprocess.run(
            [rolldown, _PAGES / "keep.ts", *bundled], check=True, stdout=subprocess.DEVNULL
        )
        computer = stack.enter_context(computer_rig.computer())
        host = StaticHost(computer, site)
        stack.callback(host.stop)
        playwright = stack.enter_context(sync_playwright())
        program = computer.wrapper(chromium(), folder)
        browser = playwright.chromium.launch(executable_path=program, args=list(_FLAGS))
        stack.callback(browser.close)
        yield _Bench(computer, playwright, program, browser, site, f"{host.url}/")


def _start(bench: _Bench, runs: int) -> list[Row]:
    paints, values, programs = [], [], []
    with bench.cable(), bench.page_of_a_person() as page:
        page.wait_for_selector("#screen")
        page.wait_for_function("async () => Boolean((await navigator.serviceWorker.ready).active)")
        for _ in range(runs):
            page.goto("about:blank")
            began = perf_counter()
            page.goto(f"{bench.url}#/connection")
            page.get_by_role("button", name="webserial:").first.click()
            programs.append(perf_counter() - began)
            page.evaluate("() => { location.hash = '/live' }")
            page.wait_for_function(
                """() => [...document.querySelectorAll("#screen [data-value]")]
                  .some((it) => /[0-9]/.test(it.textContent))""",
                polling="raf",
            )
            values.append(perf_counter() - began)
            paints.append(
                page.evaluate(
                    """() => performance.getEntriesByName("first-contentful-paint")[0].startTime"""
                )
                / 1000
            )
    aside = f"the program answers after {median(programs):.1f} s"
    return [
        Row("first paint", paints, "s", 2, at_most=1, how=_FIRST.format(what=_PAINT)),
        Row("first value", values, "s", 1, at_most=6, aside=aside, how=_FIRST.format(what=_VALUE)),
    ]


def _rates(bench: _Bench, seconds: int) -> list[Row]:
    rows = []
    for latency in (1, 16):
        for method in _METHODS if latency == 1 else ("list", "stream"):
            with bench.cable(latency_ms=str(latency)), bench.worker() as page:
                percent, rate = _rate(page, method, seconds)
            what = f"`{method}`" + (f", adapter with {latency} ms" if latency > 1 else "")
            # A request for each set waits for the timer once: see the same row of the pty.
            target = None if (method, latency) == ("list", 16) else 95.0
            rows.append(Row(what, [percent], "%", 1, at_least=target, aside=f"{rate:.2f} sets/s"))
    rows[0] = replace(rows[0], how=_RATE.format(seconds=seconds))
    return rows


def _rate(page: Page, method: str, seconds: int) -> tuple[float, float]:
    """The percentage of the wire, and sets a second."""
    connect = {"port": "webserial:", "method": method}
    _ask(page, "line", "POST", "/api/connect", connect)
    _until_sampling(page)
    page.wait_for_timeout(3000)
    _ask(page, "line", "POST", "/api/recording/start", {"name": method})
    before = json.loads(_ask(page, "line", "GET", "/api/state"))
    page.wait_for_timeout(seconds * 1000)
    after = json.loads(_ask(page, "line", "GET", "/api/state"))
    _ask(page, "line", "POST", "/api/recording/stop", {})
    content = page.evaluate("path => file('line', path)", f"/api/recordings/{method}.pcapng/file")
    with TemporaryDirectory() as folder:
        path = Path(folder) / "taken.pcapng"
        path.write_bytes(base64.b64decode(content))
        packets = [it for it in CaptureReader(path) if isinstance(it, Packet)]
    received = [it for it in packets if it.direction is Direction.RECEIVED]
    # The first packets may come together; the last one's end is when it came.
    carried = sum(len(it.data) for it in received[1:])
    requests = sum(it.direction is Direction.SENT for it in packets)
    passed = received[-1].time - received[0].time
    limit = carried * BITS_PER_BYTE / 9600 + (requests if method != "stream" else 0) * TURN_ROUND
    sets = after["samples"] - before["samples"]
    return 100 * limit / passed, sets / (after["now"] - before["now"])


def _cpu(bench: _Bench, scope: Scope) -> list[Row]:
    settle, seconds = scope.of(20, 5), scope.of(60, 10)
    with bench.cable(), bench.page("#/connection", viewport={"width": 1366, "height": 768}) as page:
        page.get_by_role("button", name="webserial:").first.click()
        page.evaluate("() => { location.hash = '/live' }")
        page.wait_for_selector("[data-gauge]")
        page.wait_for_timeout(1000 * settle)
        began, before = perf_counter(), browser_seconds(bench.browser)
        page.wait_for_timeout(1000 * seconds)
        passed, after = perf_counter() - began, browser_seconds(bench.browser)
    shares = {kind: 100 * (after[kind] - before.get(kind, 0.0)) / passed for kind in after}
    return [
        Row("the page's CPU with the program, Live in gauges", [shares["renderer"]], "%", 1,
            how=_CPU.format(seconds=seconds)),
        Row("Chromium's CPU, Live in gauges", [sum(shares.values())], "%", 1),
    ]  # fmt: skip


def _long(bench: _Bench, scope: Scope) -> list[Row]:
    hours = scope.of(60, 6) / 60
    path = recorded(bench.folder / "hour.pcapng", hours, lap=300, method="stream")
    with bench.cable(), bench.page_of_a_person("bench.html") as page:
        each = page.evaluate("() => keep('hour.pcapng', 'recordings/hour.pcapng')")
        bench.begin(page, "line")
        _ask(page, "line", "POST", "/api/connect", {"port": "webserial:", "method": "stream"})
        _until_sampling(page)
        bench.begin(page, "reader")
        page.wait_for_timeout(3000)
        took = {
            name: page.evaluate("path => ask('reader', 'GET', path).then(it => it.ms)", address)
            for name, address in {
                "list": "/api/recordings",
                "open": "/api/recordings/hour.pcapng",
                "rows": "/api/recordings/hour.pcapng/rows?points=2000",
                "csv": "/api/recordings/hour.pcapng/export?format=csv",
                "report": "/api/recordings/hour.pcapng/report",
                "causes": "/api/recordings/hour.pcapng/causes",
            }.items()
        }
        history = json.loads(_ask(page, "line", "GET", "/api/history?seconds=600&points=20000"))
    times = history["times"]
    longest = max(after - before for before, after in pairwise(times))
    megabytes = path.stat().st_size / 1e6
    opened = (took["open"] + took["rows"]) / 1000
    return [
        Row("an append of 60 bytes to what is kept", [each], "µs", 0),
        Row("the list, with its summary", [took["list"] / 1000], "s", 1),
        Row(
            f"open {hours:g} hour(s)", [opened], "s", 1, at_most=10,
            how=_OPEN.format(hours=hours, megabytes=megabytes),
        ),
        Row("export to .csv", [took["csv"] / 1000], "s", 1),
        Row("report", [took["report"] / 1000], "s", 1),
        Row("causes", [took["causes"] / 1000], "s", 1, at_most=8),
        Row("longest step between two rows meanwhile", [1000 * longest], "ms", 0, how=_SAMPLING),
    ]  # fmt: skip


def _until_sampling(page: Page) -> None:
    while json.loads(_ask(page, "line", "GET", "/api/state"))["samples"] <= 3:
        page.wait_for_timeout(200)


def _ask(page: Page, role: str, method: str, path: str, body: object = None) -> str:
    text: str = page.evaluate(
        "([role, method, path, body]) => ask(role, method, path, body).then(it => it.text)",
        [role, method, path, body],
    )
    return text
