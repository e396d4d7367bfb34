"""The page without installation: its download and start, long recordings."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from itertools import pairwise
from statistics import median
from time import perf_counter

from bench.dash_rig import browser_seconds
from bench.recorded import recorded
from bench.rows import Row, Scope, Theme
from bench.site_rig import SITE, SiteBench, ask, missing, site_bench, until_sampling

_METHOD = """\
`make site`, served as files on this computer, in Chromium without a window. The cable is a fake
FT232 in a namespace: Chromium's own Web Serial, on a pty paced at 9600 baud, with a virtual unit at
its other end, in this process."""
_FIRST = "from the navigation of a second visit, all files kept by the service worker, to {what}"
_PAINT = "the browser's first contentful paint."
_VALUE = """\
the first value on the screen; the adapter is clicked as soon as it can be, 0.3 s of the time at
most are that click."""
_OPEN = """\
a recording of {hours:g} h, {megabytes:.0f} MB, in the reader's worker: its first decimated rows as
the chart asks for them, with nothing read before; the list's summary is the row before."""
_SAMPLING = "meanwhile the line's worker samples by stream; its longest step between two rows."
_CPU = """\
user and system time of Chromium's renderer over {seconds} s with Live's first preset at 1366x768,
the program in it, sampling by stream from the cable."""


def run(scope: Scope) -> Iterator[Theme]:
    why = missing()
    rows = [_size()]
    if why:
        print(f"site: only the download's size: {why}", file=sys.stderr)
    else:
        with site_bench() as bench:
            rows += _start(bench, scope.of(7, 2))
            rows += _cpu(bench, scope)
            rows += _long(bench, scope)
    yield Theme("The page without installation", _METHOD, rows)


def _size() -> Row:
    files = json.loads((SITE / "files.json").read_text("utf-8"))["files"]
    bare, packed = (sum(file[key] for file in files) / 1e6 for key in ("bytes", "compressed"))
    aside = f"{len(files)} files, {bare:.1f} MB as they are"
    return Row("the download, compressed", [packed], "MB", 2, at_most=10, aside=aside)


def _start(bench: SiteBench, runs: int) -> list[Row]:
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


def _cpu(bench: SiteBench, scope: Scope) -> list[Row]:
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


def _long(bench: SiteBench, scope: Scope) -> list[Row]:
    hours = scope.of(60, 6) / 60
    path = recorded(bench.folder / "hour.pcapng", hours, lap=300, method="stream")
    with bench.cable(), bench.page_of_a_person("bench.html") as page:
        each = page.evaluate("() => keep('hour.pcapng', 'recordings/hour.pcapng')")
        bench.begin(page, "line")
        ask(page, "line", "POST", "/api/connect", {"port": "webserial:", "method": "stream"})
        until_sampling(page)
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
        history = json.loads(ask(page, "line", "GET", "/api/history?seconds=600&points=20000"))
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
