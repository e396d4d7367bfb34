"""Run the benchmarks; print their tables and write the pages of both languages (`make bench`).

python -m bench                   everything
python -m bench wire cpu          these themes only; their sections of the document are renewed
python -m bench --quick           briefly; writes nothing
"""

from __future__ import annotations

import argparse
import os
import platform
import signal
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from bench import russian
from bench.rows import Scope
from bench.themes import (
    causes,
    cpu,
    crash,
    dash,
    dissectors,
    fleet,
    hostile,
    installed,
    memory,
    page_rates,
    phone,
    reading,
    stalls,
    startup,
    static_site,
    survey,
    viewers,
    wire,
)

THEMES = {
    "wire": wire,
    "stalls": stalls,
    "cpu": cpu,
    "memory": memory,
    "reading": reading,
    "fleet": fleet,
    "startup": startup,
    "installed": installed,
    "dash": dash,
    "viewers": viewers,
    "dissectors": dissectors,
    "site": static_site,
    "page": page_rates,
    "phone": phone,
    "causes": causes,
    "crash": crash,
    "hostile": hostile,
    "survey": survey,
}
DOCUMENT = Path(__file__).parent.parent / "docs" / "development" / "benchmarks.md"

_ABOUT = """\
# Benchmarks

Made by `make bench`, which takes about an hour; not edited by hand. A figure is the
median of its runs, lowest and highest stand beside it. A target that was not reached says MISSED.
The limits of the wire are those of [protocol.md](../protocol.md), [§5](../protocol.md#s5).
Under each table stands where and when it was measured, and what else the machine was doing."""


def main() -> None:
    arguments = argparse.ArgumentParser(prog="python -m bench", description="Run the benchmarks.")
    arguments.add_argument("themes", nargs="*", metavar="THEME", help=", ".join(THEMES))
    arguments.add_argument("--quick", action="store_true", help="briefly, not to be quoted")
    given = arguments.parse_args()
    if unknown := set(given.themes) - set(THEMES):
        arguments.error(f"no theme {', '.join(sorted(unknown))}; there is {', '.join(THEMES)}")
    scope = Scope(quick=given.quick)
    # Started in the background, it would hand on that Ctrl-C is ignored, and nothing would end.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for name in given.themes or THEMES:
        load = _load()
        for theme in THEMES[name].run(scope):
            section = f"{theme.markdown()}\n\n{_machine(load)}"
            print(f"\n{section}", flush=True)
            if not scope.quick:  # at once: half an hour is long, and what was measured stays
                _write(theme.title, section)
    if scope.quick:
        print("\nNothing was written: a quick run is not to be quoted.")
    else:
        print(f"\nWritten: {DOCUMENT.name}")


def _write(title: str, section: str) -> None:
    """Renews one section of the document; the others stay as they were measured."""
    known = DOCUMENT.read_text("utf-8") if DOCUMENT.is_file() else ""
    sections = {part.partition("\n")[0]: part.strip() for part in known.split("\n## ")[1:]}
    sections[title] = section.removeprefix("## ").strip()
    reported = "\n".join(sections.values())
    met, missed = reported.count("| met |"), reported.count("**MISSED**")
    about = f"{_ABOUT}\n\n{met} of {met + missed} targets met."
    text = "\n\n## ".join([about, *sections.values()])
    DOCUMENT.write_text(text + "\n", encoding="utf-8", newline="\n")
    russian.write()


def _machine(load: str) -> str:
    return (
        f"*{datetime.now(UTC):%Y-%m-%d}; {_processor()}, {os.cpu_count()} cores; "
        f"{platform.system()}; Python {platform.python_version()}{load}.*"
    )


def _load() -> str:
    """Other programs on the machine disturb: what there was of them belongs to the figures."""
    if not hasattr(os, "getloadavg"):
        return ""
    return f"; load average before it {os.getloadavg()[0]:.1f}"


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
