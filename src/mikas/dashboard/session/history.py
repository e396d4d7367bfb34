"""The values, events and stored faults of the last hours, for a reloaded page and the report.

Values are in blocks of rows by time, a column for each channel, 64-bit numbers: an hour at 35 sets
a second of 30 channels is 30 MB. NaN: the value was not read in that row; flags are 0 and 1. A
block has the channels of its time: a changed plan begins another one. Works without numpy, which a
browser does not have; `rows` are numpy's where it is installed.

The events are sampling's, and the dashboard's own two.
"""

from __future__ import annotations

import threading
from array import array
from bisect import bisect_left
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from heapq import merge
from itertools import repeat
from math import inf, nan
from typing import Any, Final, Self, TypeAlias

from mikas.catalog import Fault
from mikas.client import Ecu
from mikas.dashboard.errors import ADVICE, api_hex
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.recording.table.channels import Rows
from mikas.sampling.events import Event, FaultReading, Gap, Marker, MethodChosen, StateChanged
from mikas.tester import Failure

Compute: TypeAlias = (
    "Callable[[Sequence[float], Mapping[str, Sequence[float]]], Mapping[str, Sequence[float]]]"
)
Column: TypeAlias = Any  # an array, Python's or numpy's
_ROWS: Final = 2048
LONGEST: Final = 2 * 3600.0
_MAX_EVENTS: Final = 5000  # of errors, and of all others
_MAX_READINGS: Final = 100  # of stored faults, that differ
_MAX_VALUES: Final = 16_000_000  # 128 MB; of strokes at 6000 rpm with all channels


class _Block:
    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names
        self.times = array("d")
        self.columns = {name: array("d") for name in names}

    @property
    def size(self) -> int:
        return len(self.times) * len(self.names)

    def recomputed(self, names: Sequence[str], compute: Compute | None) -> _Block:
        """Return another block, as this one may be read at the moment."""
        own = dict(self.columns)
        made = compute(self.times, own) if compute else {}
        for name in names:
            own.pop(name, None)
            if name in made:
                own[name] = array("d", made[name])
        block = _Block(tuple(own))
        block.times, block.columns = self.times, own
        return block


_Part: TypeAlias = tuple[_Block, slice]


class History:
    """Rows of the last `seconds`. Any thread may add or read."""

    def __init__(self, seconds: float = LONGEST) -> None:
        self._seconds = seconds
        self._lock = threading.Lock()
        self._blocks: deque[_Block] = deque()
        self.count: int = 0
        """The rows that were ever added."""

    def add(self, time: float, names: tuple[str, ...], row: Sequence[float]) -> None:
        """Add one row; `row` has a number or NaN for each of `names`."""
        with self._lock:
            block = self._blocks[-1] if self._blocks else None
            if block is None or block.names != names or len(block.times) == _ROWS:
                block = _Block(names)
                self._blocks.append(block)
                self._drop_old(time)
            block.times.append(time)
            for column, value in zip(block.columns.values(), row, strict=True):
                column.append(value)
            self.count += 1

    def added(
        self, first: int, last: int, names: Sequence[str]
    ) -> tuple[array[float], dict[str, array[float]]]:
        """Return times and columns `names` of the rows from number `first` to before `last`."""
        parts: list[_Part] = []
        with self._lock:
            end = self.count
            for block in reversed(self._blocks):
                if end <= first:
                    break
                begin = end - len(block.times)
                parts.insert(0, (block, slice(max(first - begin, 0), max(last - begin, 0))))
                end = begin
            return _joined(parts, names)

    def rows(self, seconds: float, names: Sequence[str] | None = None) -> Rows:
        """Return the rows of the last `seconds`, of `names` or of every channel that they have."""
        with self._lock:
            blocks = [(block, len(block.times)) for block in self._blocks]
        if not blocks:
            return _rows(*_joined((), names or ()))
        since = blocks[-1][0].times[blocks[-1][1] - 1] - seconds
        parts = [
            (block, slice(at, count))
            for block, count in blocks
            if (at := bisect_left(block.times, since, 0, count)) < count
        ]
        channels = (name for block, _ in reversed(parts) for name in block.names)
        return _rows(*_joined(parts, channels if names is None else names))

    def recompute(self, names: Sequence[str], compute: Compute | None = None) -> None:
        """Replace the columns `names`, which mean something else now, block after block in time.

        `compute` returns the new columns that it can make of a block's times and columns; without
        it, and for the other names, the values are gone.
        """
        with self._lock:
            self._blocks = deque(block.recomputed(names, compute) for block in self._blocks)

    def _drop_old(self, now: float) -> None:
        blocks = self._blocks
        values = sum(block.size for block in blocks) + _ROWS * len(blocks[-1].names)
        while len(blocks) > 1 and (
            blocks[0].times[-1] < now - self._seconds or values > _MAX_VALUES
        ):
            values -= blocks.popleft().size


