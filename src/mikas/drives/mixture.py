"""The mixture that the unit aims at (VALF) against the one that a meter measures (LAMBDA).

A meter answers late: the gas needs its time to the sensor, and the sensor its own. So a measured
value counts only if engine speed and load were steady in the second before, and is compared with
what the unit aimed at half a second before. Cells of speed and load each have their own figures: a
lean injector shows at idle, a weak pump at full load.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.catalog.ignition_only import RUNNING
from mikas.drives.curves import PAUSE, SampledCurve
from mikas.drives.finding import column_of, instrument_curve, session_rows
from mikas.recording.exchanges.arrays import Floats, Mask
from mikas.recording.table.channels import Rows

if TYPE_CHECKING:
    from mikas.recording.recording import Recording

LAMBDA: Final = "LAMBDA"
LOADS: Final = ("FILLING", "THR")
"""The channels of the load, the better one first."""
RPM_EDGES: Final = (500.0, 1100.0, 1600.0, 2200.0, 2800.0, 3500.0, 4500.0, 7000.0)
LOAD_EDGES: Final = (0.0, 20.0, 35.0, 50.0, 65.0, 80.0, 130.0)
AGREES: Final = 3.0
"""Per cent of difference that a meter's own error may be."""
SCATTERS: Final = 12.0
"""Per cent between the tenth and the ninetieth of a hundred values, from which a median is none."""
ENOUGH: Final = 30
"""Values of a cell, from which it is judged."""
LEANEST: Final = 1.3
"""λ above which the fuel is cut off, or a cylinder misses: no mixture that was aimed at."""
_SETTLING: Final = (0.0, 0.5, 1.0)  # s before, at which speed and load are looked at
_LAG: Final = 0.5  # s from the aim to the meter
_STEADY_RPM: Final = 160.0
_STEADY_LOAD: Final = 6.0  # %
_FRESH: Final = 1.0  # s that a value of the unit holds


class MixtureVerdict(StrEnum):
    """What a cell says."""

    AGREES = "agrees"
    LEANER = "leaner"
    RICHER = "richer"
    SCATTERS = "scatters"
    TOO_FEW = "too-few"


@dataclass(frozen=True, slots=True)
class MixtureCell:
    """The values of one range of speed and load.

    `difference`: the median of measured by aimed, in per cent above 1; `low`, `high`: the tenth and
    the ninetieth of a hundred of them.
    """

    rpm: tuple[float, float]
    load: tuple[float, float]
    count: int
    aimed: float
    measured: float
    difference: float
    low: float
    high: float

    @property
    def verdict(self) -> MixtureVerdict:
        """What follows from the figures."""
        if self.count < ENOUGH:
            return MixtureVerdict.TOO_FEW
        if self.high - self.low > SCATTERS:
            return MixtureVerdict.SCATTERS
        if abs(self.difference) <= AGREES:
            return MixtureVerdict.AGREES
        return MixtureVerdict.LEANER if self.difference > 0 else MixtureVerdict.RICHER


@dataclass(frozen=True, slots=True)
class MixtureComparison:
    """All cells that have values. `unsteady`, `lean`: measured values that were left out, because
    speed or load changed, or because λ was above 1.3. `load`: the channel of the load.
    """

    cells: tuple[MixtureCell, ...]
    load: str
    unsteady: int = 0
    lean: int = 0

    @property
    def judged(self) -> tuple[MixtureCell, ...]:
        """The cells with enough values."""
        return tuple(each for each in self.cells if each.verdict is not MixtureVerdict.TOO_FEW)


@dataclass(frozen=True, slots=True)
class _Values:
    """What was compared: an entry for each measured value that counts."""

    rpm: Floats
    load: Floats
    aimed: Floats
    measured: Floats


def compared_mixture(recording: Recording, session: int) -> MixtureComparison | None:
    """Return the comparison of a session; None without a meter, VALF, FREQ or a load."""
    known = recording.catalog.channels
    names = [name for name in ("FREQ", "VALF", *LOADS) if name in known]
    corrected = recording.interpreted("corrected", names)
    there = [name for name in names if name not in corrected.absent]
    load = next((name for name in LOADS if name in there), None)
    meter = instrument_curve(recording, session, LAMBDA)
    if meter is None or load is None or "FREQ" not in there or "VALF" not in there:
        return None
    stretches = (rows for _, rows in session_rows(corrected, session))
    return _compared(stretches, load, meter)


