"""Guided tests in recordings: results kept as notes, and tests run over recorded rows."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from math import isfinite
from typing import TYPE_CHECKING, Final

from mikas.catalog import Catalog
from mikas.guided.definition import GuidedTest
from mikas.guided.engine import TestEngine
from mikas.guided.result import TestResult, read
from mikas.recording.capture.notes import Kind, Note

if TYPE_CHECKING:
    from mikas.recording.table.channels import Rows

_MOST: Final = 50  # results of a recording


def results_of(notes: Iterable[Note]) -> tuple[TestResult, ...]:
    """Return the results among the notes of a recording, the last fifty."""
    found = (read(note.data) for note in notes if note.kind == Kind.TEST)
    return tuple(result for result in found if result is not None)[-_MOST:]


def run_over(
    test: GuidedTest, catalog: Catalog, stretches: Iterable[Rows], skip: Collection[str] = ()
) -> TestResult | None:
    """Return the first result of `test` over recorded rows; None: its steps are not found there.

    A test with a step that only a person knows to be done (`by_hand`) is never found, unless that
    is among the steps to `skip`.
    """
    if any(step.by_hand and step.name not in skip for step in test.steps):
        return None
    engine = TestEngine(test, catalog)
    for rows in stretches:
        columns = [
            (name, rows.values[name].tolist()) for name in test.channels if name in rows.values
        ]
        for number, time in enumerate(rows.times.tolist()):
            values = {name: column[number] for name, column in columns}
            engine.take(time, {name: value for name, value in values.items() if isfinite(value)})
            engine.skip_all(skip)
            if engine.result is not None:
                return engine.result
    return None
