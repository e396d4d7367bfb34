"""Recordings from strangers before every reader (`fuzz/recordings/`): how many, what was found."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator, Sequence

from bench.rows import Row, Scope, Theme

_SEEDS = (1, 2, 3)
_FIGURES = re.compile(r"(\d+|nothing) found in (\d+) cases of seed \d+; (\d+) readings, (\d+) s")
_METHOD = """\
`python -m fuzz recordings`, {seconds} s for each of the seeds {seeds}, in one process: changed and
crafted files, which everything reads that reads recordings (fuzz/README.md). A finding is an
exception that is no error of mikas, a hang, work or memory out of proportion to the file, or a
result that its taker can't use."""


def run(scope: Scope) -> Iterator[Theme]:
    seconds = scope.of(180, 10)
    yield theme([_ran(seed, seconds) for seed in _SEEDS], seconds)


def theme(reports: Sequence[str], seconds: int) -> Theme:
    """Return the table of the campaigns' reports."""
    runs = [found.groups() for report in reports if (found := _FIGURES.search(report))]
    findings = [0.0 if count == "nothing" else float(count) for count, *_ in runs]
    cases = [int(count) for _, count, _, _ in runs]
    readings = sum(int(count) for _, _, count, _ in runs)
    aside = f"{sum(cases):,} files, {readings:,} readings"
    rows = [
        Row("findings", findings, "", 0, at_most=0, aside=aside),
        Row(
            "files", [count / int(it[3]) for count, it in zip(cases, runs, strict=True)], "a second"
        ),
    ]
    seeds = ", ".join(map(str, _SEEDS))
    return Theme("Hostile recordings", _METHOD.format(seconds=seconds, seeds=seeds), rows)


def _ran(seed: int, seconds: int) -> str:
    words = ("--seed", str(seed), "--seconds", str(seconds))
    command = [sys.executable, "-m", "fuzz.recordings.campaign", *words]
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False).stdout
