"""Which response answers which request, many packets at once, by the rules of `matching` (D1, D13).

The packets of one port fall into turns: something is sent, then something is received. Nothing but
the last request and what is known of the echo passes from one turn to the next, so a run of regular
turns (one sound request each) is matched in one step: the first frame that repeats the request is
its echo, what comes before that echo answers the request before. Irregular turns, the first ones
that settle whether the line echoes, and the last one, which may go on (a stream does so for hours),
go event by event through `Matching` itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from mikas.commands import WriteList
from mikas.recording.bulk.arrays import Bytes, Floats, Index, Mask, equal
from mikas.recording.bulk.packets import Packets
from mikas.recording.bulk.stream import NO_REQUEST, Events, Stream
from mikas.recording.matching import AVAILABILITY, Matching
from mikas.recording.reader import Source

_NEVER: Final = np.iinfo(np.int64).max
_SETS_LIST: Final = WriteList.CODES[0]


@dataclass(frozen=True, slots=True)
class Answers:
    """Sound received frames that are no echo, in order, and what each one answers.

    `times`: when their first bytes began on the wire. `requests`: numbers of request bodies, see
    `Matcher.bodies`; -1: none is known. `set_by`: the number of the last 64 that had been sent
    before, and `sets` how many had been; -1 and 0: none.
    """

    times: Floats
    requests: Index
    set_by: Index
    sets: Index
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
        asked = _Exchange(self, requests, responses).asked(int(turns[-1]))
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
        chosen = (asked != _ECHO).nonzero()[0]
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
            bodies=block.bodies,
            starts=block.body_starts[events],
            lengths=block.body_ends[events] - block.body_starts[events],
        )
        self._set_by, self._sets = int(known[-1]), self._sets + sets.size
        return answers


_ECHO: Final = -2  # or damage: nothing that is shown


class _Exchange:
    """The turns of one stretch of packets."""

    def __init__(self, matcher: Matcher, requests: Events, responses: Events) -> None:
        self._matcher = matcher
        self._matching = matcher.matching
        self._requests = requests
        self._responses = responses
        self._asked: Index = np.full(responses.index.size, _ECHO)
        self._who = matcher.number(AVAILABILITY)
        self._number_requests()

    def _number_requests(self) -> None:
        """The same request again and again is looked up once."""
        sent = self._requests
        block = sent.block
        new = np.ones(sent.index.size, np.bool_)
        same = (sent.lengths[1:] == sent.lengths[:-1]) & sent.sound[1:] & sent.sound[:-1]
        pairs = same.nonzero()[0]
        starts = sent.starts
        new[pairs + 1] = ~equal(
            block.wire, starts[pairs], block.wire, starts[pairs + 1], sent.lengths[pairs]
        )
        firsts = new.nonzero()[0]
        numbers = [self._matcher.number(sent.body(event)) for event in firsts.tolist()]
        if numbers:
            sent.numbers[:] = np.array(numbers)[new.cumsum() - 1]

    def asked(self, last: int) -> Index:
        """For each response the number of what it answers, or `_ECHO`. Turns are 0 to `last`."""
        sent = self._requests
        regular = np.bincount(sent.turns, minlength=last + 1) == 1
        regular[sent.turns[~sent.sound]] = False
        regular[0] = regular[last] = False
        irregular = (~regular).nonzero()[0].tolist()
        turn = 0
        for stop in irregular:
            while turn < stop:
                turn = self._run(turn, stop)
            self._one(stop)
            turn = stop + 1
        return self._asked

    def _one(self, turn: int) -> None:
        """A turn by the rules as they are."""
        matching, sent, received = self._matching, self._requests, self._responses
        if turn:
            matching.turn()
        for event in sent.of_turn(turn):
            matching.sent(sent.wire(event), sent.body(event))
        events = received.of_turn(turn)
        for event in events:
            if matching.settled:
                rest = slice(event, events.stop)
                number = self._matcher.number(matching.request)
                self._asked[rest] = np.where(received.sound[rest], number, _ECHO)
                return
            body = received.body(event)
            if not matching.received(received.wire(event), body) and body is not None:
                self._asked[event] = self._matcher.number(matching.answered)

    def _run(self, first: int, stop: int) -> int:
        """Regular turns from `first` to before `stop`, at once; returns the turn that is next."""
        matching, sent, received = self._matching, self._requests, self._responses
        begin, end = received.turns.searchsorted([first, stop])
        events = slice(begin, end)
        at = received.turns[events] - first  # each event's turn, counted from the first
        # A regular turn has one request, so requests and turns go together.
        turn_of_request = int(sent.turns.searchsorted(first))
        asking = slice(turn_of_request, turn_of_request + stop - first)
        numbers = sent.numbers[asking]
        same = self._repeats(events, asking, at)
        stop = min(stop, first + self._before_news(events, numbers == self._who, at, same))
        if stop == first:
            self._one(first)
            return first + 1
        count = int(at.searchsorted(stop - first))
        at, same, numbers = at[:count], same[:count], numbers[: stop - first]
        events = slice(begin, begin + count)
        place = np.arange(count)
        asked = numbers[at]
        if matching.echoes is not False:
            echo = _first(place[same], at[same], numbers.size)
            if matching.echoes:
                spoilt = ~received.sound[events]
                damage = _first(place[spoilt], at[spoilt], numbers.size)
                too_early = (place < echo[at]) & (place <= damage[at])
                before = np.concatenate(([self._matcher.number(matching.request)], numbers[:-1]))
                asked[too_early] = before[at[too_early]]
            asked[place == echo[at]] = _ECHO
        asked[~received.sound[events]] = _ECHO
        self._asked[events] = asked
        matching.request = self._matcher.bodies[numbers[-1]]
        return stop

    def _repeats(self, events: slice, asking: slice, at: Index) -> Mask:
        """Which responses are byte for byte the request of their turn."""
        sent, received = self._requests, self._responses
        lengths = received.lengths[events]
        same: Mask = received.sound[events] & (lengths == sent.lengths[asking][at])
        maybe = same.nonzero()[0]
        same[maybe] = equal(
            received.block.wire,
            received.starts[events][maybe],
            sent.block.wire,
            sent.starts[asking][at[maybe]],
            lengths[maybe],
        )
        return same

    def _before_news(self, events: slice, who: Mask, at: Index, same: Mask) -> int:
        """The first turn that could change what is known of the echo. `who`: asks who is there."""
        if self._matching.echoes:
            return who.size
        received = self._responses
        index = received.index[events]
        lengths = received.block.body_ends[index] - received.block.body_starts[index]
        telling = received.sound[events] & (lengths == 1) & who[at]
        if self._matching.echoes is False:
            telling &= same
        found = telling.nonzero()[0]
        return int(at[found[0]]) if found.size else who.size


def _first(places: Index, turns: Index, count: int) -> Index:
    """The first of these places in each turn."""
    first = np.full(count, _NEVER)
    first[turns[::-1]] = places[::-1]
    return first
