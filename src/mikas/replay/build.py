"""The content of a recording in order of time, for replay: one pass over its exchanges.

Times count from the first packet. A datum belongs to the time at which its request was handed to
the adapter, since the ECU measured later and before it answered; in a stream, to the begin of its
response. So the same requests at the same times get the same responses as in the recording.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.catalog import Catalog, shipped
from mikas.commands.unit import version_of
from mikas.errors import CaptureError
from mikas.i18n import Text
from mikas.recording.annotations.fields import passport_of
from mikas.recording.capture.notes import Kind, Note
from mikas.recording.capture.reader import Problem
from mikas.recording.exchanges import has_whole_numpy, read_exchanges
from mikas.recording.exchanges.result import Exchanges
from mikas.replay.builder import ReplayBuilder
from mikas.replay.contents import RecordedPort, Request
from mikas.replay.model import ReplayData

if TYPE_CHECKING:
    from mikas.replay.routine import Routine

_Row = tuple[float, int, int, int, int, int]
_AT_ONCE: Final = 64  # rows that are converted at once


def load(path: str | os.PathLike[str], catalog: Catalog | None = None) -> ReplayData:
    """Return the content of a capture that can be replayed. Raise `CaptureError` if there is none.

    Damaged parts are skipped; `problems` counts them.
    """
    data = build(read_exchanges(path), catalog or shipped())
    if not data.frames:
        raise CaptureError(str(Path(path)), _NOTHING)
    return data


def build(items: Iterable[Exchanges | Problem | Note], catalog: Catalog) -> ReplayData:
    """Return the content of `items`. Never raise for any content."""
    builder, notes = ReplayBuilder(catalog), []
    for item in items:
        if isinstance(item, Problem):
            builder.data.problems += 1
        elif isinstance(item, Note):
            builder.outages.add_note(item)
            notes.append(item)
        else:
            _Stretch(builder, builder.enter(item), item).add_exchanges()
    data = builder.finish()
    _add_noted_identity(data, notes)
    return data


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
        if port.request and port.request.serial in self._damaged:
            port.request.responded = True

    def add_exchanges(self) -> None:
        """Take all requests and responses in order."""
        requests, responses = self._exchanges.requests, self._exchanges.responses
        routine: Routine | None = None
        if has_whole_numpy():
            from mikas.replay.routine import Routine

            routine = Routine(self._builder, self._port, self._exchanges)
        row = first = 0
        rows: list[_Row] = []
        while row < len(responses.times):
            if routine is not None and (taken := routine.add_routine(row)):
                row += taken
                self._next_serial = max(self._next_serial, int(responses.requests[row]))
            if row >= first + len(rows):
                first, rows = row, self._rows(slice(row, row + _AT_ONCE))
            self._take_response(rows[row - first])
            row += 1
        self._take_requests(requests.first + len(requests.numbers) - 1)

    def _rows(self, some: slice) -> list[_Row]:
        it = self._exchanges.responses
        columns = (it.times, it.requests, it.after, it.starts, it.lengths, it.wire_lengths)
        return list(zip(*(column[some].tolist() for column in columns), strict=True))

    def _take_response(self, row: _Row) -> None:
        """Take the requests before a response, and the response."""
        began, serial, after, start, length, wire = row
        self._take_requests(after)
        for request in (self._port.request, self._port.previous):
            if request and request.serial == serial:
                began += self._shift
                body = self._bodies[start : start + length]
                ended = began + wire * self._byte_time
                self._builder.take_response(self._port, request, body, began, ended)
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
