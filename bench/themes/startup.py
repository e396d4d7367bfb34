"""How long `mikas --help` takes, and the first value of `watch` and `dash`, as whole processes."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from statistics import median
from time import perf_counter, sleep
from typing import IO
from urllib.error import URLError
from urllib.request import urlopen

from bench.rig import serving
from bench.rows import Row, Scope, Theme, timed

_LONG = 30.0  # s; then something is wrong


def run(scope: Scope) -> Iterator[Theme]:
    runs = scope.of(11, 3)
    bare = median(timed(lambda: _run("-c", "pass"), runs))
    helped = [1000 * each for each in timed(lambda: _run("-m", "mikas", "--help"), runs)]
    aside = f"of which {bare * 1000:.0f} ms are Python's own"
    with serving() as url:
        watched = [_first_of_watch(url) for _ in range(runs)]
        shown = [_first_of_dash(url) for _ in range(scope.of(7, 2))]
    how = "from the start of the process to the first sample, from a healthy unit on a paced pty."
    rows = [
        Row("`mikas --help`", helped, "ms", 0, aside=aside),
        Row("`mikas watch`", watched, "s", 2, at_most=1.0, how=how),
        Row("`mikas dash`", shown, "s", 2, at_most=1.3, how=how + " Seen by polling its state."),
    ]
    yield Theme("Start-up", f"Whole processes, {runs} times (`dash` fewer).", rows)


def _run(*arguments: str) -> None:
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)


@contextmanager
def _started(*arguments: str) -> Iterator[IO[str]]:
    """What `mikas` prints; it is stopped at the end."""
    command = [sys.executable, "-m", "mikas", *arguments]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        assert process.stdout is not None
        try:
            yield process.stdout
        finally:
            process.terminate()


def _first_of_watch(url: str) -> float:
    began = perf_counter()
    with _started("watch", "--json", "--port", url) as out:
        if '"values"' not in out.readline():
            raise RuntimeError("watch shows no value")
        return perf_counter() - began


def _first_of_dash(url: str) -> float:
    began = perf_counter()
    with _started("dash", "--no-browser", "--json", "--port", url) as out:
        state = json.loads(out.readline())["url"].split("#")[0].split("?")[0] + "api/state"
        while perf_counter() - began < _LONG:
            try:
                with urlopen(state) as answer:
                    if json.load(answer)["samples"]:
                        return perf_counter() - began
            except URLError:
                pass  # it does not listen yet
            sleep(0.01)
    raise RuntimeError("dash shows no value")
