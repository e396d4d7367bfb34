"""The dashboard: how late a value is on the screen, what the page weighs and costs."""

from __future__ import annotations

import gzip
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from statistics import median, quantiles
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING

from bench.dash_rig import (
    COUNTER,
    RATE,
    CountingUnit,
    Program,
    browser,
    browser_seconds,
    chromium,
    counting_unit,
    cpu_seconds,
    program,
)
from bench.recorded import recorded
from bench.rows import Row, Scope, Theme
from mikas.dashboard.page import FOLDER

if TYPE_CHECKING:
    from playwright.sync_api import Browser, CDPSession, Page

_METHOD = """\
`mikas dash` is a process of its own; the unit is on a pty paced at 9600 baud; the page, in Chromium
without a window, shows the table of all channels, {rate:.0f} sets a second of 21 parameters."""
_DELAY = """\
from the moment when the last byte of a response has left the wire until a frame with its value, or
a newer one, has been painted (`requestAnimationFrame`, then a task of its own). The unit counts its
responses in place of a temperature; both ends read the same clock. All responses of {seconds} s."""
_READY = "from the navigation, with nothing in the cache, to the first frame with a value in it."
_CPU = "user and system time of the whole program over {seconds} s, with one page open."
_PAGE_CPU = """\
user and system time of Chromium's renderer process over {seconds} s, with Live's first preset
at 1366x768: six gauges, seven numbers or lamps with a line each, a strip. The counted temperature
passes its limits every ten seconds. The row below it has all of Chromium's processes: without a
graphics card they draw in software."""
_HEAP = "JavaScript's after a collection, {first} s after the page was opened and {last} s later."

# Kept by the page: [ms of the clock, what stands in the cell], once it has been painted.
_WATCH = """
name => {
  const painted = (window.painted = []);
  const channel = new MessageChannel();
  let last = null, waiting = null;
  channel.port1.onmessage = () => { painted.push([Date.now(), waiting]); waiting = null; };
  const look = () => {
    const text = document.querySelector(`td[data-value="${name}"]`)?.textContent ?? null;
    if (text !== null && text !== last && waiting === null) {
      last = waiting = text;
      channel.port2.postMessage(0);
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}"""
_READY_WATCH = """
const look = () => {
  const there = [...document.querySelectorAll("#screen [data-value]")];
  if (there.some((it) => /[0-9]/.test(it.textContent)))
    setTimeout(() => { window.readyAt = performance.now(); });
  else requestAnimationFrame(look);
};
requestAnimationFrame(look);"""


_FRAMES = """\
the time from one frame to the next while {hours:g} h of a recording ({rows} readings) are
shown as {view}: the cloud is zoomed and coloured by another channel, the table has other values and
statistics; each change counts all readings again. In Chromium without a graphics card."""
# Kept by the page: ms between frames.
_FRAME_WATCH = """
() => {
  const frames = (window.frameTimes = []);
  let before = performance.now();
  const look = (now) => {
    frames.push(now - before);
    before = now;
    window.frameWatch = requestAnimationFrame(look);
  };
  window.frameWatch = requestAnimationFrame(look);
}"""


def run(scope: Scope) -> Iterator[Theme]:
    rows = [_size()]
    if chromium() is not None and Path("/proc/self/stat").exists():
        with counting_unit() as unit, program(unit.url) as served, browser() as it:
            rows += _opened(it, served, scope.of(11, 3))
            rows += _long(it, served, unit, scope)
            rows += _gauges(it, served, unit, scope)
        with TemporaryDirectory() as folder, counting_unit() as unit:
            hours = scope.of(60, 6) / 60
            recorded(Path(folder) / "hour.pcapng", hours)
            with program(unit.url, Path(folder)) as served, browser() as it:
                rows += _frames(it, served, hours)
    yield Theme("The dashboard", _METHOD.format(rate=RATE), rows)


