"""How often the ranking of causes is right, on cars that were not used for weighing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from time import process_time

from tools.causes.cars import Car, columns_of
from tools.causes.measure import Outcome, accused, is_wrong, measure, share
from tools.causes.page import write

from bench.rows import Row, Scope, Theme
from mikas.causes.ranking import rank
from mikas.causes.samples import Samples, samples_of

_HOUR = 3600.0  # s


def run(scope: Scope) -> Iterator[Theme]:
    measured = measure(quick=scope.quick)
    everything = [
        *measured.noticeable,
        *measured.half,
        *measured.idle,
        *measured.after,
        *measured.curve,
        *measured.sound,
    ]
    rows = [
        *_first_and_three("a noticeable defect", measured.noticeable, 95, 99),
        *_first_and_three("half of that", measured.half, 75, 90),
        *_first_and_three("three minutes at idle", measured.idle, 60, 85),
        Row(
            "three minutes at idle: called sound or named wrongly",
            [share(map(is_wrong, measured.idle))],
            "%",
            at_most=2,
        ),
        *_first_and_three("these after the proposed measurements", measured.after, 98, 100),
        Row(
            f"sound cars accused, of {len(measured.sound)}",
            [accused(measured.sound)],
            "%",
            at_most=0.5,
        ),
        Row(
            "two defects: both among three",
            [share(row.among_three for row in measured.pairs)],
            "%",
            at_least=80,
        ),
        Row(
            "unknown defect: said so",
            [share(row.ranking.verdict == "unknown" for row in measured.unknown)],
            "%",
            at_least=70,
        ),
        Row(
            "unknown defect: another almost certain",
            [share(row.certain for row in measured.unknown)],
            "%",
            at_most=2,
        ),
        Row(
            "wrong of the almost certain",
            [100 - share(row.first for row in everything if row.certain)],
            "%",
            at_most=1,
        ),
        Row("an hour's recording", _hour(scope.of(3, 1)), "s", 2, at_most=2),
    ]
    if not scope.quick:
        write(measured)
    yield Theme(
        "Causes",
        "Simulated cars with seeds, amounts and drives of their own; causes.md has the confusion "
        "and the reliability. The time is of the processor.",
        rows,
    )


def _first_and_three(what: str, rows: Sequence[Outcome], first: int, three: int) -> list[Row]:
    return [
        Row(f"{what}: first", [share(row.first for row in rows)], "%", at_least=first),
        Row(f"{what}: among three", [share(row.among_three for row in rows)], "%", at_least=three),
    ]


def _hour(runs: int) -> list[float]:
    samples = _repeated(samples_of(*columns_of(Car(900_001, "whole"))), _HOUR)
    taken = []
    for _ in range(runs):
        began = process_time()
        rank([samples])
        taken.append(process_time() - began)
    return taken


def _repeated(samples: Samples, seconds: float) -> Samples:
    """Return the drive again and again, until it has lasted long enough."""
    count = int(seconds / samples.seconds) + 1
    times = [time + lap * (samples.seconds + 60) for lap in range(count) for time in samples.times]
    return Samples(times, {name: column * count for name, column in samples.columns.items()})
