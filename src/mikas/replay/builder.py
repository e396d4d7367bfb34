"""What becomes of the requests and responses of a capture, one after another, and when.

Times of a replay count from the first packet. Recordings in one file (it was appended to) follow
each other with a short silence between, however long it really was, and so do the parts of one
recording with more than a day between; where times run back, they continue from the latest.
"""

from __future__ import annotations

from typing import Final

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.commands.base import ERROR
from mikas.recording.capture.reader import Source
from mikas.recording.exchanges.result import JUMP, LONGEST_PAUSE, Exchanges
from mikas.replay.behaviour import EcuBehaviour
from mikas.replay.contents import Contents, RecordedPort, Request
from mikas.replay.model import ReplayData
from mikas.replay.outages import Outages

_PAUSE: Final = 3.0  # s between two recordings in a file
_AFTER: Final = 0.5  # s from the last packet of a recording to its end
# An `01` to these can only be a refusal (D10); as a cell or a fault it would be invented.
_REFUSED_BY_01: Final = frozenset(
    [*c.ReadProgramPassport.CODES, *c.ReadDataPassport.CODES, *c.CountParameters.CODES]
)


class ReplayBuilder:
    """Follows one capture, stretch by stretch. `shift`: from the current one's times to these."""

    def __init__(self, catalog: Catalog) -> None:
        self.data = ReplayData()
        self.outages = Outages()
        self.shift = 0.0
        self._latest = self._began = 0.0  # the last packet, and the begin of the recording
        self._recording: int | None = None
        self.behaviour = EcuBehaviour()
        self.contents = Contents(self.data, catalog, self.behaviour)
        self._ports: dict[Source, RecordedPort] = {}  # of the current recording
        self._echoes = self._requests = 0

    def enter(self, item: Exchanges) -> RecordedPort:
        """Begin the next stretch; return its port."""
        self._place(item)
        port = self._ports.setdefault(item.source, self.contents.port())
        self._echoes += item.echoes
        self._requests += len(item.requests.numbers)
        self.behaviour.raw_checksum |= item.raw_checksum
        return port

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
        if request:
            self.contents.sent(request.body, port)

    def take_response(
        self, port: RecordedPort, request: Request, body: bytes, began: float, ended: float
    ) -> None:
        """Take a response."""
        request.responded = True
        self.data.frames += 1
        answered = self.contents.add_response(request, port, body, began)
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
        request.ended = ended

    def _end_recording(self) -> None:
        self.outages.supplied(self._latest + _AFTER)
        for port in self._ports.values():
            port.resolver.conclude()
        self._ports.clear()
        self.contents.end_recording(self._began)
