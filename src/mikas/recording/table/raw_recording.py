"""All of a recording by one pass over its file: notes, damage, readings of the faults, raw rows.

Nothing is converted here. Which `01`s are refusals (D10) later responses decide, and which columns
there are is known at the end, so the bytes of the data are held, a third of the file's: a table in
any interpretation is made of them. A file that holds too many is read again for each table.
"""

from __future__ import annotations

import os
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from mikas.cancellation import check_cancelled
from mikas.commands import ERASE_FAULTS, ReadFaults
from mikas.errors import MikasError, usage_error
from mikas.recording.annotations.cars import PortSpan, RecordedCar, SeveralCars, cars_of, several
from mikas.recording.capture.notes import INSTRUMENT_PORT, Note
from mikas.recording.capture.reader import Problem, Source
from mikas.recording.exchanges import read_exchanges
from mikas.recording.exchanges.arrays import Bytes, Floats, Index, Mask
from mikas.recording.exchanges.groups import ResponseClassifier, ResponseGroup
from mikas.recording.exchanges.layouts import Layout, Layouts
from mikas.recording.exchanges.refusals import RefusalColumns
from mikas.recording.exchanges.result import Exchanges
from mikas.recording.table.instrument_columns import RawInstrument, raw_instruments
from mikas.sampling.events import FaultReading

_MOST_PROBLEMS: Final = 1000
_MOST_HELD: Final = 1 << 28  # bytes; about seventy hours
_EACH: Final = 300  # bytes that a stretch or a group takes besides its rows
_ERASE: Final = ERASE_FAULTS[-1].body()
_READ_FAULTS: Final = ReadFaults().body()


@dataclass(frozen=True, slots=True)
class RawGroup:
    """Rows of a stretch that have data of one `layout`. `at`: which rows; None: all of them.

    `data`: the first byte of every such row, the second of every one …
    """

    layout: Layout
    at: NDArray[np.int32] | None
    data: Bytes

    def column(self, place: int) -> Bytes:
        """Return the byte at this place of the layout, of every row."""
        count = len(self.data) // self.layout.length
        return self.data[place * count : (place + 1) * count]

    def only(self, counts: Mask) -> RawGroup:
        """Return the same without the rows of the stretch that do not count."""
        rows = np.arange(counts.size) if self.at is None else self.at
        kept = counts[rows]
        columns = [self.column(place)[kept] for place in range(self.layout.length)]
        return replace(self, at=rows[kept].astype(np.int32), data=np.concatenate(columns))


@dataclass(frozen=True, slots=True)
class RawRows:
    """Consecutive rows of one port: responses with data, or such as should have had them.

    `numbers`: those of the responses among all of the port; None: they follow each other from
    `first`; `stop`: the number after the stretch.
    """

    source: Source
    times: Floats
    groups: tuple[RawGroup, ...]
    first: int
    stop: int
    numbers: Index | None

    @property
    def held(self) -> int:
        """About as many bytes of memory as it takes."""
        found = _EACH + 8 * len(self.times)
        found += 0 if self.numbers is None else 8 * len(self.numbers)
        for each in self.groups:
            found += _EACH + len(each.data) + (0 if each.at is None else 4 * len(each.at))
        return found

    def without(self, refused: Index) -> RawRows:
        """Return the rows, without the values of these responses."""
        here = refused[slice(*refused.searchsorted([self.first, self.stop]))]
        if not len(here):
            return self
        rows = np.arange(self.first, self.stop) if self.numbers is None else self.numbers
        counts = ~np.isin(rows, here)
        return replace(self, groups=tuple(each.only(counts) for each in self.groups))


