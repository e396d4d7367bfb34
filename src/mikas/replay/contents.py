"""The contents of responses by subject: data, identity, faults, memory, writes.

A command is parsed once. An `01` that may be a refusal (D10) is kept if `exchanges.refusals` has
decided, or decides later, that it counts; while a code is refused, the replayed ECU refuses it too.
"""

from __future__ import annotations

from array import array
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from typing import Any, Final, NamedTuple

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.commands.base import ERROR
from mikas.errors import MikasError, NotSupported, WriteRefused
from mikas.recording.exchanges.arrays import present
from mikas.recording.exchanges.groups import ResponseClassifier
from mikas.recording.exchanges.layouts import READ_LIST, STREAMS, Layout, Layouts
from mikas.recording.exchanges.refusals import RefusalColumns
from mikas.recording.exchanges.result import Exchanges
from mikas.replay.behaviour import EcuBehaviour
from mikas.replay.model import Cells, ChangingValue, ReplayData, Series

ROUNDING: Final = 0.0005  # s; far above that of times, far below the time between two responses
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


class Response(NamedTuple):
    """A response. `series`: of its data; None: it has none. `doubtful`: its number among all of the
    port if it is an `01` that may be a refusal.
    """

    body: bytes
    began: float
    ended: float
    series: Series | None
    doubtful: int | None


class Data(NamedTuple):
    """Data of a response. `time`: to which they belong."""

    series: Series
    time: float
    began: float
    request: Request


class RecordedPort:
    """One port in one recording. `request`, `previous`: the last two requests; None: damaged.

    `waiting`: the doubtful responses so far that are not decided, by number; `decided`: whether
    those count that are still to come.
    """

    def __init__(self, contents: Contents, bodies: list[bytes]) -> None:
        self.contents = contents
        self.classifier: ResponseClassifier = ResponseClassifier(contents.layouts)
        self.refusals: RefusalColumns = RefusalColumns(bodies, self._decide)
        self.request: Request | None = None
        self.previous: Request | None = None
        self.waiting: dict[int, Data] = {}
        self.decided: dict[int, bool] = {}

    def _decide(self, numbers: list[int], counts: bool) -> None:
        for number in numbers:
            if (waiting := self.waiting.pop(number, None)) is None:
                self.decided[number] = counts
            else:
                self.contents.decide(waiting, counts)


class Contents:
    """Puts contents into `data`."""

    def __init__(self, data: ReplayData, catalog: Catalog, behaviour: EcuBehaviour) -> None:
        self._data = data
        self._catalog = catalog
        self.behaviour = behaviour
        self._sizes: dict[int, int] = {}  # of codes that the catalog lacks
        self.layouts: Layouts = Layouts(self._size_of)
        self._series: dict[tuple[tuple[int, int, int], ...], Series] = {}
        self._commands: dict[bytes, c.Command[Any]] = {}
        self._versions: Counter[int] = Counter()

    @property
    def series(self) -> list[Series]:
        """All series with a response."""
        return [series for series in self._series.values() if series.times]

    def series_of(self, layout: Layout) -> Series:
        """Return the series of a layout."""
        return self._series.setdefault(layout.places, Series(layout))

    def is_refused(self, layout: Layout) -> bool:
        """Return whether a code of a layout is refused now."""
        refused = (code for code, it in self._data.refused.items() if it.values[-1])
        return any(code in layout.last for code in refused)

    def learn_sizes(self, exchanges: Exchanges) -> None:
        """Learn the sizes of codes that the catalog lacks, from responses to a 61 with one code."""
        responses, bodies = exchanges.responses, exchanges.bodies
        for number in present(responses.numbers[responses.numbers >= 0]):
            request = bodies[number]
            if len(request) == 2 and request[0] == _READ and self._size_of(request[1]) is None:
                rows = (responses.numbers == number).nonzero()[0].tolist()
                data = (body for row in rows if (body := responses.body(row)) != ERROR)
                self._sizes.update((request[1], len(body)) for body in islice(data, 1))

    def end_recording(self, began: float) -> None:
        """Keep the version of the recording that began then."""
        for version, _ in self._versions.most_common(1):  # a late datum may look like one (D13)
            self._data.version.add(began, version)
        self._versions.clear()

    def add_response(self, request: Request, port: RecordedPort, response: Response) -> bool | None:
        """Keep the content of a response and return whether it is a valid one.

        False: a refusal, or too short. None: doubtful, or no response to this request.
        """
        if response.series is not None:
            return self._take_data(request, port, response, response.series)
        if (command := self._command(request.body)) is None:
            return self._take_unknown(request, response.body)
        try:
            value = command.read(response.body)
        except WriteRefused:
            return not isinstance(command, c.WriteList)
        except NotSupported:
            return False
        except MikasError:
            return None
        self._keep(request.time, command, value, response.body)
        return True

    def _take_data(
        self, request: Request, port: RecordedPort, response: Response, series: Series
    ) -> bool | None:
        body, number = response.body, response.doubtful
        streamed = request.body[0] in STREAMS
        time = response.began - ROUNDING if streamed else request.time
        data = Data(series, time, response.began, request)
        if number is not None:
            if number in port.decided:
                self.decide(data, port.decided.pop(number))
            else:
                port.waiting[number] = data
            return None
        if len(body) == series.size:
            self._accept(data, body)
            return True
        about = set(request.body[1:])
        if body == ERROR and request.body[0] == _READ and len(about) == 1:
            self._refuse(about.pop(), time)
        return False if body == ERROR or 0 < len(body) < series.size else None

    def decide(self, doubtful: Data, counts: bool) -> None:
        """Keep or drop an `01`."""
        if counts:
            self._accept(doubtful, ERROR)
            return
        request = doubtful.request
        self.behaviour.failed(request.time, request.body, ERROR)
        if request.body[0] == _READ:
            self._refuse(request.body[1], doubtful.time)

    def _accept(self, data: Data, body: bytes) -> None:
        """Keep data; their codes are not refused now."""
        series, time, began, request = data
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

    def _command(self, request: bytes) -> c.Command[Any] | None:
        """Return the command of a request without data; None: there is none."""
        if request not in self._commands and request != READ_LIST:
            with suppress(c.MalformedRequest):
                self._commands[request] = c.parse(request, self._size_of)
        return self._commands.get(request)

    def _size_of(self, code: int) -> int | None:
        return self._catalog.size_of(code) or self._sizes.get(code)

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
                    self.behaviour.counted_blocks = True
        self._data.cells.append(Cells(time, space, address, data))
