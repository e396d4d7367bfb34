"""A test in progress: rows with times in, the present step and at the end the result out.

No clock and no line: the time is that of the rows, so a running session, a simulated one and a
recording are the same. The order is fixed: the start condition, then each step until it is done or
skipped. A step never fails by itself: after its timeout its advice is shown and it goes on.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import StrEnum
from math import isfinite
from typing import Final

from mikas.catalog import Catalog
from mikas.catalog.formulas import Calculation
from mikas.catalog.ignition_only import InjectionWatch
from mikas.guided.definition import SECONDS, GuidedStep, GuidedTest, Measure, parameters_of
from mikas.guided.measuring import StepRows, Values, formulas_inputs, holds, number_of
from mikas.guided.result import MOST_POINTS, Curve, Number, StepDone, TestResult
from mikas.guided.verdict import judge
from mikas.guided.waiting import Unmet, unmet
from mikas.i18n import Text

_BACK: Final = 0.5  # s by which rows may come late; more, and the clock has run back
_START_GAP: Final = 2.0  # s that values of the start condition may be old
_START_HOLD: Final = 0.5


class ProgressPhase(StrEnum):
    """What the test waits for."""

    START = "start"  # the start condition
    PREPARE = "prepare"  # the driver's hands
    UNTIL = "until"  # the condition of the step
    HOLD = "hold"  # the condition holds; its time runs
    DONE = "done"


@dataclass(frozen=True, slots=True)
class Progress:
    """The state of a test, `now`. `step`: its number from 0; None before the first.

    `seconds`: since the step began, or the wait for the first; `held` of `hold`: how long its
    condition has held; `late`: longer than its timeout. `values`: of the watched channels; `unmet`:
    the conditions that keep the test waiting; `lacking`: parameters of the test without a value
    just now.
    """

    phase: ProgressPhase
    step: int | None
    seconds: float
    held: float
    hold: float
    late: bool
    values: Mapping[str, float]
    unmet: tuple[Unmet, ...]
    lacking: tuple[str, ...]


class TestEngine:
    """Runs `test` once. `result` is None until its last step is done.

    `start_gap`: seconds that values of the start condition may be old.
    """

    __test__ = False  # for pytest

    def __init__(
        self, test: GuidedTest, catalog: Catalog, *, start_gap: float = _START_GAP
    ) -> None:
        self.test = test
        self._start_gap = start_gap
        self.result: TestResult | None = None
        self._catalog = catalog
        self._values = Values(catalog)
        self._numbers: dict[str, Number] = {}
        self._done: list[StepDone] = []
        self._curves = {name: _CurveBuilder() for name in test.chart}
        self._time: float | None = None
        self._waiting_since: float | None = None
        self._begun: float | None = None  # the first step
        self._ready_since: float | None = None
        self._injection = InjectionWatch()
        self._start = Calculation(test.start) if test.start else None
        self._step: _StepRun | None = None

    def add_row(self, time: float, values: Mapping[str, float]) -> None:
        """Take a row: the values that were read at `time`, by the parameter's name."""
        if self.result is not None:
            return
        if self._time is not None and time < self._time - _BACK:
            self._restart_clock(time)
        if self._waiting_since is None:
            self._waiting_since = time
        self._time = time if self._time is None else max(self._time, time)
        self._values.add_row(time, values)
        self._injection.add_row(values)
        if self._step is None:
            if not self._ready(time):
                return
            self._begun = time
            self._enter(time)
        self._draw(time, values)
        assert self._step is not None
        if self._step.add_row(time, values):
            self._leave(time, skipped=False)

    def skip(self) -> None:
        """End the present step without its measures; before the first step nothing happens."""
        if self._step is not None and self._time is not None and self.result is None:
            self._leave(self._time, skipped=True)

    def skip_all(self, names: Collection[str]) -> None:
        """Skip the present step, and those after it, while they are among `names`."""
        while self._step is not None and self.result is None and self._step.step.name in names:
            self.skip()

    def progress(self, now: float | None = None) -> Progress:
        """Return the state; `now`: the link's time, by default that of the last row."""
        last = self._time or 0.0
        now = last if now is None else max(now, last)
        run = self._step
        if self.result is not None or run is None:
            phase = ProgressPhase.START if self.result is None else ProgressPhase.DONE
            names = formulas_inputs([self.test.start]) or self.test.steps[0].watch
            needed = parameters_of(self._catalog, names)
            gap, waits_for = self._start_gap, self.test.start
            seconds = 0.0 if self._waiting_since is None else now - self._waiting_since
        else:
            phase, names, needed = run.phase(now), run.step.watch, run.needed
            gap, seconds = max(_START_GAP, run.step.longest_gap), now - run.began
            waits_for = run.step.until
        values = self._values.at(now, names, gap)
        waiting: tuple[Unmet, ...] = ()
        if phase in (ProgressPhase.START, ProgressPhase.UNTIL) and waits_for is not None:
            inputs = self._values.at(now, formulas_inputs([waits_for]), gap)
            waiting = unmet(waits_for, {**inputs, SECONDS: seconds}, self._catalog)
        lacking = () if phase is ProgressPhase.DONE else self._values.lacking(now, needed, gap)
        return Progress(
            phase=phase,
            step=None if run is None else len(self._done),
            seconds=seconds,
            held=run.held(now) if run else 0.0,
            hold=run.step.hold if run else 0.0,
            late=run is not None and seconds > run.step.timeout,
            values=values,
            unmet=waiting,
            lacking=lacking,
        )

    def _ready(self, time: float) -> bool:
        if self._start is None:
            return True
        values = self._values.at(time, self._start.inputs, self._start_gap)
        if not holds(self._start, values):
            self._ready_since = None
        elif self._ready_since is None:
            self._ready_since = time
        return self._ready_since is not None and time - self._ready_since >= _START_HOLD

    def _enter(self, time: float) -> None:
        step = self.test.steps[len(self._done)]
        measures = [each for each in self.test.measures.values() if each.step == step.name]
        self._step = _StepRun(step, measures, self._catalog, self._values, time)

    def _leave(self, time: float, *, skipped: bool) -> None:
        run = self._step
        assert run is not None
        self._numbers |= run.numbers(time, skipped=skipped)
        step = run.step
        self._done.append(StepDone(step.name, step.text, run.began, time, skipped))
        if len(self._done) < len(self.test.steps):
            self._enter(time)
            return
        self._step = None
        self._finish(time)

    def _finish(self, time: float) -> None:
        done = [step.name for step in self._done if not step.skipped]
        dead = self._injection.ignition_only
        outcome, findings, missing = judge(self.test, self._numbers, done, ignition_only=dead)
        channels = ((self._catalog.formula_channel(name), it) for name, it in self._curves.items())
        self.result = TestResult(
            test=self.test.name,
            title=self.test.title,
            began=time if self._begun is None else self._begun,
            ended=time,
            outcome=outcome,
            findings=findings,
            missing=missing,
            numbers=tuple(self._numbers[name] for name in self.test.measures),
            steps=tuple(self._done),
            curves=tuple(
                it.curve(channel.name, channel.short, channel.unit_text) for channel, it in channels
            ),
        )

    def _draw(self, time: float, values: Mapping[str, float]) -> None:
        latest = self._values.at(time, tuple(self._curves), _START_GAP)
        for name, curve in self._curves.items():
            if name in latest and (name in values or name in self._catalog.derived):
                curve.add(time, latest[name])

    def _restart_clock(self, time: float) -> None:
        """Restart the present step, and the times of the test, on a clock that was set back."""
        self._time = time
        self._values.clear()
        self._ready_since = None
        self._waiting_since = time
        if self._step is not None:
            self._begun = time
            self._curves = {name: _CurveBuilder() for name in self._curves}
            self._enter(time)


