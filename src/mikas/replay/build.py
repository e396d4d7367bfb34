"""The content of a recording in order of time, for replay: one pass over its exchanges.

Times count from the first packet. A datum belongs to the time at which its request was handed to
the adapter, since the ECU measured later and before it answered; in a stream, to the begin of its
response. So the same requests at the same times get the same responses as in the recording.

Recordings in one file (it was appended to) follow each other with a short silence between, however
long it really was, and so do the parts of one recording with more than a day between; where times
run back, they continue from the latest.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from mikas import commands as c
from mikas.catalog import Catalog, shipped
from mikas.commands.base import ERROR
from mikas.commands.unit import version_of
from mikas.errors import CaptureError
from mikas.i18n import Text
from mikas.recording.annotations.cars import PortSpan, SeveralCars, cars_of, several
from mikas.recording.annotations.fields import passport_of
from mikas.recording.capture.notes import Kind, Note
from mikas.recording.capture.reader import Problem, Source
from mikas.recording.exchanges import has_whole_numpy, read_exchanges
from mikas.recording.exchanges.result import JUMP, LONGEST_PAUSE, Exchanges
from mikas.replay.behaviour import EcuBehaviour
from mikas.replay.contents import Contents, RecordedPort, Request, Response
from mikas.replay.model import ReplayData
from mikas.replay.outages import Outages

if TYPE_CHECKING:
    from mikas.replay.routine import Routine

_Row = tuple[float, int, int, int, int, int, int, bool]
_AT_ONCE: Final = 64  # rows that are converted at once
_PAUSE: Final = 3.0  # s between two recordings in a file
_AFTER: Final = 0.5  # s from the last packet of a recording to its end
# An `01` to these can only be a refusal (D10); as a cell or a fault it would be invented.
_REFUSED_BY_01: Final = frozenset(
    [*c.ReadProgramPassport.CODES, *c.ReadDataPassport.CODES, *c.CountParameters.CODES]
)


def load(path: str | os.PathLike[str], catalog: Catalog | None = None) -> ReplayData:
    """Return the content of a capture that can be replayed. Raise `CaptureError` if there is none.

    Damaged parts are skipped; `problems` counts them.
    """
    catalog = catalog or shipped()
    data = build(read_exchanges(path, catalog.size_of), catalog)
    if not data.frames:
        raise CaptureError(str(Path(path)), _NOTHING)
    if len(data.cars) > 1:
        raise SeveralCars(str(Path(path)), several(data.cars))
    return data


def build(items: Iterable[Exchanges | Problem | Note], catalog: Catalog) -> ReplayData:
    """Return the content of `items`. Never raise for any content."""
    builder, notes = ReplayBuilder(catalog), []
    ports: dict[int, str] = {}
    spans: dict[int, tuple[float, float]] = {}
    for item in items:
        if isinstance(item, Problem):
            builder.data.problems += 1
        elif isinstance(item, Note):
            builder.outages.add_note(item)
            notes.append(item)
        else:
            number = item.source.recording
            ports.setdefault(number, item.source.url)
            begin, end = spans.get(number, (item.begin, item.end))
            spans[number] = begin, max(end, item.end)
            _Stretch(builder, builder.enter(item), item).add_exchanges()
    data = builder.finish()
    _add_noted_identity(data, notes)
    runs = {number: PortSpan(port, partial(spans.get, number)) for number, port in ports.items()}
    data.cars = cars_of(notes, runs, catalog)
    return data


class ReplayBuilder:
    """Follows one capture, stretch by stretch. `shift`: from the current one's times to these."""

    def __init__(self, catalog: Catalog) -> None:
        self.data: ReplayData = ReplayData()
        self.outages: Outages = Outages()
        self.shift: float = 0.0
        self._latest = self._began = 0.0  # the last packet, and the begin of the recording
        self._recording: int | None = None
        self.behaviour: EcuBehaviour = EcuBehaviour()
        self.contents: Contents = Contents(self.data, catalog, self.behaviour)
        self._ports: dict[Source, RecordedPort] = {}  # of the current recording
        self._echoes = self._requests = 0

    def enter(self, item: Exchanges) -> RecordedPort:
        """Begin the next stretch; return its port."""
        self._place(item)
        if item.source not in self._ports:
            self._ports[item.source] = RecordedPort(self.contents, item.bodies)
        self._echoes += item.echoes
        self._requests += len(item.requests.numbers)
        self.behaviour.raw_checksum |= item.raw_checksum
        self.contents.learn_sizes(item)
        return self._ports[item.source]

    def _place(self, stretch: Exchanges) -> None:
        """Give a stretch its time; within it, times do not run back."""
        recording = stretch.source.recording
        if self._recording is None:
            self.data.begin, self.shift = stretch.begin, -stretch.begin
            self.data.baud = stretch.source.baud or self.data.baud
        elif recording != self._recording:
            self._end_recording()
            self.outages.without_supply(self._latest + _AFTER, self._latest + _PAUSE)
            self._began = self._latest + _PAUSE
            self.shift = self._began - stretch.begin
        elif stretch.begin + self.shift < self._latest - JUMP:
            self.shift = self._latest - stretch.begin
        elif stretch.begin + self.shift > self._latest + LONGEST_PAUSE:
            self.shift = self._latest + _PAUSE - stretch.begin
        self._recording = recording
        for begin, end in stretch.gaps:
            since = max(begin + self.shift, self._latest)
            self.outages.add_pause(recording, since, end + self.shift, self.shift)
        self._latest = max(self._latest, stretch.end + self.shift)

    def finish(self) -> ReplayData:
        """Return the complete data."""
        self._end_recording()
        data = self.data
        data.duration = 0.0 if self._recording is None else self._latest + _AFTER
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

    def take_request(self, port: RecordedPort, request: Request | None) -> None:
        """Take a request (None: damaged), which ends the wait for responses to the one before."""
        before = port.request
        if before and not before.responded and before.body[0] not in c.GoTo.CODES:
            self.behaviour.failed(before.time, before.body, None)
            self.outages.failed(before.time)
        port.previous, port.request = before, request

    def take_response(self, port: RecordedPort, request: Request, response: Response) -> None:
        """Take a response."""
        request.responded = True
        self.data.frames += 1
        body, began = response.body, response.began
        answered = self.contents.add_response(request, port, response)
        if answered is None:
            if body == ERROR:  # a datum or a refusal: the ECU is there
                self.outages.supplied(request.time)
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
        self.outages.supplied(began if request.answered else request.time)
        request.answered = answered
        request.ended = response.ended

    def _end_recording(self) -> None:
        self.outages.supplied(self._latest + _AFTER)
        for port in self._ports.values():
            port.refusals.conclude()
        self._ports.clear()
        self.contents.end_recording(self._began)


