"""The rows of a drive as features look at them, and what a feature is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isnan
from typing import Final

from mikas.causes.regimes import DriveByRegime, Regime
from mikas.causes.samples import PAUSE, Column, Span, median, quantile, spans_of
from mikas.virtual.model import physics as ph

FADING: Final = 5.0  # s of an idle until it is even
COASTING: Final = 350.0  # rpm above the median of idle


@dataclass(frozen=True, slots=True)
class Seen:
    """A feature's value, the value to show (before any logarithm), where it was seen."""

    value: float
    shown: float
    spans: tuple[Span, ...]


Compute = Callable[["View"], Seen | None]


class View:
    """A drive as features look at it."""

    def __init__(self, drive: DriveByRegime) -> None:
        self.drive = drive
        self.times: Column = drive.samples.times
        warm, mild = self._late(drive.at(Regime.WARM_IDLE)), self._late(drive.at(Regime.MILD_IDLE))
        self.warm: list[int] = self._standing(self._settled(warm))
        self.cold: list[int] = self._standing(self._settled(drive.at(Regime.COLD_IDLE)))
        self.idle: list[int] = self._standing(self._settled(sorted([*warm, *mild])))
        self.load: list[int] = drive.at(Regime.PART_LOAD, Regime.FULL_LOAD)
        self._expected: dict[int, float] | None = None

    def column(self, name: str) -> Column | None:
        """Return a column; None: not read."""
        return self.drive.samples.column(name)

    def _late(self, rows: Sequence[int]) -> list[int]:
        return [row for row in rows if self.drive.run_time[row] > 25.0]

    def _settled(self, rows: Sequence[int]) -> list[int]:
        """Return the rows without the first seconds of each idle: the speed is still falling."""
        kept = []
        since = last = -1e9
        for row in rows:
            time = self.times[row]
            if time - last > PAUSE:
                since = time
            last = time
            if time - since >= FADING:
                kept.append(row)
        return kept

    def _standing(self, rows: Sequence[int]) -> list[int]:
        """Return the rows without those in which the car coasts in gear: far above its idle."""
        idle = median([self.drive.speed[row] for row in rows])
        return [row for row in rows if self.drive.speed[row] <= idle + COASTING]

    def values(self, name: str, rows: Sequence[int]) -> list[float]:
        """Return the values of a channel in these rows, the missing left out."""
        column = self.column(name)
        if column is None:
            return []
        return [value for row in rows if not isnan(value := column[row])]

    def seconds(self, rows: Sequence[int]) -> float:
        """Return about how long these rows last."""
        if not rows:
            return 0.0
        count = len(self.times)
        step = self.drive.samples.seconds / (count - 1) if count > 1 else 0.0
        return len(rows) * min(step, 1.0) if step else 0.0

    def expected(self) -> dict[int, float]:
        """Return by row under load the air, kg/h, of throttle, idle valve and speed."""
        if self._expected is None:
            self._expected = self._compute_expected()
        return self._expected

    def _compute_expected(self) -> dict[int, float]:
        throttle, valve = self.column("THR"), self.column("FSM") or self.column("SSM")
        intake = self.column("TAIR")
        if throttle is None or self.column("JAIR") is None:
            return {}
        found = {}
        for row in self.drive.running:
            if isnan(throttle[row]):
                continue
            steps = valve[row] if valve is not None and not isnan(valve[row]) else 30.0
            demand = ph.demand(self.drive.speed[row])
            inlet = ph.throttle_air(throttle[row]) + steps * ph.VALVE_FLOW
            warmth = intake[row] if intake is not None and not isnan(intake[row]) else 20.0
            found[row] = ph.manifold(inlet, demand) * demand * ph.density(warmth)
        return found

    def steady_load(self) -> list[int]:
        """Return rows under load in which the throttle has been steady for a while."""
        throttle = self.column("THR")
        if throttle is None:
            return []
        rows = []
        for row in self.load:
            if row >= 4:
                window = throttle[row - 4 : row + 1]
                if max(window) - min(window) <= 3.0 and self.times[row] - self.times[row - 4] < 4:
                    rows.append(row)
        return rows

    def seen(self, value: float, rows: Sequence[int], shown: float | None = None) -> Seen | None:
        """Return what was seen in these rows; None: no number."""
        if isnan(value):
            return None
        return Seen(value, value if shown is None else shown, spans_of(self.times, rows))


@dataclass(frozen=True, slots=True)
class Feature:
    """A feature by name. `context`: the value that it depends on in a sound car, too."""

    name: str
    compute: Compute
    context: str = ""


def middle(name: str, rows: str, seconds: float, share: float = 0.5) -> Compute:
    """Return the feature of a quantile of a channel in these rows."""

    def compute(view: View) -> Seen | None:
        chosen: list[int] = getattr(view, rows)
        if view.seconds(chosen) < seconds:
            return None
        return view.seen(quantile(view.values(name, chosen), share), chosen)

    return compute


def width(name: str, rows: str, seconds: float) -> Compute:
    """Return the feature of the range of a channel in these rows."""

    def compute(view: View) -> Seen | None:
        chosen: list[int] = getattr(view, rows)
        values = view.values(name, chosen)
        if view.seconds(chosen) < seconds or not values:
            return None
        return view.seen(quantile(values, 0.95) - quantile(values, 0.05), chosen)

    return compute
