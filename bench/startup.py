"""How long `mikas --help` takes, as a whole process."""

from __future__ import annotations

import subprocess
import sys
from statistics import median
from time import perf_counter

_RUNS = 11


def run() -> None:
    bare = median(_seconds("-c", "pass") for _ in range(_RUNS))
    helped = median(_seconds("-m", "mikas", "--help") for _ in range(_RUNS))
    print(f"`mikas --help`: {helped * 1000:.0f} ms (median of {_RUNS}), of which ", end="")
    print(f"{bare * 1000:.0f} ms are Python's own.")


def _seconds(*arguments: str) -> float:
    began = perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - began
