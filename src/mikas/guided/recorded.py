"""Guided tests in recordings: results kept as notes, and tests run over recorded rows."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Final

from mikas.cancellation import check_cancelled
from mikas.guided.definition import GuidedStep, GuidedTest, VerdictKind
from mikas.guided.engine import TestEngine
from mikas.guided.result import TestResult, read
from mikas.i18n import Text
from mikas.recording.capture.notes import Kind, Note

if TYPE_CHECKING:
    from mikas.recording.recording import Recording

_MOST: Final = 50  # results of a recording
_CHECKED: Final = 1000  # rows between two checks for a cancellation


def results_of(notes: Iterable[Note]) -> tuple[TestResult, ...]:
    """Return the results among the notes of a recording, the last fifty."""
    found = (read(note.data) for note in notes if note.kind == Kind.TEST)
    return tuple(result for result in found if result is not None)[-_MOST:]


@dataclass(frozen=True, slots=True)
class NotJudged:
    """Why a recording gives no result: the first of these that holds.

    `by_hand`: steps that no values show, and that were not left out. `lacking`: parameters of the
    test without a value. `step`: the step that does not occur; None: the start does not.
    """

    test: GuidedTest
    by_hand: tuple[GuidedStep, ...]
    lacking: tuple[str, ...]
    step: GuidedStep | None

    @property
    def text(self) -> Text:
        """The reason in words."""
        if self.by_hand:
            return _BY_HAND.filled(steps=", ".join(step.name for step in self.by_hand))
        if self.lacking:
            return _LACKING.filled(names=", ".join(self.lacking))
        if self.step is None:
            return _NO_START.filled(needs=self.test.needs)
        return _NO_STEP.filled(step=self.step.text)


def run_over(
    test: GuidedTest, recording: Recording, skip: Collection[str] = ()
) -> TestResult | NotJudged:
    """Return the first decided result of `test` over a recording, or else the first result.

    Why there is none, if its steps do not occur.

    A test with a step that only a person knows to be done (`by_hand`) is never found, unless that
    is among the steps to `skip`.
    """
    by_hand = tuple(step for step in test.steps if step.by_hand and step.name not in skip)
    if by_hand:
        return NotJudged(test, by_hand, (), None)
    catalog = recording.catalog
    engine, seen = TestEngine(test, catalog), set[str]()
    undecided: TestResult | None = None
    for rows in recording.interpreted("corrected", test.channels).rows():
        columns = [(name, column.tolist()) for name, column in rows.values.items()]
        for number, time in enumerate(rows.times.tolist()):
            if number % _CHECKED == 0:
                check_cancelled()
            values = {name: column[number] for name, column in columns}
            fresh = {name: value for name, value in values.items() if isfinite(value)}
            seen |= fresh.keys()
            engine.add_row(time, fresh)
            engine.skip_all(skip)
            if engine.result is None:
                continue
            if engine.result.outcome is not VerdictKind.UNKNOWN:
                return engine.result
            undecided = undecided or engine.result
            engine = TestEngine(test, catalog)
    if undecided is not None:
        return undecided
    step = engine.progress().step
    lacking = tuple(name for name in test.channels if name not in seen)
    return NotJudged(test, (), lacking, None if step is None else test.steps[step])


_BY_HAND: Final = Text(
    "no data show these steps; skip them: {steps}",
    "этих шагов по данным не видно, пропустите: {steps}",
)
_LACKING: Final = Text("the recording has no values of {names}", "в записи нет данных {names}")
_NO_START: Final = Text(
    "the recording does not have what the test begins with: {needs}",
    "в записи нет того, с чего проверка начинается: {needs}",
)
_NO_STEP: Final = Text(
    "the recording does not have this step: {step}", "в записи нет этого шага: {step}"
)
