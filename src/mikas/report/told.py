"""What the unit told of its faults, one reading after the other, and what was gone in between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from mikas.catalog import Catalog, Fault


@dataclass(frozen=True, slots=True)
class Heard:
    """The numbers that the unit told at `time`, in its order. `erased`: shortly before."""

    time: float
    codes: tuple[int, ...]
    erased: bool = False


@dataclass(frozen=True, slots=True)
class Gone:
    """Faults that were stored, and were not any more at `time`, on the link's clock. `erased`: by a
    tester; else nobody saw why (the battery was taken off, or the unit forgot them).
    """

    time: float
    faults: tuple[Fault, ...]
    erased: bool


def gone_of(heard: Sequence[Heard], catalog: Catalog) -> tuple[Gone, ...]:
    """What was told once and not the next time."""
    missing = (
        (after, tuple(code for code in before.codes if code not in after.codes))
        for before, after in pairwise(heard)
    )
    return tuple(
        Gone(after.time, tuple(map(catalog.fault, codes)), after.erased)
        for after, codes in missing
        if codes
    )
