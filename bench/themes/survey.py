"""Eight units whose assumptions were drawn blind: what a survey finds, leaves open, and takes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.blind_units import Surveyed, surveyed, table
from bench.rows import Row, Scope, Theme

_UNITS = 8
_ABOUT = """\
Virtual units whose behaviour was drawn from a seed: up to 24 assumptions each, of which the survey
knows none. On the simulated clock, with a driver who does what is said after 5 s. What stays open
has its reason in the survey: as a rule the unit lacks the command. `python -m bench.blind_units`
prints each assumption, its truth and what was found."""


def run(scope: Scope) -> Iterator[Theme]:
    with TemporaryDirectory() as folder:
        units = [surveyed(seed, Path(folder)) for seed in range(1, scope.of(_UNITS, 2) + 1)]
    for unit in units:
        print(table(unit))
    of = f"of {len(units[0].rows)}"
    rows = [
        Row("found, but wrong", [_count(unit, "wrong") for unit in units], of, 0, at_most=0),
        Row("found, and right", [_count(unit, "right") for unit in units], of, 0),
        Row("open, with the reason", [_count(unit, "open") for unit in units], of, 0),
        Row("measuring", [unit.measuring for unit in units], "s", 0, at_most=600),
    ]
    yield Theme("A survey of blind units", _ABOUT, rows)


def _count(unit: Surveyed, verdict: str) -> float:
    return float(sum(row.verdict == verdict for row in unit.rows))
