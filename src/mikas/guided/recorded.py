"""Guided tests in recordings: results kept as notes, and tests run over recorded rows."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from math import inf, isfinite
from typing import TYPE_CHECKING, Final

from mikas.cancellation import check_cancelled
from mikas.guided.definition import GuidedTest, VerdictKind
from mikas.guided.engine import ProgressPhase, TestEngine
from mikas.guided.result import TestResult, read
from mikas.guided.waiting import Unmet
from mikas.i18n import Text, joined
from mikas.recording.capture.notes import Kind, Note

if TYPE_CHECKING:
    from mikas.recording.recording import Recording

_MOST: Final = 50  # results of a recording
_CHECKED: Final = 1000  # rows between two checks for a cancellation


def results_of(notes: Iterable[Note]) -> tuple[TestResult, ...]:
    """Return the results among the notes of a recording, the last fifty."""
    found = (read(note.data) for note in notes if note.kind == Kind.TEST)
    return tuple(result for result in found if result is not None)[-_MOST:]


def run_over(
    test: GuidedTest, recording: Recording, skip: Collection[str] = ()
) -> TestResult | Text:
    """Return the first decided result of `test` over a recording, or else the first result; a text
    that says why there is none, if its steps do not occur.

    A test with a step that only a person knows to be done (`by_hand`) is never found, unless that
    is among the steps to `skip`.
    """
    by_hand = [step.name for step in test.steps if step.by_hand and step.name not in skip]
    if by_hand:
        return _BY_HAND.filled(steps=", ".join(by_hand))
    catalog = recording.catalog
    engine, seen, closest = TestEngine(test, catalog), set[str](), _Closest()
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
                closest.look(engine, time)
                continue
            if engine.result.outcome is not VerdictKind.UNKNOWN:
                return engine.result
            undecided = undecided or engine.result
            engine = TestEngine(test, catalog)
    if undecided is not None:
        return undecided
    if lacking := [name for name in test.channels if name not in seen]:
        return _LACKING.filled(names=", ".join(lacking))
    if (step := engine.progress().step) is None:
        return closest.added_to(_NO_START.filled(needs=test.needs))
    return closest.added_to(_NO_STEP.filled(step=test.steps[step].text))


class _Closest:
    """The moment at which the fewest conditions of the present step were unmet."""

    def __init__(self) -> None:
        self._step: int | None = None
        self._unmet: tuple[Unmet, ...] | None = None
        self._next = -inf

    def look(self, engine: TestEngine, time: float) -> None:
        """Look at a test once a second."""
        if time < self._next:
            return
        self._next = time + 1.0
        progress = engine.progress()
        if progress.step != self._step:
            self._step, self._unmet = progress.step, None
        if progress.phase is ProgressPhase.PREPARE:
            return
        values = all(it.value is not None for it in progress.unmet)
        if values and (self._unmet is None or len(progress.unmet) < len(self._unmet)):
            self._unmet = progress.unmet

    def added_to(self, reason: Text) -> Text:
        """Return the reason, with what was missing at the closest moment."""
        if self._unmet is None:
            return reason
        if not self._unmet:
            return joined("; ", [reason, _TOO_SHORT])
        texts = joined("; ", [it.text for it in self._unmet])
        return joined("; ", [reason, _CLOSEST.filled(unmet=texts)])


_TOO_SHORT: Final = Text("its conditions held for too short a time", "условия держались мало")
_CLOSEST: Final = Text("at the closest moment: {unmet}", "ближе всего было: {unmet}")
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
