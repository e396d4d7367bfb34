"""What a recording holds, put in order of time for playing it back: one pass over its frames.

Times count from the first packet. A datum belongs to the moment at which its request was handed to
the adapter, since the unit measured after that, and before it answered; in a stream, to the moment
at which its response began. So whoever asks the replayed unit what the tester asked, when the
tester did, gets what the tester got.

Several recordings in one file (it was appended to) follow each other with a short silence between,
however long it really was; where times run back, they go on from there.
"""

from __future__ import annotations

from array import array
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.commands.base import ERROR
from mikas.errors import MikasError, NotSupported, WriteRefused
from mikas.link.base import BITS_PER_BYTE
from mikas.link.tee import Direction
from mikas.recording.decode import SeenDamage, SeenFrame, decode
from mikas.recording.reader import Packet, Problem, Source
from mikas.recording.replay_habits import Habits
from mikas.recording.replay_recorded import Cells, Latest, Recorded, Series

SILENT_FOR: Final = 2.0  # s with requests and no answer: then the unit had no supply
PAUSE: Final = 3.0  # s between two recordings in a file
AFTER: Final = 0.5  # s that the end of a recording is longer than its last packet
_JUMP: Final = 1.0  # s back: a clock that was set, not one that trembles
ROUNDING: Final = 0.0005  # s; far over that of times, far under what is between two responses
_JUST_BEFORE: Final = 0.001  # s; the supply is there when a request comes
_MOST_PACKETS: Final = 8192  # longer than a frame can be in single bytes
_DATA: Final = (c.ReadParameters, c.StreamCyclic, c.StreamAtStroke)


@dataclass(slots=True)
class _Asked:
    """A request. `time`: handed to the adapter; `out`: its last bit is on the wire."""

    time: float
    out: float
    body: bytes
    heard: bool = False  # anything came that is no echo
    answered: bool = False
    doubted: bool = (
        False  # a stream began with 01: a datum, or D10's refusal? That comes only once.
    )
    ended: float = 0.0  # its latest response


class _Arrivals:
    """One direction of a port: which packet brought which byte, and when."""

    def __init__(self, byte_time: float) -> None:
        self.byte_time = byte_time
        self._total = 0
        self._packets: deque[tuple[int, float]] = deque(maxlen=_MOST_PACKETS)

    def add(self, length: int, time: float) -> None:
        """A packet of `time`."""
        self._total += length
        self._packets.append((self._total, time))

    def began(self, offset: int) -> float:
        """When this byte began on the wire; those before it are forgotten."""
        packets = self._packets
        while packets[0][0] <= offset:
            packets.popleft()
        end, time = packets[0]
        return time - (end - offset) * self.byte_time


def index(items: Iterable[Packet | Problem], catalog: Catalog) -> Recorded:
    """What `items` hold. Never raises for what is in them."""
    return Indexer(catalog).run(items)