class _StepRun:
    """One step in progress since `began`."""

    def __init__(
        self,
        step: GuidedStep,
        measures: list[Measure],
        catalog: Catalog,
        values: Values,
        began: float,
    ) -> None:
        self.step, self.began = step, began
        self._ready_at = began + step.prepare
        self._measures, self._catalog, self._values = measures, catalog, values
        self._until = Calculation(step.until) if step.until else None
        inputs = formulas_inputs([step.until, *(f for each in measures for f in each.formulas)])
        self.needed = parameters_of(catalog, inputs)
        self._rows = StepRows(self.needed, began)
        self._held_since: float | None = None
        self._last = began  # the row before

    def add_row(self, time: float, fresh: Mapping[str, float]) -> bool:
        """Take a row; return whether the step is done."""
        if time < self._ready_at:
            return False
        step = self.step
        if self.needed and not any(name in fresh for name in self.needed):
            return False
        is_gap, is_held = time - self._last > step.longest_gap, self._holds(time)
        self._last = time
        if is_gap or not is_held:
            self._held_since = None
            if not step.whole:
                self._rows.clear()
        if is_held or step.whole:
            self._rows.add(time, self._values.at(time, self.needed, step.longest_gap), fresh)
        if is_held and self._held_since is None:
            self._held_since = time
        return self._held_since is not None and time - self._held_since >= step.hold

    def _holds(self, time: float) -> bool:
        """Return whether the condition holds."""
        if self._until is None:
            return True
        values = self._values.at(time, self._until.inputs, self.step.longest_gap)
        return holds(self._until, {**values, "SECONDS": time - self.began})

    def numbers(self, time: float, *, skipped: bool) -> dict[str, Number]:
        """Return the values of the measures at the end of the step."""
        if skipped:
            return {each.name: number_of(each, None, why=_SKIPPED) for each in self._measures}
        return {
            each.name: self._rows.measured(each, self.step, time, self._catalog)
            for each in self._measures
        }

    def phase(self, now: float) -> ProgressPhase:
        """Return what the step waits for."""
        if now < self._ready_at:
            return ProgressPhase.PREPARE
        return ProgressPhase.UNTIL if self._held_since is None else ProgressPhase.HOLD

    def held(self, now: float) -> float:
        """Return how long the condition has held; while it waits, the seconds of preparation."""
        if now < self._ready_at or self._held_since is None:
            return 0.0
        return min(self.step.hold, now - self._held_since)


class _CurveBuilder:
    """A channel's lowest and highest values in spans that grow with the test."""

    def __init__(self) -> None:
        self._points: list[tuple[float, float, float]] = []
        self._width = 0.0

    def add(self, time: float, value: float) -> None:
        if not isfinite(value):
            return
        points = self._points
        if points and 0 <= time - points[-1][0] < self._width:
            began, low, high = points[-1]
            points[-1] = began, min(low, value), max(high, value)
            return
        points.append((time, value, value))
        if len(points) > MOST_POINTS:
            pairs = zip(points[::2], points[1::2], strict=False)
            rest = points[len(points) // 2 * 2 :]
            joined = [(a[0], min(a[1], b[1]), max(a[2], b[2])) for a, b in pairs]
            self._points = joined + rest
            self._width = max(2 * self._width, (time - self._points[0][0]) / len(self._points))

    def curve(self, name: str, text: Text, unit: Text) -> Curve:
        columns = zip(*self._points, strict=True) if self._points else ((), (), ())
        times, lows, highs = (tuple(round(it, 4) for it in column) for column in columns)
        return Curve(name, text, unit, times, lows, highs)


_SKIPPED: Final = Text("the step was skipped", "шаг пропущен")