def mixture_of_live(rows: Rows) -> MixtureComparison | None:
    """Return the comparison of rows that have the meter's column, as of a running connection."""
    there = [name for name, column in rows.values.items() if np.isfinite(column).any()]
    load = next((name for name in LOADS if name in there), None)
    meter = column_of(rows, LAMBDA)
    if meter is None or load is None or "FREQ" not in there or "VALF" not in there:
        return None
    # Each row has the meter's latest value: of ten in a second each counts about once.
    ticks = np.floor(rows.times * 10)
    chosen = np.concatenate((np.ones(1, np.bool_), np.diff(ticks) != 0))[: len(ticks)]
    curve = SampledCurve(rows.times[chosen], rows.values[meter][chosen], PAUSE)
    return _compared([rows], load, curve)


def _compared(stretches: Iterable[Rows], load: str, meter: SampledCurve) -> MixtureComparison:
    known_values = np.isfinite(meter.values)
    times, measured = meter.times[known_values], meter.values[known_values]
    pieces: list[_Values] = []
    unsteady = lean = 0
    for rows in stretches:
        inside = (times >= rows.times[0]) & (times <= rows.times[-1] + _FRESH)
        values, is_running, is_steady = _beside(rows, load, times[inside], measured[inside])
        is_lean = values.measured > LEANEST
        unsteady += int(np.count_nonzero(is_running & ~is_steady))
        lean += int(np.count_nonzero(is_running & is_steady & is_lean))
        pieces.append(_chosen(values, is_running & is_steady & ~is_lean))
    return MixtureComparison(tuple(_cells(pieces)), load, unsteady, lean)


def _beside(rows: Rows, load: str, times: Floats, measured: Floats) -> tuple[_Values, Mask, Mask]:
    """Return the unit's values at each measured one, where the engine ran, and was steady."""
    speeds = [_latest(rows, "FREQ", times - before) for before in _SETTLING]
    loads = [_latest(rows, load, times - before) for before in _SETTLING]
    aimed = _latest(rows, "VALF", times - _LAG)
    is_running = np.isfinite(speeds[0]) & np.isfinite(loads[0]) & np.isfinite(aimed)
    is_running = is_running & (np.where(np.isfinite(speeds[0]), speeds[0], 0.0) >= RUNNING)
    is_running = is_running & (np.where(np.isfinite(aimed), aimed, 0.0) > 0)
    is_steady = _spread(speeds, _STEADY_RPM) & _spread(loads, _STEADY_LOAD)
    return _Values(speeds[0], loads[0], aimed, measured), is_running, is_steady


def _latest(rows: Rows, name: str, times: Floats) -> Floats:
    """Return the latest value of a channel at each time; NaN if it is too old."""
    there = np.isfinite(rows.values[name])
    at, values = rows.times[there], rows.values[name][there]
    if not len(at):
        return np.full(len(times), np.nan)
    place = np.searchsorted(at, times, "right") - 1
    latest = np.maximum(place, 0)
    found: Floats = np.where((place >= 0) & (times - at[latest] <= _FRESH), values[latest], np.nan)
    return found


def _spread(columns: list[Floats], most: float) -> Mask:
    """Return where all columns are known, and lie together within `most`."""
    low = high = columns[0]
    for column in columns[1:]:
        low, high = np.minimum(low, column), np.maximum(high, column)
    known = np.isfinite(low) & np.isfinite(high)
    return known & (np.where(known, high - low, np.inf) <= most)


def _chosen(values: _Values, mask: Mask) -> _Values:
    return _Values(values.rpm[mask], values.load[mask], values.aimed[mask], values.measured[mask])


def _cells(pieces: list[_Values]) -> Iterator[MixtureCell]:
    """Yield the cells with values, by speed, then by load."""
    if not pieces:
        return
    rpm = np.concatenate([each.rpm for each in pieces])
    load = np.concatenate([each.load for each in pieces])
    aimed = np.concatenate([each.aimed for each in pieces])
    measured = np.concatenate([each.measured for each in pieces])
    for slow, fast in pairwise(RPM_EDGES):
        for low, high in pairwise(LOAD_EDGES):
            mine = (rpm >= slow) & (rpm < fast) & (load >= low) & (load < high)
            if not mine.any():
                continue
            differences = 100 * (measured[mine] / aimed[mine] - 1)
            yield MixtureCell(
                (slow, fast),
                (low, high),
                int(np.count_nonzero(mine)),
                float(np.median(aimed[mine])),
                float(np.median(measured[mine])),
                float(np.median(differences)),
                float(np.percentile(differences, 10)),
                float(np.percentile(differences, 90)),
            )