class Indexer:
    """Follows one capture, packet by packet; `replay_bulk` spares it what is alike."""

    def __init__(self, catalog: Catalog) -> None:
        self.found = Recorded()
        self._catalog = catalog
        self._habits = Habits()
        self._sizes: dict[int, int] = {}  # of codes that the catalog lacks
        self._series: dict[tuple[c.Datum, ...], Series] = {}
        self._meant: dict[bytes, Series | c.Command[Any]] = {}
        self._echoes = self._requests = 0
        self._echoes_of_last = 0
        # Time
        self._shift: float | None = None
        self._recording = 0
        self._last = 0.0
        self._arrivals: dict[tuple[Source, Direction], _Arrivals] = {}
        # The present recording
        self._list: Series | None = None
        self._asked: _Asked | None = None
        self._before: _Asked | None = None
        self._versions: Counter[int] = Counter()
        self._began = 0.0
        self._failing_since: float | None = None

    def run(self, items: Iterable[Packet | Problem]) -> Recorded:
        """All of it. What a packet brings is kept before the next one is taken."""
        for item in decode(self._placed(items)):
            match item:
                case SeenFrame(direction=Direction.SENT):
                    self._sent(item)
                case SeenFrame(echo=True):
                    self._echoes += 1
                    self._echoes_of_last += 1
                case SeenFrame():
                    self._heard(item)
                case SeenDamage(direction=Direction.SENT):
                    self._ask(None)
                case SeenDamage(echo=False) if self._asked:
                    self._asked.heard = True
        self._end_recording()
        self._conclude()
        return self.found

    # Many at once

    @property
    def repeats(self) -> int:
        """Of how many packets an exchange is made that would tell, of requests known already,
        nothing but data: 3, 2 without an echo, 1 in a stream. 0: anything could be news.
        """
        asked = self._asked
        if asked is None or not asked.answered or self._failing_since is not None:
            return 0
        command = c.COMMANDS_BY_CODE.get(asked.body[0])
        if command is None:
            return 0
        if command.STREAM:
            known = asked.body in self._meant and self._habits.knows_gaps
            return int(known and asked.body[0] not in c.StreamAtStroke.CODES)
        if not self._habits.is_known(asked.body):
            return 0
        if self._echoes_of_last == 1:
            return 3
        return 0 if self._echoes else 2

    def series_of(self, request: bytes | None) -> Series | None:
        """Where the data that answer `request` go, if one more of them would be nothing new."""
        if request is None:
            request = self._asked.body if self._asked else b""
        elif not request or not self._habits.is_known(request):
            return None
        meant = self._list if request == b"\x63" else self._meant.get(request)
        return meant if isinstance(meant, Series) else None

    def placed(self, time: float) -> float:
        """A packet's time in the replay, if that runs on as before."""
        return time + (self._shift or 0.0)

    @property
    def latest(self) -> float:
        """The time of the last packet, in the replay."""
        return self._last

    def passed_over(self, exchanges: int, *, size: int) -> None:
        """So many regular exchanges of `size` packets were kept without being shown here."""
        self.found.frames += exchanges
        self._requests += exchanges if size > 1 else 0
        self._echoes += exchanges if size == 3 else 0

    # Time

    def _placed(self, items: Iterable[Packet | Problem]) -> Iterator[Packet | Problem]:
        """The packets with their times in the replay."""
        for item in items:
            if isinstance(item, Problem):
                self.found.problems += 1
                yield item
            elif item.data:
                time = self._time(item)
                key = item.source, item.direction
                if key not in self._arrivals:
                    self._arrivals[key] = _Arrivals(BITS_PER_BYTE / (item.source.baud or 9600))
                self._arrivals[key].add(len(item.data), time)
                yield Packet(
                    item.direction, item.data, time, item.offset, item.comment, item.source
                )

    def _time(self, packet: Packet) -> float:
        recording = packet.source.recording
        if self._shift is None:
            self.found.begin, self._shift = packet.time, -packet.time
            self.found.baud = packet.source.baud or self.found.baud
        elif recording != self._recording:
            self._end_recording()
            self._arrivals.clear()
            self.found.silences.append((self._last + AFTER, self._last + PAUSE - _JUST_BEFORE))
            self._began = self._last + PAUSE
            self._shift = self._began - packet.time
        elif packet.time + self._shift < self._last - _JUMP:
            self._shift = self._last - packet.time
        self._recording = recording
        self._last = max(self._last, packet.time + self._shift)
        return self._last

    def _when_began(self, item: SeenFrame) -> float:
        """When the first byte of a frame began on the wire."""
        return self._arrivals[item.source, item.direction].began(item.frame.offset)

    # Requests

    def _sent(self, item: SeenFrame) -> None:
        self._requests += 1
        self._echoes_of_last = 0
        arrivals = self._arrivals[item.source, item.direction]
        arrivals.began(item.frame.offset)  # lets go of the packets before
        out = item.begin + len(item.frame.wire) * arrivals.byte_time
        self._ask(_Asked(item.begin, out, item.frame.body) if item.frame.body else None)

    def _ask(self, asked: _Asked | None) -> None:
        before = self._asked
        if before and not before.heard and before.body[0] not in c.GoTo.CODES:
            self._habits.failed(before.time, before.body, None)
            if self._failing_since is None:
                self._failing_since = before.time
        elif before and before.doubted and not before.answered:
            self._habits.failed(before.time, before.body, ERROR)
        self._before, self._asked = before, asked

    def _end_silence(self, time: float) -> None:
        """The unit answered: it had its supply when it was asked, at `time`."""
        since, self._failing_since = self._failing_since, None
        if since is not None and time - since > SILENT_FOR:
            self.found.silences.append((since - _JUST_BEFORE, time - _JUST_BEFORE))

    def _end_recording(self) -> None:
        self._end_silence(self._last + AFTER)
        for version, _ in self._versions.most_common(1):  # a late datum may look like one (D13)
            self.found.version.add(self._began, version)
        self._versions.clear()
        self._asked = self._before = self._list = None

    # Responses

    def _heard(self, item: SeenFrame) -> None:
        began = self._when_began(item)
        asked = self._asked
        if asked is None or asked.body != item.request:
            asked = self._before
            if asked is None or asked.body != item.request:
                return
        asked.heard = True
        self.found.frames += 1
        self._habits.raw_checksum |= item.frame.raw_checksum
        body = item.frame.body
        answered = self._take(asked, body, began)
        if answered is None:
            return
        if not answered:
            self._habits.failed(asked.time, asked.body, body)
        else:
            self._pace(asked, began)
        self._end_silence(began if asked.answered else asked.time)
        asked.answered = answered
        asked.ended = began + len(item.frame.wire) * BITS_PER_BYTE / (item.source.baud or 9600)

    def _pace(self, asked: _Asked, began: float) -> None:
        by_stroke = asked.body[0] in c.StreamAtStroke.CODES  # the engine's pace, not the unit's
        if not asked.answered:
            self._habits.answered(asked.body, None if by_stroke else began - asked.out)
        elif not by_stroke:
            self._habits.streamed(began - asked.ended)

    def _take(self, asked: _Asked, body: bytes, began: float) -> bool | None:
        """Keeps what `body` says. False: the unit says no, or gives too little; None: it is not an
        answer to this.
        """
        meant = self._meaning(asked.body, body)
        if meant is None:
            return self._take_unknown(asked, body)
        if isinstance(meant, Series):
            if len(body) != meant.size:
                return False if body == ERROR or 0 < len(body) < meant.size else None
            streamed = c.COMMANDS_BY_CODE[asked.body[0]].STREAM
            if streamed and body == ERROR and not (asked.answered or asked.doubted):
                asked.doubted = True
                return None
            meant.add(began - ROUNDING if streamed else asked.time, body)
            if asked.body[0] in c.StreamAtStroke.CODES:
                stroke = c.StreamAtStroke.CODES.index(asked.body[0])
                self.found.strokes.setdefault(stroke, array("d")).append(began)
            return True
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

    def _take_unknown(self, asked: _Asked, body: bytes) -> bool | None:
        if asked.body[0] in c.COMMANDS_BY_CODE:
            return False if body == ERROR else None
        self.found.others.setdefault(asked.body, Latest()).add(asked.time, body)
        return True

    def _keep(self, time: float, command: c.Command[Any], value: Any, body: bytes) -> None:  # noqa: ANN401
        found = self.found
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

    def _keep_cells(self, time: float, command: Any, value: Any, body: bytes) -> None:  # noqa: ANN401
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
        self.found.cells.append(Cells(time, space, address, data))

    # In the end

    def _conclude(self) -> None:
        found = self.found
        found.duration = self._last + AFTER if self._shift is not None else 0.0
        found.echo = self._echoes > 0 or not self._requests
        for series in self._series.values():
            if not series.times:
                continue
            begin = 0
            for code, size in series.layout:
                found.places.setdefault(code, []).append((series, begin, size))
                begin += size
        found.silences.sort()
        found.assumptions, found.refusals = self._habits.conclude(found.has_supply, found.places)
        for code in found.never_told():
            found.refusals.setdefault(code, None)
