"""The turns of one stretch of packets, regular ones many at once (D1, D13): see `match`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from mikas.recording.bulk.arrays import Index, Mask, equal
from mikas.recording.bulk.stream import Events
from mikas.recording.matching import AVAILABILITY

if TYPE_CHECKING:
    from mikas.recording.bulk.match import Matcher

ECHO: Final = -2
"""What an echo answers, or damage: nothing that is shown."""

_NEVER: Final = np.iinfo(np.int64).max


class Exchanges:
    """The turns of one stretch of packets."""

    def __init__(self, matcher: Matcher, requests: Events, responses: Events) -> None:
        self._matcher = matcher
        self._matching = matcher.matching
        self._requests = requests
        self._responses = responses
        self._asked: Index = np.full(responses.index.size, ECHO)
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
        """For each response the number of what it answers, or `ECHO`. Turns are 0 to `last`."""
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
                self._asked[rest] = np.where(received.sound[rest], number, ECHO)
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
            asked[place == echo[at]] = ECHO
        asked[~received.sound[events]] = ECHO
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