class RawRecording:
    """One recording as it is in the file. `size_of`: bytes of a code's datum; None: not known.

    `problems`: the unreadable places, up to a thousand; `problem_count` counts all. `ports`: those
    with responses; `row_counts`: those with rows, in the order of the file. `fault_readings`: those
    on the wire. `spans`: of each session, the time of the first
    packet and the latest.

    `cars`: those of the file. It is all of one car: of several only the `last_car`'s is here.

    Raises `CaptureError` for a file that is no capture, `SeveralCars` for one of several.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        size_of: Callable[[int], int | None],
        *,
        last_car: bool = False,
    ) -> None:
        self.path: Path = Path(path)
        self.notes: list[Note] = []
        self.problems: list[Problem] = []
        self.problem_count: int = 0
        self._has_instruments = False
        self._sources: list[Source] = []  # in the order of their first packets
        self.spans: dict[int, tuple[float, float]] = {}
        self.ports: set[Source] = set()
        self.row_counts: Counter[Source] = Counter()
        self.fault_readings: defaultdict[Source, list[FaultReading]] = defaultdict(list)
        self._codes: defaultdict[Source, set[int]] = defaultdict(set)
        self._size_of = size_of
        self._layouts = Layouts(size_of)
        self._refused: dict[Source, Index] = {}
        self._held: list[RawRows] | None = []
        self._is_closed = False
        self._kept: frozenset[int] | None = None  # sessions of one car; None: all
        self._read()
        runs = {
            port.recording: PortSpan(port.url, partial(self.spans.get, port.recording))
            for port in self._sources
        }
        self.cars: Sequence[RecordedCar] = cars_of(self.notes, runs)
        if len(self.cars) > 1:
            if not last_car:
                raise SeveralCars(str(self.path), several(self.cars))
            self._keep_last_car()

    @cached_property
    def instruments(self) -> list[RawInstrument]:
        """The packets of the instruments beside the unit; read at the first use."""
        found = raw_instruments(self.path) if self._has_instruments else []
        return [it for it in found if self._kept is None or it.source.recording in self._kept]

    @property
    def codes(self) -> set[int]:
        """The codes with a value."""
        return set().union(*self._codes.values())

    @property
    def source(self) -> Source | None:
        """The port of the first packet."""
        return next(iter(self._sources), None)

    @property
    def last_session(self) -> int | None:
        """The number of the last session with rows; None without rows."""
        return max((source.recording for source in self.row_counts), default=None)

    @property
    def held(self) -> int:
        """About as many bytes of memory as its rows take."""
        beside: list[RawInstrument] = self.__dict__.get("instruments", [])
        return sum(each.held for each in (*(self._held or ()), *beside))

    def close(self) -> None:
        """Free the memory of the rows; they can't be had any more."""
        self._held = None
        self._is_closed = True

    def stretches(self, session: int | None = None) -> Iterator[RawRows]:
        """Yield the rows in the order of the file, of one session or of all."""
        if self._is_closed:
            raise usage_error(
                f"the recording {self.path.name} is closed; open it again for its rows",
                f"запись {self.path.name} закрыта; откройте её снова, чтобы прочитать строки",
            )
        known = self._held
        found: Iterable[RawRows] = known if known is not None else self._again()
        for rows in found:
            check_cancelled()
            number = rows.source.recording
            is_kept = self._kept is None or number in self._kept
            if is_kept and session in (None, number):
                yield rows.without(self._refused[rows.source])

    def _read(self) -> None:
        refusals: dict[Source, RefusalColumns] = {}
        erased: set[Source] = set()  # since the last reading
        held = 0
        for exchanges, groups, rows in self._walk(self._note):
            source = exchanges.source
            if source not in self._refused:
                self._sources.append(source)
                self._refused[source] = np.empty(0, np.int64)
            begin, end = self.spans.get(source.recording, (exchanges.begin, exchanges.begin))
            self.spans[source.recording] = begin, max(end, exchanges.end)
            if len(exchanges.responses.times):
                self.ports.add(source)
            port = refusals.setdefault(source, RefusalColumns(exchanges.bodies))
            self._codes[source] |= port.add_responses(groups, exchanges.responses)
            self._take_faults(exchanges, erased)
            if not len(rows.times):
                continue
            self.row_counts[source] += len(rows.times)
            held += rows.held
            if held > _MOST_HELD:
                self._held = None
            elif self._held is not None:
                self._held.append(rows)
        for source, port in refusals.items():
            self._codes[source] |= port.conclude()
            self._refused[source] = np.sort(np.array(port.refused, np.int64))

    def _keep_last_car(self) -> None:
        """Drop all that is of other cars than that of the last session with rows."""
        last = self.last_session
        by_row = [car for car in self.cars if last in car.recordings]
        self._kept = frozenset((by_row or self.cars)[-1].recordings)
        self.notes = [note for note in self.notes if note.recording in self._kept]
        self.spans = {number: it for number, it in self.spans.items() if number in self._kept}
        for ports in (self._codes, self.row_counts, self.fault_readings):
            for port in [port for port in ports if port.recording not in self._kept]:
                del ports[port]
        self.ports = {port for port in self.ports if port.recording in self._kept}
        self._sources = [port for port in self._sources if port.recording in self._kept]

    def _again(self) -> Iterator[RawRows]:
        return (rows for _, _, rows in self._walk(lambda _: None) if len(rows.times))

    def _walk(
        self, note: Callable[[Problem | Note], None]
    ) -> Iterator[tuple[Exchanges, list[ResponseGroup], RawRows]]:
        """Yield the exchanges, with their responses with data and these as rows."""
        ports: dict[Source, ResponseClassifier] = {}
        taken: Counter[Source] = Counter()
        for item in read_exchanges(self.path, self._size_of):
            check_cancelled()
            if isinstance(item, Problem | Note):
                note(item)
                continue
            source = item.source
            if source not in ports:
                ports[source] = ResponseClassifier(self._layouts)
            groups = list(ports[source].groups(item))
            yield item, groups, _rows(item, groups, taken[source])
            taken[source] += len(item.responses.times)

    def _note(self, item: Problem | Note) -> None:
        if isinstance(item, Note):
            if item.kind == INSTRUMENT_PORT:
                self._has_instruments = True
            else:
                self.notes.append(item)
            return
        self.problem_count += 1
        if len(self.problems) < _MOST_PROBLEMS:
            self.problems.append(item)

    def _take_faults(self, exchanges: Exchanges, erased: set[Source]) -> None:
        source = exchanges.source
        for time, request, body in exchanges.answers((_READ_FAULTS, _ERASE)):
            if request == _ERASE:
                erased.add(source)
                continue
            with suppress(MikasError):
                reading = FaultReading(time, ReadFaults().read(body), source in erased)
                self.fault_readings[source].append(reading)
                erased.discard(source)


def _rows(exchanges: Exchanges, groups: list[ResponseGroup], first: int) -> RawRows:
    responses = exchanges.responses
    count = len(responses.times)
    row_of = np.full(count, -1)
    for group in groups:
        row_of[group.rows] = 0
    rows = (row_of == 0).nonzero()[0]
    row_of[rows] = np.arange(rows.size)
    raw = []
    for group in groups:
        if not group.fitting.size or not group.layout.length:
            continue
        starts = responses.starts[group.fitting]
        data = [responses.bodies[starts + place] for place in range(group.layout.length)]
        at = None
        if group.fitting.size < rows.size:
            at = row_of[group.fitting].astype(np.int32)
        raw.append(RawGroup(group.layout, at, np.concatenate(data)))
    numbers = None if rows.size == count else rows + first
    times = responses.times if rows.size == count else responses.times[rows]
    return RawRows(exchanges.source, times, tuple(raw), first, first + count, numbers)
