"""What a recording holds, put in order of time for playing it back: one pass over its frames.

Times count from the first packet. A datum belongs to the moment at which its request was handed to
the adapter, since the unit measured after that, and before it answered; in a stream, to the moment
at which its response began. So whoever asks the replayed unit what the tester asked, when the
tester did, gets what the tester got.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.commands.base import ERROR
from mikas.link.base import BITS_PER_BYTE
from mikas.link.tee import Direction
from mikas.recording.inspect.frames import SeenDamage, SeenFrame, decode
from mikas.recording.notes import Note
from mikas.recording.reader import Packet, Problem
from mikas.recording.replay_contents import Asked, Contents
from mikas.recording.replay_habits import Habits
from mikas.recording.replay_recorded import Recorded, Series
from mikas.recording.replay_silences import Silences
from mikas.recording.replay_times import AFTER, Timeline

# An `01` to these can be nothing but a refusal (D10); as a cell or a fault it would be made up.
_ITSELF: Final = frozenset(
    [*c.ReadProgramPassport.CODES, *c.ReadDataPassport.CODES, *c.CountParameters.CODES]
)

_STREAMS: Final = frozenset([*c.StreamCyclic.CODES, *c.StreamAtStroke.CODES])


def index(
    items: Iterable[Packet | Problem], catalog: Catalog, notes: Iterable[Note] = ()
) -> Recorded:
    """What `items` hold. `notes`: of the same file. Never raises for what is in them."""
    return Indexer(catalog, notes).run(items)


class Indexer:
    """Follows one capture, packet by packet; `replay_bulk` spares it what is alike."""

    def __init__(self, catalog: Catalog, notes: Iterable[Note] = ()) -> None:
        self.found = Recorded()
        self.silences = Silences(notes)
        self.times = Timeline(self.found, self.silences)
        self._habits = Habits()
        self.contents = Contents(self.found, catalog, self._habits)
        self._echoes = self._requests = 0
        self._echoes_of_last = 0
        # The present recording
        self._asked: Asked | None = None
        self._before: Asked | None = None

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
        if asked is None or not asked.answered or self.silences.failing_since is not None:
            return 0
        command = c.COMMANDS_BY_CODE.get(asked.body[0])
        if command is None:
            return 0
        if command.STREAM:
            known = self.contents.is_known(asked.body) and self._habits.knows_gaps
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
        elif not request or not self._habits.is_known(request) or request[0] in _STREAMS:
            return None  # a stream's data belong to other moments than those of its request
        return self.contents.series_of(request)

    def passed_over(self, exchanges: int, *, size: int, until: float) -> None:
        """So many regular exchanges of `size` packets, up to a time, were kept without being shown
        here.
        """
        self.times.latest = max(self.times.latest, until)
        self.found.frames += exchanges
        self._requests += exchanges if size > 1 else 0
        self._echoes += exchanges if size == 3 else 0

    def _placed(self, items: Iterable[Packet | Problem]) -> Iterator[Packet | Problem]:
        """The packets with their times in the replay."""
        for item in items:
            if isinstance(item, Problem):
                self.found.problems += 1
                yield item
            elif item.data:
                if self.times.is_of_another(item):
                    self._end_recording()
                yield self.times.place(item)

    # Requests

    def _sent(self, item: SeenFrame) -> None:
        self._requests += 1
        self._echoes_of_last = 0
        arrivals = self.times.arrivals(item.source, item.direction)
        arrivals.began(item.frame.offset)  # lets go of the packets before
        out = item.begin + len(item.frame.wire) * arrivals.byte_time
        self.contents.doubts.asked(item.frame.body)
        self._ask(Asked(item.begin, out, item.frame.body) if item.frame.body else None)

    def _ask(self, asked: Asked | None) -> None:
        before = self._asked
        if before and not before.heard and before.body[0] not in c.GoTo.CODES:
            self._habits.failed(before.time, before.body, None)
            self.silences.failed(before.time)
        elif before and before.doubted and not before.answered:
            self._habits.failed(before.time, before.body, ERROR)
        self._before, self._asked = before, asked

    def _end_recording(self) -> None:
        self.silences.ended(self.times.latest + AFTER)
        self.contents.end_recording(self.times.began, self.times.latest)
        self._asked = self._before = None

    # Responses

    def _heard(self, item: SeenFrame) -> None:
        began = self.times.arrivals(item.source, item.direction).began(item.frame.offset)
        asked = self._asked
        if asked is None or asked.body != item.request:
            asked = self._before
            if asked is None or asked.body != item.request:
                return
        asked.heard = True
        self.found.frames += 1
        self._habits.raw_checksum |= item.frame.raw_checksum
        body = item.frame.body
        answered = self.contents.take(asked, body, began)
        if answered is None:
            if body == ERROR:  # a datum or a refusal: the unit is there
                self.silences.ended(asked.time)
            return
        if not answered:
            self._habits.failed(asked.time, asked.body, body)
        else:
            self._pace(asked, began)
        self.silences.ended(began if asked.answered else asked.time)
        asked.answered = answered
        asked.ended = began + len(item.frame.wire) * BITS_PER_BYTE / (item.source.baud or 9600)

    def _pace(self, asked: Asked, began: float) -> None:
        by_stroke = asked.body[0] in c.StreamAtStroke.CODES  # the engine's pace, not the unit's
        if not asked.answered:
            self._habits.answered(asked.body, None if by_stroke else began - asked.out)
        elif not by_stroke:
            self._habits.streamed(began - asked.ended)

    # In the end

    def _conclude(self) -> None:
        found = self.found
        found.duration = self.times.latest + AFTER if self.times.has_begun else 0.0
        found.echo = self._echoes > 0 or not self._requests
        for series in self.contents.series:
            begin = 0
            for code, size in series.layout:
                found.places.setdefault(code, []).append((series, begin, size))
                begin += size
        found.silences, found.holes = self.silences.conclude(self.contents.series)
        found.answered = self._habits.answered_codes
        found.assumptions, found.refusals = self._habits.conclude(found.has_supply, found.places)
        for code in found.never_told():
            found.refusals.setdefault(code, ERROR if code in _ITSELF else None)
