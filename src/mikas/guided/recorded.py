"""Guided tests in recordings: results kept as notes, and tests run over recorded rows."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite
from typing import TYPE_CHECKING, Final

from mikas.cancellation import check_cancelled
from mikas.guided.definition import GuidedStep, GuidedTest, VerdictKind
from mikas.guided.engine import ProgressPhase, TestEngine
from mikas.guided.measuring import number_of
from mikas.guided.result import TestResult, read
from mikas.guided.verdict import judge
from mikas.guided.waiting import Unmet
from mikas.i18n import Text, joined
from mikas.recording.capture.notes import Kind, Note

if TYPE_CHECKING:
    from mikas.catalog import Catalog
    from mikas.recording.recording import Recording

_MOST: Final = 50  # results of a recording
_CHECKED: Final = 1000  # rows between two checks for a cancellation
_MOST_FOUND: Final = 200  # times that a test or a step is found in a recording
_START_GAP: Final = 15.0  # s that values of the start condition may be old: slow channels


def results_of(notes: Iterable[Note]) -> tuple[TestResult, ...]:
    """Return the results among the notes of a recording, the last fifty."""
    found = (read(note.data) for note in notes if note.kind == Kind.TEST)
    return tuple(result for result in found if result is not None)[-_MOST:]


def run_over(
    test: GuidedTest, recording: Recording, skip: Collection[str] = ()
) -> TestResult | Text:
    """Return the first decided result of `test` over a recording, or else the first result; of a
    test whose steps may come in any order the weightiest. If its steps do not occur, return a text
    that says why.

    A test with a step that only a person knows to be done (`by_hand`) is never found, unless that
    is among the steps to `skip`.
    """
    by_hand = [step.name for step in test.steps if step.by_hand and step.name not in skip]
    if by_hand:
        return _BY_HAND.filled(steps=", ".join(by_hand))
    find = _in_any_order if test.any_order else _in_order
    return find(test, recording, skip)


def _in_order(test: GuidedTest, recording: Recording, skip: Collection[str]) -> TestResult | Text:
    """Run the test again and again, until a result is decided."""
    search, seen = _Search(test, recording.formula_catalog, skip), set[str]()
    for time, fresh in _rows(test, recording):
        seen |= fresh.keys()
        result = search.add_row(time, fresh)
        if result is not None and result.outcome is not VerdictKind.UNKNOWN:
            return result
    return search.results[0] if search.results else _why_not(test, search, seen)


def _in_any_order(
    test: GuidedTest, recording: Recording, skip: Collection[str]
) -> TestResult | Text:
    """Look for each step by itself, and return the result of the moments that decide most."""
    searches = {
        step.name: _Search(_alone(test, step), recording.formula_catalog)
        for step in test.steps
        if step.name not in skip
    }
    seen = set[str]()
    for time, fresh in _rows(test, recording):
        seen |= fresh.keys()
        for search in searches.values():
            search.add_row(time, fresh)
    for step in test.steps:
        search_of = searches.get(step.name)
        if search_of is not None and not search_of.results and not step.optional:
            return _why_not(test, search_of, seen)
    if not any(search.results for search in searches.values()):
        return _why_not(test, next(iter(searches.values())), seen) if searches else _NOTHING
    return _combined(test, {name: it.results for name, it in searches.items() if it.results})


def _alone(test: GuidedTest, step: GuidedStep) -> GuidedTest:
    """Return a test of this step alone, which judges nothing."""
    measures = {name: it for name, it in test.measures.items() if it.step == step.name}
    return replace(test, steps=(step,), measures=measures, rules=())


def _combined(test: GuidedTest, found: Mapping[str, Sequence[TestResult]]) -> TestResult:
    """Return the result of one moment of each step, those of the weightiest verdict."""

    def result(chosen: Mapping[str, TestResult]) -> TestResult:
        numbers = {it.name: it for one in chosen.values() for it in one.numbers}
        for name, measure in test.measures.items():
            numbers.setdefault(name, number_of(measure, None, why=_NOT_THERE))
        outcome, findings, missing = judge(test, numbers, found)
        parts = sorted(chosen.values(), key=lambda it: it.began)
        return replace(
            parts[-1],
            began=parts[0].began,
            ended=max(it.ended for it in parts),
            outcome=outcome,
            findings=findings,
            missing=missing,
            numbers=tuple(numbers[name] for name in test.measures),
            steps=tuple(step for it in parts for step in it.steps),
        )

    chosen = {name: candidates[0] for name, candidates in found.items()}
    for name, candidates in found.items():
        options = ({**chosen, name: each} for each in candidates)
        chosen = max(options, key=lambda it: _WEIGHT.index(result(it).outcome))
    return result(chosen)


def _why_not(test: GuidedTest, search: _Search, seen: Collection[str]) -> Text:
    if lacking := [name for name in (*test.channels, *test.beside) if name not in seen]:
        return _LACKING.filled(names=", ".join(lacking))
    return search.reason


def _rows(test: GuidedTest, recording: Recording) -> Iterator[tuple[float, dict[str, float]]]:
    """Yield the recorded rows: their times, and the values that are there."""
    beside = (name for name in test.beside if name in recording.instrument_channels)
    for rows in recording.interpreted("corrected", (*test.channels, *beside)).rows():
        columns = [(name, column.tolist()) for name, column in rows.values.items()]
        for number, time in enumerate(rows.times.tolist()):
            if number % _CHECKED == 0:
                check_cancelled()
            values = {name: column[number] for name, column in columns}
            yield time, {name: value for name, value in values.items() if isfinite(value)}


class _Search:
    """A test that starts again whenever it has ended."""

    def __init__(self, test: GuidedTest, catalog: Catalog, skip: Collection[str] = ()) -> None:
        self._test, self._catalog, self._skip = test, catalog, skip
        self._engine = TestEngine(test, catalog, start_gap=_START_GAP)
        self._closest = _Closest()
        self.results: list[TestResult] = []

    def add_row(self, time: float, fresh: Mapping[str, float]) -> TestResult | None:
        """Take a row; return the result of a test that ends with it."""
        engine = self._engine
        engine.add_row(time, fresh)
        engine.skip_all(self._skip)
        if (result := engine.result) is None:
            self._closest.look(engine, time)
            return None
        if len(self.results) < _MOST_FOUND:
            self.results.append(result)
        self._engine = TestEngine(self._test, self._catalog, start_gap=_START_GAP)
        return result

    @property
    def reason(self) -> Text:
        """Why the test is not finished."""
        if (step := self._engine.progress().step) is None:
            return self._closest.added_to(_NO_START.filled(needs=self._test.needs))
        return self._closest.added_to(_NO_STEP.filled(step=self._test.steps[step].text))


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
_WEIGHT: Final = (
    VerdictKind.UNKNOWN,
    VerdictKind.GOOD,
    VerdictKind.ATTENTION,
    VerdictKind.BAD,
)
_NOT_THERE: Final = Text("the recording does not have this step", "в записи этого шага нет")
_NOTHING: Final = Text("all steps are skipped", "все шаги пропущены")
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
