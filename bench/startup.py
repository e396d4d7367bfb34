"""How long `mikas --help` takes, as a whole process."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from statistics import median
from time import perf_counter

from bench.rows import Row, Scope, Theme


def run(scope: Scope) -> Iterator[Theme]:
    runs = scope.of(11, 3)
    bare = median(_seconds("-c", "pass") for _ in range(runs))
    helped = [1000 * _seconds("-m", "mikas", "--help") for _ in range(runs)]
    aside = f"of which {bare * 1000:.0f} ms are Python's own"
    rows = [Row("`mikas --help`", helped, "ms", 0, aside=aside)]
    yield Theme("Start-up", f"A whole process, {runs} times.", rows)


def _seconds(*arguments: str) -> float:
    began = perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - began
