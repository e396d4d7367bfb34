"""The causes of a drive, ranked while its rows are read.

rows ──► pieces of two hours ──► features of each piece ──► one ranking for the drive

The samples of a drive are not kept whole: a piece takes about 20 MB, and its features some KB.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

from mikas.catalog.ignition_only import InjectionWatch
from mikas.causes.knowledge import load
from mikas.causes.ranking import Observer, rank_observation
from mikas.causes.result import CauseVerdict
from mikas.causes.rows import CHANNELS, samples_of_rows, unserved
from mikas.causes.weights import shipped
from mikas.recording.table.channels import Rows

PIECE: Final = 7200.0  # s
MOST_ROWS: Final = 100_000  # of a piece: 14 a second


class CauseCollector:
    """Collects the rows of a drive by pieces, and ranks the causes by the shipped knowledge."""

    def __init__(self) -> None:
        self._observer = Observer(shipped())
        self._watch = InjectionWatch()
        self._absent: frozenset[str] = frozenset()
        self._rows: list[Rows] = []
        self._count = 0

    def add(self, rows: Rows) -> None:
        """Add rows, parameters in the corrected interpretation."""
        if not len(rows.times):
            return
        first = (self._rows[0] if self._rows else rows).times[0]
        if self._count + len(rows.times) > MOST_ROWS or rows.times[-1] - first > PIECE:
            self._observe()
        used = {name: column for name, column in rows.values.items() if name in CHANNELS}
        self._rows.append(Rows(rows.times, used))
        self._count += len(rows.times)

    def columns(self, faults: Collection[int]) -> dict[str, object]:
        """Return the columns of the table `drives`. `faults`: stored at the latest reading."""
        self._observe()
        ranking = rank_observation(
            self._observer.observation,
            load(),
            shipped(),
            faults=faults,
            ignition_only=bool(self._absent),
        )
        named = ranking.verdict in (CauseVerdict.CAUSES, CauseVerdict.UNKNOWN)
        first = ranking.causes[0] if ranking.causes and named else None
        return {
            "verdict": ranking.verdict.value,
            "cause": first.id if first else None,
            "likelihood": first.likelihood.value if first else None,
            "cause_en": first.text.en if first else None,
            "cause_ru": first.text.ru if first else None,
        }

    def _observe(self) -> None:
        """Take the features of the collected rows, and drop these."""
        rows, self._rows, self._count = self._rows, [], 0
        for samples in samples_of_rows(rows):
            self._absent = unserved([samples], self._watch)
            self._observer.add(samples, self._absent)
