"""Finds when the engine was at warm idle, by rules that the report prints.

The bounds are wider than the references: they distinguish warm idle from other states, not a good
one from a bad one. An idle at 1150 rpm is found, and then rated as high.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, nan
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.cancellation import check_cancelled
from mikas.guided.definition import IDLE_THROTTLE
from mikas.i18n import Text
from mikas.recording.table.channels import Rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Column = NDArray[np.float64]
    Mask = NDArray[np.bool_]

SETTLING: Final = 3.0  # s from when all rules hold until values count
PAUSE: Final = 3.0  # s without a response that end a span
ENOUGH: Final = 10.0  # s of warm idle in all; with less no value is rated


@dataclass(frozen=True, slots=True)
class IdleRule:
    """The limits of one channel at warm idle: of the first of `names` that was recorded.

    `holds`: for how many seconds its last value is valid.
    """

    text: Text
    names: tuple[str, ...]
    low: float
    high: float
    holds: float


@dataclass(frozen=True, slots=True)
class RuleResult:
    """The result of a rule: its channel (None: not recorded), the range of its values (infinite: it
    had none), and whether the rule ever held. `missing`: seconds without a valid value; `instead`:
    the rule used where its own channel was not read.
    """

    rule: IdleRule
    name: str | None
    least: float
    most: float
    held: bool
    missing: float
    instead: IdleRule | None


COOLANT: Final = IdleRule(
    Text("coolant at 70 °C or more", "охлаждающая жидкость не холоднее 70 °C"),
    ("TWAT",), 70, inf, 15,
)  # fmt: skip
SPEED: Final = IdleRule(
    Text("500 to 1300 rpm", "500–1300 об/мин"), ("FREQ", "FREQX"), 500, 1300, PAUSE
)
THROTTLE: Final = IdleRule(
    Text(
        f"throttle at {IDLE_THROTTLE} % or less",
        f"дроссель открыт не больше чем на {IDLE_THROTTLE} %",
    ),
    ("THR",), -inf, IDLE_THROTTLE, PAUSE,
)  # fmt: skip
IDLE_FLAG: Final = IdleRule(
    Text("the unit's idle flag", "признак холостого хода"), ("RXX",), 1, 1, PAUSE
)


@dataclass(frozen=True, slots=True)
class WarmIdle:
    """The spans of warm idle, in the time of the data, and the result of each rule."""

    spans: tuple[tuple[float, float], ...]
    rules: tuple[RuleResult, ...]

    @property
    def seconds(self) -> float:
        """The duration of warm idle in all."""
        return sum(ended - began for began, ended in self.spans)

    @property
    def enough(self) -> bool:
        """Whether it lasted long enough for a rating."""
        return self.seconds >= ENOUGH

    @property
    def unknown(self) -> tuple[IdleRule, ...]:
        """The rules whose channels were not recorded."""
        return tuple(result.rule for result in self.rules if result.name is None)

    @property
    def never_below(self) -> float | None:
        """The lowest speed, rpm, where only speed ruled out warm idle, as too high; else None."""
        (speed,) = (each for each in self.rules if each.rule is SPEED)
        others = all(each.held for each in self.rules if each is not speed)
        return speed.least if others and not speed.held and SPEED.high < speed.least < inf else None


class WarmIdleFinder:
    """Finds warm idle in consecutive blocks of rows; `recorded`: their channels."""

    def __init__(self, recorded: Iterable[str]) -> None:
        names = set(recorded)
        self._watches = [
            _RuleWatch(names, *rules) for rules in ((COOLANT,), (SPEED,), (THROTTLE, IDLE_FLAG))
        ]
        self._last = -inf  # the last row's time
        self._since: float | None = None  # since when all rules hold without a pause
        self._spans: list[tuple[float, float]] = []

    @property
    def found(self) -> WarmIdle:
        """The result so far. A single moment is no span."""
        spans = tuple(each for each in self._spans if each[1] > each[0])
        return WarmIdle(spans, tuple(watch.result for watch in self._watches))

    def find(self, rows: Rows) -> Mask:
        """Return which of these rows are at warm idle, and settled."""
        times = rows.times
        if not times.size:
            return np.zeros(0, np.bool_)
        holds = np.ones(times.size, np.bool_)
        steps = np.diff(times, prepend=self._last)
        joined = (steps >= 0) & (steps <= PAUSE)
        passed = np.where(joined, steps, 0.0)
        for watch in self._watches:
            check_cancelled()
            holds &= watch.holds(rows, passed)
        since = self._holding_since(times, holds, joined)
        settled = holds & (times - since >= SETTLING)
        self._keep_spans(times, settled, joined)
        self._last = float(times[-1])
        return settled

    def _holding_since(self, times: Column, holds: Mask, joined: Mask) -> Column:
        """Return since when all rules hold, for each row; that may lie in an earlier block."""
        before = np.concatenate(([self._since is not None], holds[:-1]))
        begins = holds & ~(before & joined)
        at = np.maximum.accumulate(np.where(begins, np.arange(times.size), -1))
        earlier = inf if self._since is None else self._since
        since = np.where(at >= 0, times[at], earlier)
        self._since = float(since[-1]) if holds[-1] else None
        return since

    def _keep_spans(self, times: Column, settled: Mask, joined: Mask) -> None:
        before = np.concatenate(([self._goes_on], settled[:-1]))
        begins = np.flatnonzero(settled & ~(before & joined))
        rows = np.flatnonzero(settled)
        if not rows.size:
            return
        starts = np.searchsorted(rows, begins)
        ends = np.concatenate((rows[starts[starts > 0] - 1], rows[-1:]))
        if settled[0] and not (begins.size and begins[0] == 0):
            began, _ = self._spans.pop()
            self._spans.append((began, float(times[ends[0]])))
            ends = ends[1:]
        self._spans += [
            (float(times[begin]), float(times[end]))
            for begin, end in zip(begins, ends, strict=True)
        ]

    @property
    def _goes_on(self) -> bool:
        """Whether the last row was in a span."""
        return bool(self._spans) and self._spans[-1][1] == self._last


class _RuleWatch:
    """One rule, by the best channel that was read at the time: the plan may change.

    Of the recorded channels the best is first; without one, the rule has an empty watch.
    """

    def __init__(self, recorded: set[str], *rules: IdleRule) -> None:
        self._watches = [
            ChannelWatch(rule, name) for rule in rules for name in rule.names if name in recorded
        ] or [ChannelWatch(rules[0], None)]
        self._held = False
        self._missing = 0.0
        self._instead: IdleRule | None = None

    @property
    def result(self) -> RuleResult:
        first = self._watches[0]
        return RuleResult(
            first.rule,
            first.name,
            first.least,
            first.most,
            self._held,
            self._missing,
            self._instead,
        )

    def holds(self, rows: Rows, passed: Column) -> Mask:
        """Return where the rule holds; `passed`: seconds since the previous row."""
        fits = np.zeros(rows.times.size, np.bool_)
        valid = fits.copy()
        for watch in self._watches:
            fresh, fit = watch.look(rows)
            if watch.rule is not self._watches[0].rule and (fresh & ~valid).any():
                self._instead = watch.rule
            fits |= fit & ~valid
            valid |= fresh
        self._held = self._held or bool(fits.any())
        self._missing += float(passed[~valid].sum())
        return fits


@dataclass(slots=True)
class ChannelWatch:
    """One channel over the rows: where it is valid, where it fits the rule, and its range."""

    rule: IdleRule
    name: str | None
    least: float = inf
    most: float = -inf
    _last: tuple[float, float] = (-inf, nan)  # time and value

    def look(self, rows: Rows) -> tuple[Mask, Mask]:
        """Where the channel's last value is fresh enough, and there within the rule."""
        column = rows.values.get(self.name) if self.name else None
        if column is None:
            return np.zeros(rows.times.size, np.bool_), np.zeros(rows.times.size, np.bool_)
        finite = column[np.isfinite(column)]
        if finite.size:
            self.least = min(self.least, float(finite.min()))
            self.most = max(self.most, float(finite.max()))
        times = np.concatenate(([self._last[0]], rows.times))
        values = np.concatenate(([self._last[1]], column))
        latest = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(values.size), 0))
        self._last = float(times[latest[-1]]), float(values[latest[-1]])
        age = rows.times - times[latest[1:]]
        held = values[latest[1:]]
        fresh = (age >= 0) & (age <= self.rule.holds) & np.isfinite(held)
        fits = fresh & (held >= self.rule.low) & (held <= self.rule.high)
        return fresh, fits
