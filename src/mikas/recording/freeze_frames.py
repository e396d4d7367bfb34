"""Freeze frames: the values around the moment at which a fault was stored.

The unit gives the numbers of its faults, not their times. So a fault appeared between the last
reading without it and the first with it (`sampling/fault_watch.py`), and a frame has both times,
and the values from five seconds before the one to five seconds after the other. A fault that was
stored before anything was read has no frame; nor has one whose moment is unknown by more than a
minute. The frames of a recording are in `recorded_faults.py`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, isfinite, isnan, nan
from typing import Any, Final

from mikas.catalog import Fault
from mikas.cleaning import clean_line, is_in_calendar
from mikas.recording.annotations.fields import number_of
from mikas.recording.table.channels import Rows
from mikas.recording.table.decimation import decimated
from mikas.sampling.events import Event, FaultReading, Gap, UnitFound
from mikas.sampling.fault_watch import MINERR, appeared

AROUND: Final = 5.0  # s before and after
LONGEST: Final = 60.0  # s between the two readings
_MOST_ROWS: Final = 600
_MOST_COLUMNS: Final = 300
_NAME: Final = 40
_USUAL: Final = ("FREQ", "TWAT", "JAIR", "UACC", "THR")
"""Shown beside the channels of the fault, up to five in all: what the engine was doing."""


_STILL: Final = 0.5  # s after the last value before a gap in which it still is of the moment


@dataclass(frozen=True, slots=True)
class Breaks:
    """Where the values of a moment end: at a gap, with a connection, with a unit.

    `gaps`: the times of the last values before them; `connections`: of their begins; `units`: when
    another one answered.
    """

    gaps: tuple[float, ...] = ()
    connections: tuple[float, ...] = ()
    units: tuple[float, ...] = ()

    @classmethod
    def of(cls, events: Iterable[Event]) -> Breaks:
        """Return those of the events of one recording."""
        gaps, units = [], []
        for event in events:
            if isinstance(event, Gap):
                gaps.append(event.began)
            elif isinstance(event, UnitFound) and event.another:
                units.append(event.time)
        return cls(gaps=tuple(gaps), units=tuple(units))

    def of_unit(self, moment: float) -> tuple[float, float]:
        """Return from when to when the unit of `moment` answered."""
        since = max((time for time in self.units if time <= moment), default=-inf)
        return since, min((time for time in self.units if time > moment), default=inf)

    def lie_between(self, value: float, moment: float) -> bool:
        """Return whether a value of the time `value` is none of `moment`."""
        if any(value < begin <= moment for begin in (*self.connections, *self.units)):
            return True
        return moment - value > _STILL and any(value <= began < moment for began in self.gaps)


_NO_BREAKS: Final = Breaks()


@dataclass(frozen=True, slots=True)
class ValueThen:
    """A channel's value when the fault was first seen; lowest and highest since `without`."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class FreezeFrame:
    """The rows around a fault: `values` by channel, as long as `times`; NaN is missing.

    The fault was not stored at `without`, and was at `seen`. `then`: the values of that moment, by
    channel, those of all rows, and none from before a gap or of an earlier connection. Of many rows
    a channel's extremes are kept (`table/decimation.py`).
    """

    code: int
    without: float
    seen: float
    times: tuple[float, ...]
    values: Mapping[str, tuple[float, ...]]
    then: Mapping[str, ValueThen]

    @property
    def id(self) -> str:
        """The name of the frame among those of its unit."""
        return f"{self.seen:.3f}-{self.code}"

    def moved(self, seconds: float) -> FreezeFrame:
        """Return the frame that is `seconds` later."""
        times = tuple(time + seconds for time in self.times)
        without, seen = self.without + seconds, self.seen + seconds
        return replace(self, without=without, seen=seen, times=times)

    def as_json(self) -> dict[str, Any]:
        """Return the frame as it is kept in a file."""
        columns = {
            name: [None if isnan(value) else value for value in column]
            for name, column in self.values.items()
        }
        about = {"schema": 1, "code": self.code, "without": self.without, "seen": self.seen}
        then = {name: [it.value, it.low, it.high] for name, it in self.then.items()}
        return {**about, "times": list(self.times), "values": columns, "then": then}


@dataclass(frozen=True, slots=True)
class AppearedFault:
    """A fault that a reading at `read` has and the one at `before` has not; None: no `frame`."""

    code: int
    before: float
    read: float
    frame: FreezeFrame | None


