"""Runs the benchmarks, prints their tables, and writes docs/benchmarks.md: `make bench`.

python -m bench                   everything; writes the document
python -m bench --quick           everything, but briefly; writes nothing
python -m bench wire cpu          these themes only; writes nothing
"""

from __future__ import annotations

import argparse
import os
import platform
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter

from bench import cpu, dash, memory, reading, startup, wire
from bench.rows import Scope, Theme

THEMES = {
    "wire": wire,
    "cpu": cpu,
    "memory": memory,
    "reading": reading,
    "startup": startup,
    "dash": dash,
}
DOCUMENT = Path(__file__).parent.parent / "docs" / "benchmarks.md"

_ABOUT = """\
# Benchmarks

Made by `make bench`, which takes about half an hour; not edited by hand. A figure is the
median of its runs, lowest and highest stand beside it. A target that was not reached says MISSED.
The limits of the wire are those of [protocol.md](protocol.md), §5."""


def main() -> None:
    arguments = argparse.ArgumentParser(prog="python -m bench", description="Run the benchmarks.")
    arguments.add_argument("themes", nargs="*", metavar="THEME", help=", ".join(THEMES))
    arguments.add_argument("--quick", action="store_true", help="briefly, not to be quoted")
    given = arguments.parse_args()
    if unknown := set(given.themes) - set(THEMES):
        arguments.error(f"no theme {', '.join(sorted(unknown))}; there is {', '.join(THEMES)}")
    scope = Scope(quick=given.quick)
    writes = not scope.quick and not given.themes
    began = perf_counter()
    machine = _machine()
    print(machine, flush=True)
    themes: list[Theme] = []
    for name in given.themes or THEMES:
        for theme in THEMES[name].run(scope):
            themes.append(theme)
            print(f"\n{theme.markdown()}", flush=True)
            if writes:  # half an hour is long: what was measured stays, however it ends
                _write(machine, themes, "This run has not come to its end.")
    end = _end(themes, perf_counter() - began)
    print(f"\n{end}")
    if not writes:
        print("\nNothing was written: that is for a full run.")
        return
    _write(machine, themes, end)
    print(f"\nWritten: {DOCUMENT.name}")


def _write(machine: str, themes: list[Theme], end: str) -> None:
    parts = [_ABOUT, machine, *(theme.markdown() for theme in themes), end]
    DOCUMENT.write_text("\n\n".join(parts) + "\n", encoding="utf-8", newline="\n")


def _machine() -> str:
    return (
        f"{datetime.now(UTC):%Y-%m-%d}. {_processor()}, {os.cpu_count()} cores; "
        f"{platform.system()}; Python {platform.python_version()}"
        f"{_load(', load average at the begin')}."
    )


def _end(themes: list[Theme], seconds: float) -> str:
    with_target = [row for theme in themes for row in theme.rows if row.met is not None]
    met = sum(bool(row.met) for row in with_target)
    return (
        f"{met} of {len(with_target)} targets met; it took {seconds / 60:.0f} minutes"
        f"{_load(', load average at the end')}."
    )


def _load(what: str) -> str:
    """Other programs on the machine disturb: what there was of them belongs to the figures."""
    if not hasattr(os, "getloadavg"):
        return ""
    return f"{what} {os.getloadavg()[0]:.1f}"


def _processor() -> str:
    return next(_models(), "") or platform.processor() or platform.machine()


def _models() -> Iterator[str]:
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8").splitlines()
    except OSError:
        return
    yield from (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))


if __name__ == "__main__":
    main()