def _joined(
    parts: Sequence[_Part], names: Iterable[str]
) -> tuple[array[float], dict[str, array[float]]]:
    """Return times and columns `names` of the rows in `parts`; NaN where a block lacks a column."""
    times, columns = array("d"), {name: array("d") for name in names}
    for block, part in parts:
        some = block.times[part]
        times += some
        own = block.columns
        for name, column in columns.items():
            column.extend(own[name][part] if name in own else repeat(nan, len(some)))
    return times, columns


def _rows(times: array[float], columns: Mapping[str, array[float]]) -> Rows:
    import numpy as np

    return Rows(np.asarray(times), {name: np.asarray(each) for name, each in columns.items()})


def json_columns(
    times: Column, columns: Mapping[str, Column], later: float = 0.0
) -> dict[str, object]:
    """Return `{"names", "times", "values"}` as the API has it, the times `later` seconds later."""
    return {
        "names": list(columns),
        "times": [row_time(time + later) for time in times.tolist()],
        "values": [plain(column.tolist()) for column in columns.values()],
    }


def row_time(time: float) -> float:
    """Return a row's time as the API has it: to the microsecond."""
    return round(time, 6)


def plain(values: Sequence[float]) -> list[float | int | None]:
    """Return values for JSON: whole numbers as such, null for a missing one."""
    return [
        None if value != value else int(value) if value.is_integer() else value  # noqa: PLR0124  (NaN)
        for value in values
    ]


@dataclass(frozen=True, slots=True)
class StoredFaults:
    """The faults of the latest reading, and when each was first seen."""

    time: float
    faults: tuple[Fault, ...]
    first_seen: dict[int, float]


class FaultHistory:
    """Stored faults as last read, when each was first seen on this connection, earlier readings.

    Any thread may write and read. `latest` is None until this connection's first reading.
    `on_reading` is called with each reading, and with the one before by the same unit, if any.
    """

    def __init__(
        self, on_reading: Callable[[FaultReading, FaultReading | None], None] = lambda *_: None
    ) -> None:
        self._on_reading = on_reading
        self._lock = threading.Lock()
        self._readings: list[FaultReading] = []
        self._latest_reading: FaultReading | None = None  # by this unit, on any connection
        self.latest: StoredFaults | None = None

    def disconnect(self) -> None:
        """End the connection; the unit's earlier readings are kept for its next one."""
        with self._lock:
            self.latest = None

    def clear(self) -> None:
        """Drop everything: another unit answers."""
        with self._lock:
            self.latest = None
            self._readings.clear()
            self._latest_reading = None

    @property
    def readings(self) -> tuple[FaultReading, ...]:
        """The readings that differ from those before, and the latest; none without a latest one."""
        with self._lock:
            if self.latest is None:
                return ()
            return (*self._readings, FaultReading(self.latest.time, self._readings[-1].codes))

    def absent_at(self, code: int) -> float:
        """Return when a stored fault was last known to be absent; -inf: never here."""
        with self._lock:
            times = [it.time for it in self._readings if it.erased or code not in it.codes]
        return max(times, default=-inf)

    def read(self, ecu: Ecu) -> StoredFaults:
        """Read the stored faults; a job of the sampling thread."""
        return self.add(ecu.faults(), ecu.tester.link.now())

    def add(
        self,
        faults: Sequence[Fault],
        time: float,
        *,
        erased: bool = False,
        routine: bool = False,
    ) -> StoredFaults:
        """Add the faults that were stored at `time`; `erased`: shortly before.

        A fault that came back after it was erased is new.
        """
        with self._lock:
            codes = tuple(fault.code for fault in faults)
            before = self._latest_reading
            self._latest_reading = FaultReading(time, codes, erased, routine=routine)
            if not self._readings or self._readings[-1].codes != codes:
                self._readings.append(FaultReading(time, codes, erased))
                del self._readings[:-_MAX_READINGS]
            known = self.latest.first_seen if self.latest else {}
            first_seen = {code: known.get(code, time) for code in codes}
            self.latest = stored = StoredFaults(time, tuple(faults), first_seen)
        self._on_reading(self._latest_reading, before)
        return stored


