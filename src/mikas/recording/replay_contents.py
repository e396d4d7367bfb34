"""What answers say, kept by what they are about: data, identity, faults, memory, writes.

The meaning of a request is worked out once. A list counts from the `00` that answered its 64.
"""

from __future__ import annotations

from array import array
from collections import Counter
from dataclasses import dataclass
from typing import Any, Final

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.commands.base import ERROR
from mikas.errors import MikasError, NotSupported, WriteRefused
from mikas.recording.replay_doubt import Doubts
from mikas.recording.replay_habits import Habits
from mikas.recording.replay_recorded import Cells, Latest, Recorded, Series

ROUNDING: Final = 0.0005  # s; far over that of times, far under what is between two responses
_DATA: Final = (c.ReadParameters, c.StreamCyclic, c.StreamAtStroke)


@dataclass(slots=True)
class Asked:
    """A request. `time`: handed to the adapter; `out`: its last bit is on the wire."""

    time: float
    out: float
    body: bytes
    heard: bool = False  # anything came that is no echo
    answered: bool = False
    # A stream began with 01: a datum, or D10's refusal? That comes only once.
    doubted: bool = False
    ended: float = 0.0  # its latest response


class Contents:
    """Puts them into `found`. `doubts`: what is not sure yet."""

    def __init__(self, found: Recorded, catalog: Catalog, habits: Habits) -> None:
        self._found = found
        self._catalog = catalog
        self._habits = habits
        self._sizes: dict[int, int] = {}  # of codes that the catalog lacks
        self._series: dict[tuple[c.Datum, ...], Series] = {}
        self.doubts = Doubts(
            found,
            self._series.values(),
            lambda time, request: habits.failed(time, request, ERROR),
        )
        self._meant: dict[bytes, Series | c.Command[Any]] = {}
        self._list: Series | None = None
        self._versions: Counter[int] = Counter()

    @property
    def series(self) -> list[Series]:
        """Those that hold anything."""
        return [series for series in self._series.values() if series.times]

    def is_known(self, request: bytes) -> bool:
        """Whether its meaning was worked out."""
        return request in self._meant

    def series_of(self, request: bytes) -> Series | None:
        """Where the data that answer a known `request` go; None: they are none."""
        meant = self._list if request == b"\x63" else self._meant.get(request)
        return meant if isinstance(meant, Series) else None

    def end_recording(self, began: float, ended: float) -> None:
        """Nothing that follows `ended` has to do with what came before."""
        for version, _ in self._versions.most_common(1):  # a late datum may look like one (D13)
            self._found.version.add(began, version)
        self._versions.clear()
        self._list = None
        self.doubts.conclude(ended)
        self.doubts.since = ended + ROUNDING

    def take(self, asked: Asked, body: bytes, began: float) -> bool | None:
        """Keeps what `body` says. False: the unit says no, or gives too little; None: it is not an
        answer to this.
        """
        meant = self._meaning(asked.body, body)
        if meant is None:
            return self._take_unknown(asked, body)
        if isinstance(meant, Series):
            return self._take_data(asked, meant, body, began)
        try:
            value = meant.read(body)
        except WriteRefused:
            return not isinstance(meant, c.WriteList)
        except NotSupported:
            return False
        except MikasError:
            return None
        self._keep(asked.time, meant, value, body)
        return True

    def _take_data(self, asked: Asked, series: Series, body: bytes, began: float) -> bool | None:
        if len(body) != series.size:
            if body == ERROR:
                self.doubts.refused(asked.body, asked.time)
            return False if body == ERROR or 0 < len(body) < series.size else None
        streamed = c.COMMANDS_BY_CODE[asked.body[0]].STREAM
        if streamed and body == ERROR and not (asked.answered or asked.doubted):
            asked.doubted = True
            return None
        if self.doubts.holds(asked.body, body, asked.time, series):
            return None
        time = began - ROUNDING if streamed else asked.time
        self.doubts.settle(series, body, time)
        series.add(time, body)
        if asked.body[0] in c.StreamAtStroke.CODES:
            stroke = c.StreamAtStroke.CODES.index(asked.body[0])
            self._found.strokes.setdefault(stroke, array("d")).append(began)
        return True

    def _meaning(self, request: bytes, body: bytes) -> Series | c.Command[Any] | None:
        if request in self._meant:
            return self._meant[request]
        if request == b"\x63":
            return self._list
        alone = request[:1] == b"\x61" and len(request) == 2
        if alone and body != ERROR and self._size_of(request[1]) is None:
            self._sizes[request[1]] = len(body)
        try:
            command = c.parse(request, self._size_of)
        except c.MalformedRequest:
            return None
        meant = self._series_of(command.parameters) if isinstance(command, _DATA) else command
        self._meant[request] = meant
        return meant

    def _size_of(self, code: int) -> int | None:
        return self._catalog.size_of(code) or self._sizes.get(code)

    def _series_of(self, layout: tuple[c.Datum, ...]) -> Series:
        return self._series.setdefault(layout, Series(layout))

    def _take_unknown(self, asked: Asked, body: bytes) -> bool | None:
        if asked.body[0] in c.COMMANDS_BY_CODE:
            return False if body == ERROR else None
        self._found.others.setdefault(asked.body, Latest()).add(asked.time, body)
        return True

    def _keep(
        self,
        time: float,
        command: c.Command[Any],
        value: Any,  # noqa: ANN401  (as the command answers)
        body: bytes,
    ) -> None:
        found = self._found
        match command:
            case c.Availability():
                self._versions[value] += 1
            case c.ReadFaults():
                found.faults.add(time, value)
            case c.ReadProgramPassport(part):
                found.passports[part - 1].add(time, value)
            case c.ReadDataPassport(part):
                found.passports[part + 2].add(time, value)
            case c.CountParameters():
                found.count.add(time, value)
            case c.WriteList(parameters):
                self._list = self._series_of(parameters)
            case c.WriteParameter(parameter):
                found.writable.add(parameter)
            case c.GoTo():
                pass
            case _:
                self._keep_cells(time, command, value, body)

    def _keep_cells(
        self,
        time: float,
        command: Any,  # noqa: ANN401  (one of memory: it has a space and an address)
        value: Any,  # noqa: ANN401  (as the command answers)
        body: bytes,
    ) -> None:
        space, address = command.SPACE, command.address
        match value:
            case None:
                data = command.data  # a block write
            case int():
                data = bytes([value])
            case _:
                data = value
                if space != "ram" and len(body) == 3 + len(data):
                    self._habits.counted_blocks = True
        self._found.cells.append(Cells(time, space, address, data))