class _Stretch:
    """The exchanges of one stretch, one after another; routine ones in runs."""

    def __init__(self, builder: ReplayBuilder, port: RecordedPort, exchanges: Exchanges) -> None:
        self._builder = builder
        self._port = port
        self._exchanges = exchanges
        self._bodies = exchanges.responses.bodies.tobytes()
        self._shift = builder.shift
        self._byte_time = exchanges.source.byte_time
        self._next_serial = exchanges.requests.first
        self._damaged = set(exchanges.damaged.tolist())
        self._first_number = port.refusals.taken
        self._groups = list(port.classifier.groups(exchanges))
        self._group = np.full(len(exchanges.responses.times), -1)  # of each response
        for number, group in enumerate(self._groups):
            self._group[group.rows] = number
        self._series = [builder.contents.series_of(group.layout) for group in self._groups]
        port.refusals.add_responses(self._groups, exchanges.responses)
        if port.request and port.request.serial in self._damaged:
            port.request.responded = True

    def add_exchanges(self) -> None:
        """Take all requests and responses in order."""
        requests, responses = self._exchanges.requests, self._exchanges.responses
        routine: Routine | None = None
        if has_whole_numpy():
            from mikas.replay.routine import Routine

            outages = self._builder.outages
            routine = Routine(self._port, self._exchanges, self._groups, outages, self._shift)
        row, first, count = 0, 0, len(responses.times)
        rows: list[_Row] = []
        while row < count:
            if routine is not None and (taken := routine.add_routine(row)):
                row += taken
                self._builder.data.frames += taken
                self._next_serial = max(self._next_serial, int(responses.requests[row]))
            if row >= first + len(rows):
                first, rows = row, self._rows(slice(row, row + _AT_ONCE))
            self._take_response(row, rows[row - first])
            row += 1
        self._take_requests(requests.first + len(requests.numbers) - 1)

    def _rows(self, some: slice) -> list[_Row]:
        it = self._exchanges.responses
        columns = (it.times, it.requests, it.after, it.starts, it.lengths, it.wire_lengths)
        kinds = (self._group, self._port.refusals.doubtful)
        return list(zip(*(column[some].tolist() for column in (*columns, *kinds)), strict=True))

    def _take_response(self, number: int, row: _Row) -> None:
        """Take the requests before a response, and the response."""
        began, serial, after, start, length, wire, group, is_doubtful = row
        self._take_requests(after)
        for request in (self._port.request, self._port.previous):
            if request and request.serial == serial:
                began += self._shift
                body = self._bodies[start : start + length]
                ended = began + wire * self._byte_time
                series = self._series[group] if group >= 0 else None
                doubtful = self._first_number + number if is_doubtful else None
                response = Response(body, began, ended, series, doubtful)
                self._builder.take_response(self._port, request, response)
                return

    def _take_requests(self, last: int) -> None:
        """Take the requests up to serial `last`."""
        requests = self._exchanges.requests
        for serial in range(self._next_serial, last + 1):
            row = serial - requests.first
            request = None
            if (number := requests.numbers[row]) >= 0 and (body := self._exchanges.bodies[number]):
                time = float(requests.times[row]) + self._shift
                out = time + int(requests.lengths[row]) * self._byte_time
                request = Request(serial, time, out, body, responded=serial in self._damaged)
            self._builder.take_request(self._port, request)
        self._next_serial = max(self._next_serial, last + 1)


def _add_noted_identity(data: ReplayData, notes: list[Note]) -> None:
    """Add the noted identity where the wire has none: its requests may precede the recording."""
    codes = range(0x51, 0x59)
    for note in notes:
        if note.kind != Kind.UNIT:
            continue
        version = version_of(note.data.get("version_code"))
        if version is not None and not data.version.values:
            data.version.add(0.0, version)
        passport = passport_of(note.data.get("passports"))
        if passport is None:  # a note of another program
            data.problems += note.data.get("passports") is not None
            continue
        pieces = (*passport.program, *passport.data)
        for code, piece, known in zip(codes, pieces, data.passports, strict=False):
            if piece is not None and not known.values:
                known.add(0.0, piece)
                data.refusals.pop(code, None)


_NOTHING: Final = Text(
    "there is no response of an ECU in it, so there is nothing to replay",
    "в записи нет ни одного ответа блока, воспроизводить нечего",
)