@dataclass(frozen=True, slots=True)
class ExchangeFailed(Event):
    """An exchange failed; it may have been repeated with success."""

    kind = "error"
    code: str
    text: Text
    sent: str | None
    received: str | None

    @classmethod
    def of(cls, time: float, cause: MikasError | Failure) -> Self:
        """Return the event of the error that ended a cycle, or of a failure that was counted."""
        if isinstance(cause, Failure):
            code, text = cause.code, cause.reason
        else:
            code, text = type(cause).__name__, ADVICE.text(cause)
        return cls(time, code, text, api_hex(cause.request), api_hex(cause.received))


@dataclass(frozen=True, slots=True)
class RecordingChanged(Event):
    """A recording to `file` began (`on`), ended, or broke off with a `failure`."""

    kind = "recording"
    file: str
    on: bool
    failure: Text | None = None


@dataclass(frozen=True, slots=True)
class ActionDone(Event):
    """A rule of actions has acted, or (`failed`) something of it did not succeed.

    `sound` and `speak`: what the pages do; `speak` None: nothing is said.
    """

    kind = "action"
    name: str
    """The rule; empty: a failure, which may be of any."""
    text: Text
    """What has happened, in words."""
    sound: bool = False
    speak: Text | None = None
    failed: bool = False


class EventLog:
    """The latest events. Errors have a queue of their own: a bad line has thousands, which must not
    displace markers, gaps and units.
    """

    def __init__(self) -> None:
        self._count = 0
        self._errors: deque[tuple[int, Event]] = deque(maxlen=_MAX_EVENTS)
        self._others: deque[tuple[int, Event]] = deque(maxlen=_MAX_EVENTS)

    def add(self, event: Event) -> None:
        """Keep `event`; a marker at the time of a kept one is that marker, renamed or removed."""
        if isinstance(event, Marker):
            for place, (count, before) in enumerate(self._others):
                if isinstance(before, Marker) and before.time == event.time:
                    self._others[place] = count, event
                    return
        kept = self._errors if isinstance(event, ExchangeFailed) else self._others
        kept.append((self._count, event))
        self._count += 1

    @property
    def all(self) -> list[Event]:
        """All kept events, in their order."""
        return [event for _, event in merge(self._errors, self._others, key=lambda it: it[0])]


def reason_of(event: StateChanged | Gap) -> Text | None:
    """Return the reason with advice, if it is an error's."""
    return ADVICE.text(event.error) if event.error else event.reason


def page_json(event: Event) -> dict[str, Any]:
    """Return `event` for the page: with advice, a state's class of error, and rounded rates."""
    shown = event.as_json()
    if isinstance(event, StateChanged | Gap) and (reason := reason_of(event)):
        shown["reason"] = reason._asdict()
    if isinstance(event, StateChanged):
        shown["code"] = type(event.error).__name__ if event.error else None
    elif isinstance(event, MethodChosen):
        shown["rates"] = {name: round(rate, 2) for name, rate in event.rates.items()}
    elif isinstance(event, Marker) and event.removed:
        shown["removed"] = True
    return shown
