"""The contents of responses by subject: data, identity, faults, memory, writes.

A request is parsed once. A list holds from the `00` that answered its 64 until the next 64 is sent.
An `01` that may be a refusal (D10) is kept once `exchanges.refusals` has decided that it counts;
while a code is refused, the replayed ECU refuses it too.
"""

from __future__ import annotations

from array import array
from collections import Counter
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.commands.base import ERROR
from mikas.errors import MikasError, NotSupported, WriteRefused
from mikas.recording.exchanges.layouts import DATA, READ_LIST, WRITE_LIST, Layouts
from mikas.recording.exchanges.refusals import RefusalResolver
from mikas.replay.behaviour import EcuBehaviour
from mikas.replay.model import Cells, ChangingValue, ReplayData, Series

ROUNDING: Final = (
    0.0005  # s; far above the rounding of times, far below the time between two responses
)
_READ: Final = c.ReadParameters.CODES[0]


@dataclass(slots=True)
class Request:
    """A sent request. `time`: when the adapter got it; `out`: when its last bit was on the wire.

    `responded`: a received frame or damage that is no echo followed. `ended`: end of the latest
    response.
    """

    serial: int
    time: float
    out: float
    body: bytes
    responded: bool = False
    answered: bool = False
    ended: float = 0.0


class Doubtful(NamedTuple):
    """A response `01` that may be a refusal. `time`: to which its datum belongs."""

    series: Series
    time: float
    began: float
    request: Request


@dataclass(slots=True)
class RecordedPort:
    """One port in one recording. `request`, `previous`: the last two requests; None: damaged."""

    resolver: RefusalResolver[Doubtful]
    request: Request | None = None
    previous: Request | None = None
    list: Series | None = None


