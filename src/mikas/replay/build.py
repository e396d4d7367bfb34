"""The content of a recording, put in order of time to be played back: one pass over its exchanges.

Times count from the first packet. A datum belongs to the moment at which its request was handed to
the adapter, since the ECU measured after that, and before it answered; in a stream, to the moment
at which its response began. So a tester that asks the replayed ECU what the recorded tester asked,
at the same times, gets the same answers.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas import commands as c
from mikas.catalog import Catalog, shipped
from mikas.commands.base import ERROR
from mikas.errors import CaptureError
from mikas.i18n import Text
from mikas.link.base import BITS_PER_BYTE
from mikas.recording.capture.notes import Kind, Note
from mikas.recording.capture.reader import CaptureReader, Problem, Source
from mikas.recording.exchanges import read_exchanges
from mikas.recording.exchanges.result import Exchanges
from mikas.recording.exchanges.scalar import DEFAULT_BAUD
from mikas.replay.behaviour import EcuBehaviour
from mikas.replay.contents import Contents, Port, Request
from mikas.replay.model import ReplayData
from mikas.replay.outages import Outages
from mikas.replay.timeline import AFTER, Timeline

if TYPE_CHECKING:
    from mikas.replay.routine import Routine

# An `01` to these can be nothing but a refusal (D10); as a cell or a fault it would be made up.
_REFUSED_BY_01: Final = frozenset(
    [*c.ReadProgramPassport.CODES, *c.ReadDataPassport.CODES, *c.CountParameters.CODES]
)

_Row = tuple[float, int, int, int, int, int]
_AT_ONCE: Final = 64  # rows that are converted at once


def load(path: str | os.PathLike[str], catalog: Catalog | None = None) -> ReplayData:
    """Return the content of a capture that can be replayed. Raise `CaptureError` if there is none.

    Damaged parts are passed over; `problems` counts them.
    """
    reader = CaptureReader(path)
    notes = list(reader.notes())
    data = build(read_exchanges(path), catalog or shipped(), notes)
    if not data.frames:
        raise CaptureError(str(Path(path)), _NOTHING)
    _add_noted_identity(data, notes)
    return data


def build(
    items: Iterable[Exchanges | Problem], catalog: Catalog, notes: Iterable[Note] = ()
) -> ReplayData:
    """Return the content of `items`. `notes`: of the same file. Never raise for any content."""
    builder = ReplayBuilder(catalog, notes)
    for item in items:
        builder.take(item)
    return builder.finish()


class ReplayBuilder:
    """Follows one capture, stretch by stretch."""

    def __init__(self, catalog: Catalog, notes: Iterable[Note] = ()) -> None:
        self.data = ReplayData()
        self.outages = Outages(notes)
        self.timeline = Timeline(self.data, self.outages)
        self.behaviour = EcuBehaviour()
        self.contents = Contents(self.data, catalog, self.behaviour)
        self._ports: dict[Source, Port] = {}  # of the present recording
        self._echoes = self._requests = 0

    def take(self, item: Exchanges | Problem) -> None:
        """Keep the content of a stretch."""
        if isinstance(item, Problem):
            self.data.problems += 1
            return
        if self.timeline.recording not in (None, item.source.recording):
            self._end_recording()
        self.timeline.enter(item)
        port = self._ports.setdefault(item.source, self.contents.port())
        self._echoes += item.echoes
        self._requests += len(item.requests.numbers)
        self.behaviour.raw_checksum |= item.raw_checksum
        _Stretch(self, port, item).take()

    def finish(self) -> ReplayData:
        """Return the data, complete."""
        self._end_recording()
        data = self.data
        data.duration = 0.0 if self.timeline.recording is None else self.timeline.latest + AFTER
        data.echo = self._echoes > 0 or not self._requests
        for series in self.contents.series:
            for code, begin, size in series.layout.places:
                data.places.setdefault(code, []).append((series, begin, size))
        data.silences, data.holes = self.outages.conclude(self.contents.series)
        data.answered = self.behaviour.answered_codes
        data.quirks, data.refusals = self.behaviour.conclude(data.has_supply, data.places)
        for code in data.unrecorded():
            data.refusals.setdefault(code, ERROR if code in _REFUSED_BY_01 else None)
        return data

    def send(self, port: Port, request: Request | None) -> None:
        """Take a request; None: it is damaged. The one before gets no response any more."""
        before = port.asked
        if before and not before.heard and before.body[0] not in c.GoTo.CODES:
            self.behaviour.failed(before.time, before.body, None)
            self.outages.failed(before.time)
        port.before, port.asked = before, request
        if request:
            self.contents.sent(request.body, port)

    def hear(self, port: Port, request: Request, body: bytes, began: float, ended: float) -> None:
        """Take a response."""
        request.heard = True
        self.data.frames += 1
        answered = self.contents.take(request, port, body, began)
        if answered is None:
            if body == ERROR:  # a datum or a refusal: the ECU is there
                self.outages.ended(request.time)
            return
        if not answered:
            self.behaviour.failed(request.time, request.body, body)
        else:
            by_stroke = request.body[0] in c.StreamAtStroke.CODES  # the engine's timing
            if not request.answered:
                delay = None if by_stroke else began - request.out
                self.behaviour.answered(request.body, delay)
            elif not by_stroke:
                self.behaviour.streamed(began - request.ended)
        self.outages.ended(began if request.answered else request.time)
        request.answered = answered
        request.ended = ended

    def _end_recording(self) -> None:
        self.outages.ended(self.timeline.latest + AFTER)
        for port in self._ports.values():
            port.resolver.conclude()
        self._ports.clear()
        self.contents.end_recording(self.timeline.began)


class _Stretch:
    """The exchanges of one stretch, one after another; routine ones in runs."""

    def __init__(self, builder: ReplayBuilder, port: Port, exchanges: Exchanges) -> None:
        self._builder = builder
        self._port = port
        self._exchanges = exchanges
        self._shift = builder.timeline.shift
        self._byte_time = BITS_PER_BYTE / (exchanges.source.baud or DEFAULT_BAUD)
        self._sent = exchanges.requests.first  # the serial of the next one
        self._damaged = set(exchanges.damaged.tolist())
        if port.asked and port.asked.serial in self._damaged:
            port.asked.heard = True

    def take(self) -> None:
        """Take all requests and responses in order."""
        requests, responses = self._exchanges.requests, self._exchanges.responses
        routine = _routine(self._builder, self._port, self._exchanges)
        row = first = 0
        rows: list[_Row] = []
        while row < len(responses.times):
            if routine is not None and (taken := routine.take(row)):
                row += taken
                self._sent = max(self._sent, int(responses.requests[row]))
            if row >= first + len(rows):
                first, rows = row, self._rows(slice(row, row + _AT_ONCE))
            self._hear(rows[row - first])
            row += 1
        self._send_until(requests.first + len(requests.numbers) - 1)

    def _rows(self, some: slice) -> list[_Row]:
        responses = self._exchanges.responses
        columns = (
            responses.requests,
            responses.after,
            responses.starts,
            responses.lengths,
            responses.wire_lengths,
        )
        rows = zip(
            responses.times[some].tolist(), *(it[some].tolist() for it in columns), strict=True
        )
        return list(rows)

    def _hear(self, row: _Row) -> None:
        """Take a response, and the requests before it."""
        began, serial, after, start, length, wire = row
        self._send_until(after)
        for request in (self._port.asked, self._port.before):
            if request and request.serial == serial:
                began += self._shift
                body = bytes(self._exchanges.responses.bodies[start : start + length])
                self._builder.hear(self._port, request, body, began, began + wire * self._byte_time)
                return

    def _send_until(self, serial: int) -> None:
        """Take the requests up to this one."""
        requests = self._exchanges.requests
        for at in range(self._sent, serial + 1):
            number = requests.numbers[at - requests.first]
            body = self._exchanges.bodies[number] if number >= 0 else b""
            time = float(requests.times[at - requests.first]) + self._shift
            out = time + int(requests.lengths[at - requests.first]) * self._byte_time
            request = Request(at, time, out, body, heard=at in self._damaged) if body else None
            self._builder.send(self._port, request)
        self._sent = max(self._sent, serial + 1)


def _routine(builder: ReplayBuilder, port: Port, exchanges: Exchanges) -> Routine | None:
    """Return the runs of routine exchanges, if they can be found quickly."""
    if isinstance(exchanges.responses.bodies, bytes):
        return None
    from mikas.replay.routine import Routine

    return Routine(builder, port, exchanges)


def _add_noted_identity(data: ReplayData, notes: list[Note]) -> None:
    """Add the noted identity where the wire has none: it may have been asked before."""
    codes = range(0x51, 0x59)
    for note in notes:
        if note.kind != Kind.UNIT:
            continue
        version = note.data.get("version_code")
        if isinstance(version, int) and 0 <= version <= 0xFF and not data.version.values:
            data.version.add(0.0, version)
        pieces = note.data.get("passports")
        if not isinstance(pieces, list):  # a note that was not written here
            data.problems += pieces is not None
            continue
        for code, piece, known in zip(codes, pieces, data.passports, strict=False):
            if isinstance(piece, str) and not known.values:
                known.add(0.0, piece)
                data.refusals.pop(code, None)


_NOTHING: Final = Text(
    "there is no response of an ECU in it, so there is nothing to replay",
    "в записи нет ни одного ответа блока, воспроизводить нечего",
)