def _size() -> Row:
    files = [file for file in FOLDER.rglob("*") if file.is_file()]
    bare = sum(file.stat().st_size for file in files)
    packed = sum(len(gzip.compress(file.read_bytes(), 9)) for file in files)
    aside = f"{len(files)} files, {bare / 1000:.0f} KB as they are"
    return Row("the page, gzipped", [packed / 1000], "KB", 0, at_most=300, aside=aside)


def _opened(it: Browser, served: Program, runs: int) -> list[Row]:
    _warm(it, served)
    took = []
    for _ in range(runs):
        context = it.new_context()
        page = context.new_page()
        page.add_init_script(_READY_WATCH)
        page.goto(served.url)
        took.append(page.wait_for_function("() => window.readyAt").json_value())
        context.close()
    return [Row("page ready", took, "ms", 0, at_most=1000, how=_READY)]


def _warm(it: Browser, served: Program) -> None:
    """Until the program samples."""
    context = it.new_context()
    page = context.new_page()
    page.goto(served.url)
    page.wait_for_selector('[data-line="sampling"]', timeout=60_000)
    context.close()


def _long(it: Browser, served: Program, unit: CountingUnit, scope: Scope) -> list[Row]:
    settle, seconds = scope.of(60, 10), scope.of(600, 60)
    delay_seconds = scope.of(60, 15)
    context = it.new_context(viewport={"width": 1280, "height": 800})
    page = context.new_page()
    page.goto(f"{served.url}#/live")
    page.get_by_role("tab").last.click()  # all channels
    page.wait_for_selector(f'td[data-value="{COUNTER}"]')
    page.wait_for_timeout(1000 * settle)
    tools = context.new_cdp_session(page)
    heap, backing = _heap(tools)
    began, cpu = perf_counter(), cpu_seconds(served.process)
    count = len(unit.sent)
    page.wait_for_timeout(1000 * (seconds - delay_seconds))
    page.evaluate(_WATCH, COUNTER)
    page.wait_for_timeout(1000 * delay_seconds)
    painted = page.evaluate("() => window.painted")
    passed = perf_counter() - began
    share = 100 * (cpu_seconds(served.process) - cpu) / passed
    rate = (len(unit.sent) - count) / passed
    grown, backing_then = _heap(tools)
    context.close()
    delays = _delays(unit, painted)
    parts = quantiles(delays, n=20)
    how = _DELAY.format(seconds=delay_seconds)
    aside = f"{len(delays)} responses, {len(painted)} paints; the slowest {max(delays):.0f} ms"
    held = f"{heap:.1f} MB, then {grown:.1f}; the last hour's values beside it: "
    held += f"{backing:.1f} MB, then {backing_then:.1f}"
    reported = f"{rate:.1f} sets/s"
    return [
        Row("wire to screen, p50", [median(delays)], "ms", 0, how=how),
        Row("wire to screen, p95", [parts[18]], "ms", 0, at_most=100, aside=aside),
        Row(
            "the program's CPU", [share], "%", 1, at_most=8, aside=reported,
            how=_CPU.format(seconds=seconds),
        ),
        Row(
            "the page's heap grew by", [grown - heap], "MB", 2, at_most=1, aside=held,
            how=_HEAP.format(first=settle, last=seconds),
        ),
    ]  # fmt: skip


def _gauges(it: Browser, served: Program, unit: CountingUnit, scope: Scope) -> list[Row]:
    """The page's share of a core while it shows gauges."""
    settle, seconds = scope.of(30, 5), scope.of(60, 10)
    context = it.new_context(viewport={"width": 1366, "height": 768})
    page = context.new_page()
    page.goto(f"{served.url}#/live")
    page.wait_for_selector("[data-gauge]")
    page.wait_for_timeout(1000 * settle)
    began, before, count = perf_counter(), browser_seconds(it), len(unit.sent)
    page.wait_for_timeout(1000 * seconds)
    passed, after = perf_counter() - began, browser_seconds(it)
    rate = (len(unit.sent) - count) / passed
    context.close()
    shares = {kind: 100 * (after[kind] - before.get(kind, 0.0)) / passed for kind in after}
    return [
        Row(
            "the page's CPU, Live in gauges", [shares["renderer"]], "%", 1, at_most=25,
            aside=f"{rate:.1f} sets/s", how=_PAGE_CPU.format(seconds=seconds),
        ),
        Row("Chromium's CPU, Live in gauges", [sum(shares.values())], "%", 1),
    ]  # fmt: skip