def frame_of(
    code: int, before: float, read: float, rows: Rows, breaks: Breaks = _NO_BREAKS
) -> FreezeFrame | None:
    """Return the frame of the fault `code`; None if its moment is not known, or without values.

    `before`, `read`: of the last reading of the faults without it, and of the first with it. No row
    is of another unit than that reading.
    """
    since, until = breaks.of_unit(read)
    rows = rows.part((rows.times >= since) & (rows.times < until))
    times, lowest = rows.times.tolist(), rows.values.get(MINERR)
    readings = ((), ()) if lowest is None else (times, lowest.tolist())
    without, seen = appeared(code, before, read, *readings)
    if not 0 <= seen - without <= LONGEST:
        return None
    around = rows.part((rows.times >= without - AROUND) & (rows.times <= seen + AROUND))
    kept = {
        name: column
        for name, column in around.values.items()
        if not all(map(isnan, column.tolist()))
    }
    listed = {name: column.tolist() for name, column in kept.items()}
    then = _values_then(without, seen, around.times.tolist(), listed, breaks)
    if not then:
        return None
    fewer = decimated(Rows(around.times, kept), _MOST_ROWS)
    columns = {name: tuple(column.tolist()) for name, column in fewer.values.items()}
    return FreezeFrame(code, without, seen, tuple(fewer.times.tolist()), columns, then)


def _values_then(
    without: float,
    seen: float,
    times: Sequence[float],
    values: Mapping[str, Sequence[float]],
    breaks: Breaks = _NO_BREAKS,
) -> dict[str, ValueThen]:
    """Return the values of the moment; a channel not read in the seconds before is left out."""
    found: dict[str, ValueThen] = {}
    for name, column in values.items():
        pairs = zip(times, column, strict=True)
        known = [(time, value) for time, value in pairs if time <= seen and not isnan(value)]
        if known and known[-1][0] >= seen - AROUND and not breaks.lie_between(known[-1][0], seen):
            last = known[-1][1]
            within = [value for time, value in known if time >= without] or [last]
            found[name] = ValueThen(last, min(within), max(within))
    return found


def shown_first(fault: Fault, names: Collection[str]) -> list[str]:
    """Return the channels of a frame to show first: those of the fault, the usual ones, others."""
    wanted = dict.fromkeys((*fault.parameters, *_USUAL, *names))
    count = max(len(fault.parameters), len(_USUAL))
    return [name for name in wanted if name in names][:count]


def new_faults(readings: Sequence[FaultReading]) -> Iterator[tuple[int, float, float]]:
    """Yield each fault that a reading has and the one before has not, with the times of both."""
    for before, reading in pairwise(readings):
        for code in reading.codes:
            if code not in before.codes:
                yield code, before.time, reading.time


def first_seen(code: int, readings: Sequence[FaultReading]) -> float:
    """Return the time of the reading since which all readings have `code`; the last has it."""
    since = readings[-1].time
    for reading in reversed(readings):
        if code not in reading.codes:
            break
        since = reading.time
    return since


def frame_from(stored: Any) -> FreezeFrame | None:  # noqa: ANN401  (any JSON)
    """Return the frame of a file's JSON; None if it is none."""
    if not isinstance(stored, dict):
        return None
    code, times, values = stored.get("code"), stored.get("times"), stored.get("values")
    without, seen = _number(stored.get("without")), _number(stored.get("seen"))
    if not (isinstance(code, int) and 0 <= code <= 255 and isinstance(times, list)):
        return None
    if len(times) > 2 * _MOST_ROWS or not isinstance(values, dict) or len(values) > _MOST_COLUMNS:
        return None
    instants = tuple(map(_number, times))
    if not all(is_in_calendar(abs(time)) for time in (without, seen, *instants)):
        return None
    columns = {
        clean_line(name, _NAME): tuple(map(_number, column))
        for name, column in values.items()
        if isinstance(column, list) and len(column) == len(instants)
    }
    kept = stored.get("then")  # files of earlier versions have none
    then = _stored_then(kept) if kept else _values_then(without, seen, instants, columns)
    return FreezeFrame(code, without, seen, instants, columns, then)


def _stored_then(stored: object) -> dict[str, ValueThen]:
    """Return the values of the moment in a file."""
    items = list(stored.items())[:_MOST_COLUMNS] if isinstance(stored, dict) else []
    found = {
        clean_line(name, _NAME): ValueThen(*map(_number, numbers))
        for name, numbers in items
        if isinstance(numbers, list) and len(numbers) == 3
    }
    return {
        name: it for name, it in found.items() if not any(map(isnan, (it.value, it.low, it.high)))
    }


def _number(value: object) -> float:
    """Return a finite number; NaN for anything else."""
    number = number_of(value)
    return number if number is not None and isfinite(number) else nan