class Contents:
    """Puts contents into `data`."""

    def __init__(self, data: ReplayData, catalog: Catalog, behaviour: EcuBehaviour) -> None:
        self._data = data
        self._catalog = catalog
        self._behaviour = behaviour
        self._sizes: dict[int, int] = {}  # of codes that the catalog lacks
        self._layouts = Layouts(self._size_of)
        self._series: dict[tuple[tuple[int, int, int], ...], Series] = {}
        self._meanings: dict[bytes, Series | c.Command[Any]] = {}
        self._versions: Counter[int] = Counter()

    @property
    def series(self) -> list[Series]:
        """All series with a response."""
        return [series for series in self._series.values() if series.times]

    def port(self) -> RecordedPort:
        """Return the state of a port at the begin of a recording."""
        return RecordedPort(RefusalResolver(self._decide))

    def series_of(self, request: bytes, port: RecordedPort) -> Series | None:
        """Return the series of a known `request`; None: it has none, or is not known yet."""
        meant = port.list if request == READ_LIST else self._meanings.get(request)
        return meant if isinstance(meant, Series) else None

    def is_routine(self, series: Series, port: RecordedPort) -> bool:
        """Return whether one more response in `series` without 01s brings only data."""
        refused = (code for code, it in self._data.refused.items() if it.values[-1])
        if any(code in series.layout.last for code in refused):
            return False
        return port.resolver.is_quiet(series.layout)

    def sent(self, body: bytes, port: RecordedPort) -> None:
        """Note that a request was sent."""
        port.resolver.sent(body)
        if body.startswith(WRITE_LIST):
            port.list = None

    def end_recording(self, began: float) -> None:
        """Keep the version of the recording that began then."""
        for version, _ in self._versions.most_common(1):  # a late datum may look like one (D13)
            self._data.version.add(began, version)
        self._versions.clear()

    def add_response(
        self, request: Request, port: RecordedPort, body: bytes, began: float
    ) -> bool | None:
        """Keep the content of `body` and return whether it is a valid response.

        False: a refusal, or too short. None: doubtful, or no response to this request.
        """
        meant = self._meaning(request.body, port, body)
        if meant is None:
            return self._take_unknown(request, body)
        if isinstance(meant, Series):
            return self._take_data(request, port, meant, body, began)
        try:
            value = meant.read(body)
        except WriteRefused:
            return not isinstance(meant, c.WriteList)
        except NotSupported:
            return False
        except MikasError:
            return None
        self._keep(request.time, meant, value, body)
        if isinstance(meant, c.WriteList) and port.request is request:
            port.list = self._data_of(request.body)
        return True

    def _take_data(
        self, request: Request, port: RecordedPort, series: Series, body: bytes, began: float
    ) -> bool | None:
        streamed = c.COMMANDS_BY_CODE[request.body[0]].STREAM
        time = began - ROUNDING if streamed else request.time
        doubtful = Doubtful(series, time, began, request)
        if port.resolver.is_certain_value(
            doubtful, request.body, request.serial, series.layout, body
        ):
            self._accept(doubtful, body)
            return True
        if len(body) == series.size:
            return None
        about = set(request.body[1:])
        if body == ERROR and request.body[0] == _READ and len(about) == 1:
            self._refuse(about.pop(), time)
        return False if body == ERROR or 0 < len(body) < series.size else None

    def _decide(self, doubtful: Doubtful, counts: bool) -> None:
        """Keep or drop an `01`."""
        if counts:
            self._accept(doubtful, ERROR)
            return
        request = doubtful.request
        self._behaviour.failed(request.time, request.body, ERROR)
        if request.body[0] == _READ:
            self._refuse(request.body[1], doubtful.time)

    def _accept(self, response: Doubtful, body: bytes) -> None:
        """Keep data; their codes are not refused now."""
        series, time, began, request = response
        for code, refused in self._data.refused.items():
            if code in series.layout.last:
                refused.add(time, value=False)
        series.add(time, body)
        if request.body[0] in c.StreamAtStroke.CODES:
            stroke = c.StreamAtStroke.CODES.index(request.body[0])
            self._data.strokes.setdefault(stroke, array("d")).append(began)

    def _refuse(self, code: int, time: float) -> None:
        refused = self._data.refused.setdefault(code, ChangingValue())
        if not refused.values:
            refused.add(0.0, value=False)
        refused.add(time, value=True)

    def _meaning(
        self, request: bytes, port: RecordedPort, body: bytes
    ) -> Series | c.Command[Any] | None:
        if request in self._meanings:
            return self._meanings[request]
        if request == READ_LIST:
            return port.list
        alone = request[:1] == bytes([_READ]) and len(request) == 2
        if alone and body != ERROR and self._size_of(request[1]) is None:
            self._sizes[request[1]] = len(body)
            self._layouts = Layouts(self._size_of)
        try:
            command = c.parse(request, self._size_of)
        except c.MalformedRequest:
            return None
        meant = self._data_of(request) if isinstance(command, DATA) else command
        if meant is not None:
            self._meanings[request] = meant
        return meant

    def _size_of(self, code: int) -> int | None:
        return self._catalog.size_of(code) or self._sizes.get(code)

    def _data_of(self, request: bytes) -> Series | None:
        layout = self._layouts.layout_of(request)
        return None if layout is None else self._series.setdefault(layout.places, Series(layout))

    def _take_unknown(self, request: Request, body: bytes) -> bool | None:
        if request.body[0] in c.COMMANDS_BY_CODE:
            return False if body == ERROR else None
        self._data.others.setdefault(request.body, ChangingValue()).add(request.time, body)
        return True

    def _keep(
        self,
        time: float,
        command: c.Command[Any],
        value: Any,  # noqa: ANN401  (depends on the command)
        body: bytes,
    ) -> None:
        found = self._data
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
            case c.WriteParameter(parameter):
                found.writable.add(parameter)
            case c.WriteList() | c.GoTo():
                pass
            case _:
                self._keep_cells(time, command, value, body)

    def _keep_cells(
        self,
        time: float,
        command: Any,  # noqa: ANN401  (a command of memory: SPACE and address)
        value: Any,  # noqa: ANN401  (depends on the command)
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
                    self._behaviour.counted_blocks = True
        self._data.cells.append(Cells(time, space, address, data))