def _frames(it: Browser, served: Program, hours: float) -> list[Row]:
    """Frame times of the scatter plot and of the table over a recording."""
    context = it.new_context(viewport={"width": 1366, "height": 768}, locale="en-GB")
    page = context.new_page()
    page.set_default_timeout(120_000)
    page.goto(f"{served.url}#/recordings")
    page.get_by_role("button", name="Open").click()
    page.wait_for_selector("aside .player, aside")
    page.evaluate("() => { location.hash = '/chart/scatter' }")
    page.wait_for_selector("[data-points]")
    count = int(page.get_attribute("[data-points]", "data-points") or 0)
    times = {"scatter": _watched(page, _zoom_and_colour)}
    page.evaluate("() => { location.hash = '/chart/table' }")
    page.wait_for_selector("[data-cell]")
    times["table"] = _watched(page, _other_values)
    context.close()
    rows = []
    for view, frames in times.items():
        aside = (
            f"{len(frames)} frames, median {median(frames):.0f} ms, the slowest {max(frames):.0f}"
        )
        how = _FRAMES.format(hours=hours, rows=count, view=view)
        p95 = quantiles(frames, n=20)[18]
        rows.append(
            Row(f"frames of the {view}, p95", [p95], "ms", 0, at_most=33, aside=aside, how=how)
        )
    return rows


def _watched(page: Page, act: Callable[[Page], None]) -> list[float]:
    page.evaluate(_FRAME_WATCH)
    act(page)
    frames: list[float] = page.evaluate(
        "() => { cancelAnimationFrame(window.frameWatch); return window.frameTimes; }"
    )
    return frames[1:]


def _zoom_and_colour(page: Page) -> None:
    box = page.locator("[data-points]").bounding_box()
    assert box is not None
    for step in range(20):
        page.mouse.move(box["x"] + 200 + 10 * step, box["y"] + 150)
        page.mouse.wheel(0, -100 if step < 10 else 100)
        page.wait_for_timeout(150)
    for name in ("TWAT", "", "INJ", "UOZ"):
        page.get_by_label("Colour", exact=True).select_option(name)
        page.wait_for_timeout(700)


def _other_values(page: Page) -> None:
    for name in ("INJ", "TWAT", "JAIR", "UACC"):
        page.get_by_label("Value", exact=True).select_option(name)
        page.wait_for_timeout(700)
        for statistic in ("count", "max", "deviation", "mean"):
            page.get_by_label("Statistic").select_option(statistic)
            page.wait_for_timeout(150)


def _heap(tools: CDPSession) -> tuple[float, float]:
    """MB in use by JavaScript after a collection, and by its arrays of numbers."""
    tools.send("HeapProfiler.collectGarbage")
    usage = tools.send("Runtime.getHeapUsage")
    return usage["usedSize"] / 1e6, usage.get("backingStorageSize", 0) / 1e6


def _delays(unit: CountingUnit, painted: Sequence[tuple[float, str]]) -> list[float]:
    """ms for each response sent between the first paint and the last."""
    seen: list[tuple[int, float]] = []
    # Where to begin counting: the newest response when the first value was painted, or before.
    last = max(n for n, sent in list(unit.sent.items()) if sent <= painted[0][0] / 1000) - 128
    for stamp, text in painted:
        shown = text.replace("−", "-")
        if not shown.lstrip("-").isdigit():
            continue
        last += (int(shown) + 40 - last) % 256
        seen.append((last, stamp))
    delays = []
    for (before, _), (number, stamp) in pairwise(seen):
        answers = (unit.sent[n] for n in range(before + 1, number + 1) if n in unit.sent)
        delays += [stamp - 1000 * sent for sent in answers]
    if not delays:
        raise RuntimeError("the page showed no values")
    return delays
