"""Which response answers which request, many packets at once, by the rules of `matching` (D1, D13).

The packets of one port fall into turns: something is sent, then something is received. Nothing but
the last request and what is known of the echo passes from one turn to the next, so a run of regular
turns (one sound request each) is matched in one step: the first frame that repeats the request is
its echo, what comes before that echo answers the request before. Irregular turns, the first ones
that settle whether the line echoes, and the last one, which may go on (a stream does so for hours),
go event by event through `Matching` itself.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Final

import numpy as np

from mikas.commands import StreamAtStroke, StreamCyclic, WriteList
from mikas.recording.bulk.arrays import Bytes, Floats, Index
from mikas.recording.bulk.exchanges import ECHO, Exchanges
from mikas.recording.bulk.packets import Packets
from mikas.recording.bulk.stream import NO_REQUEST, Events, Stream
from mikas.recording.matching import Matching
from mikas.recording.reader import Source

_STREAMS: Final = frozenset([*StreamCyclic.CODES, *StreamAtStroke.CODES])
_SETS_LIST: Final = WriteList.CODES[0]


@dataclass(frozen=True, slots=True)
class Answers:
    """Sound received frames that are no echo, in order, and what each one answers.

    `times`: when their first bytes began on the wire. `requests`: numbers of request bodies, see
    `Matcher.bodies`; -1: none is known. `set_by`: the number of the last 64 that had been sent
    before, and `sets` how many had been; -1 and 0: none. `sent`: of a stream with one code, how
    often its request had been sent before; else 0.
    """

    times: Floats
    requests: Index
    set_by: Index
    sets: Index
    sent: Index
    bodies: Bytes
    starts: Index
    lengths: Index


class Matcher:
    """One port of one recording. `bodies`: every request body that was sent, by number."""

    def __init__(self, source: Source) -> None:
        byte_time = 10 / (source.baud or 9600)  # §1
        self.bodies: list[bytes] = []
        self._numbers: dict[bytes, int] = {}
        self._sent = Stream(byte_time)
        self._received = Stream(byte_time)
        self._matching = Matching()
        self._sent_last = False
        self._set_by, self._sets = NO_REQUEST, 0
        self._started: Counter[int] = Counter()  # streams with one code

    def interrupt(self) -> None:
        """A part of the file is missing here."""
        self._matching.interrupt()

    def feed(self, packets: Packets) -> Answers:
        """The answers that these packets complete."""
        after_sent = np.empty(packets.sent.size, np.bool_)
        after_sent[0] = self._sent_last
        after_sent[1:] = packets.sent[:-1]
        self._sent_last = bool(packets.sent[-1])
        turns = (packets.sent & ~after_sent).cumsum()
        sent, at = self._sent.feed(packets, packets.sent, np.zeros_like(after_sent))
        requests = Events(sent, turns[at])
        received, at = self._received.feed(packets, ~packets.sent, after_sent)
        responses = Events(received, turns[at])
        asked = Exchanges(self, requests, responses).asked(int(turns[-1]))
        return self._answers(requests, responses, asked)

    def number(self, body: bytes | None) -> int:
        """The number of a request body."""
        if body is None:
            return NO_REQUEST
        number = self._numbers.setdefault(body, len(self.bodies))
        if number == len(self.bodies):
            self.bodies.append(body)
        return number

    @property
    def matching(self) -> Matching:
        """What passes from turn to turn."""
        return self._matching

    def _answers(self, requests: Events, responses: Events, asked: Index) -> Answers:
        chosen = (asked != ECHO).nonzero()[0]
        block, events = responses.block, responses.index[chosen]
        # A response comes behind all that was sent in its turn.
        setting = np.array([body[:1] == bytes([_SETS_LIST]) for body in self.bodies], np.bool_)
        numbers = requests.numbers
        sets = (numbers >= 0).nonzero()[0]
        sets = sets[setting[numbers[sets]]]
        known = np.concatenate(([self._set_by], numbers[sets]))
        count = requests.turns[sets].searchsorted(responses.turns[chosen], "right")
        answers = Answers(
            times=self._received.began(block, events),
            requests=asked[chosen],
            set_by=known[count],
            sets=self._sets + count,
            sent=self._starts(requests, responses.turns[chosen], asked[chosen]),
            bodies=block.bodies,
            starts=block.body_starts[events],
            lengths=block.body_ends[events] - block.body_starts[events],
        )
        self._set_by, self._sets = int(known[-1]), self._sets + sets.size
        return answers

    def _starts(self, requests: Events, turns: Index, asked: Index) -> Index:
        """Which time the streams with one code had been started."""
        starts = np.zeros(asked.size, np.int64)
        for number, body in enumerate(self.bodies):
            if len(body) == 2 and body[0] in _STREAMS:
                sent = requests.turns[requests.numbers == number]
                mine = (asked == number).nonzero()[0]
                before = self._started[number]
                starts[mine] = before + sent.searchsorted(turns[mine], "right")
                self._started[number] = before + sent.size
        return starts
