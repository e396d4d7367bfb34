"""The turns of a stretch of packets: which request each received frame answers, run by run.

The packets of one port fall into turns: first sent ones, then received ones. A turn is regular if
it is one request for data, its echo if the line has one, one response that fits and comes in time,
and not a byte besides. Nothing but its request passes from a regular turn to the next, so a run of
them is matched in one step; all others go frame by frame through `Matching`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from mikas.commands.base import OK
from mikas.framing import TERMINATOR
from mikas.recording.exchanges.arrays import Index, Mask
from mikas.recording.exchanges.columns.directions import Events
from mikas.recording.exchanges.columns.packets import Packets
from mikas.recording.exchanges.columns.pieces import equal, side_by_side
from mikas.recording.exchanges.layouts import WRITE_LIST
from mikas.recording.exchanges.matching import Matching, Stage
from mikas.recording.exchanges.verdicts import NO_REQUEST, Received

ECHO: Final = -2
"""Marker for echoes; they answer no request."""
DAMAGE: Final = -3
"""Marker for damaged frames that are no echo."""
LISTED: Final = -2
"""In place of a response's length: that of the unit's list (63)."""
_FIXED: Final = frozenset([Stage.NONE, Stage.VOID, Stage.STREAMING])


class Turns:
    """The turns of one stretch. `placed`: its packets, and the turn of each. `lengths`: those of
    the responses to regular requests, by the request's number.
    """

    def __init__(
        self,
        matching: Matching,
        requests: Events,
        responses: Events,
        placed: tuple[Packets, Index],
        lengths: Index,
    ) -> None:
        self._matching = matching
        self._requests = requests
        self._responses = responses
        self._packets, self._turns = placed
        self._first = matching.count  # serial of the first request
        self._answers: Index = np.full(responses.index.size, ECHO)
        self._count = int(self._turns[-1]) + 1
        self._begins = self._turns.searchsorted(np.arange(self._count))  # packets
        known = np.append(lengths, NO_REQUEST)  # behind the last: that of a damaged one
        self._expected: Index = known[requests.numbers]
        self._known: tuple[bool | None, float] = None, 0.0
        self._irregular: Index = np.empty(0, np.int64)
        self._listed: Index = np.empty(0, np.int64)  # turns with 63, and lengths of the responses
        self._listed_lengths: Index = np.empty(0, np.int64)

    def answers(self) -> Index:
        """Return for each received frame the serial of the request that it answers, or a marker."""
        turn, last = 0, self._count - 1
        while turn < self._count:
            # The first turn may have begun before, and the last one may continue.
            stop = self._run(turn, last) if 0 < turn < last else turn
            if stop == turn:
                self._one(turn)
                stop = turn + 1
            turn = stop
        return self._answers

    def _one(self, turn: int) -> None:
        """Match one turn frame by frame."""
        matching, sent, received = self._matching, self._requests, self._responses
        if turn:
            matching.turn()
        events, packets = sent.of_turn(turn), self._packets
        stop = self._begins[turn + 1] if turn + 1 < self._count else self._turns.size
        event = events.start
        came = int(received.came[turn])
        for packet in range(self._begins[turn], stop):
            if not packets.sent[packet]:
                break
            if packets.lengths[packet]:
                matching.begin_sending(float(packets.times[packet]), came)
            while event < events.stop and sent.packets[event] == packet:
                begin = float(sent.begins[event])
                matching.sent(sent.wire(event), sent.body(event), begin, came)
                event += 1
        events, at = received.of_turn(turn), received.of_turn(turn).start
        while at < events.stop:
            fixed = matching.stage in _FIXED and not matching.doubts_list
            if fixed and (rest := self._next_sent(at, events.stop)) > at:
                answered = matching.is_stream and matching.trusted
                serial = matching.request.serial if answered else NO_REQUEST
                if not matching.is_stream and self._are_of_list(at, rest):
                    matching.lose_list()
                self._answers[at:rest] = np.where(received.sound[at:rest], serial, DAMAGE)
                at = rest
                continue
            verdict = matching.received(self._event(at))
            if not verdict.echo:
                is_sound = received.sound[at]
                self._answers[at] = verdict.answers.serial if is_sound else DAMAGE
            at += 1

    def _are_of_list(self, start: int, stop: int) -> bool:
        """Return whether one of these events may be the echo of a 64, or the response to one."""
        it = self._responses
        first = it.block.wire[it.starts[start:stop]]
        found = first == WRITE_LIST[0]
        found |= (first == OK[0]) & (it.body_lengths[start:stop] == len(OK))
        return bool((found & it.sound[start:stop]).any())

    def _event(self, event: int) -> Received:
        it = self._responses
        start, end = int(it.starts[event]), int(it.starts[event] + it.lengths[event])
        behind = it.block.wire[end : int(it.packet_ends[event])]
        return Received(
            it.wire(event),
            it.body(event),
            start + it.block.origin,
            end + it.block.origin,
            float(it.begins[event]),
            float(it.ends[event]),
            float(it.begins[event]) if self._matching.echoes else it.wire_time(event),
            bool((behind != TERMINATOR).any()),
        )

    def _next_sent(self, start: int, stop: int) -> int:
        """Return the first of these events that repeats a sent frame; `stop`: none does."""
        received = self._responses
        for wire in self._matching.unechoed:
            alike = (received.lengths[start:stop] == len(wire)).nonzero()[0] + start
            rows = side_by_side(received.block.wire, received.starts[alike], len(wire))
            same = (rows == np.frombuffer(wire, np.uint8)).all(axis=1).nonzero()[0]
            stop = int(alike[same[0]]) if same.size else stop
        return stop

    def _run(self, first: int, last: int) -> int:
        """Match regular turns from `first` to before `last` at once; return the next turn."""
        matching, sent, received = self._matching, self._requests, self._responses
        if matching.echoes is None or matching.stage is Stage.LATE:
            return first
        if self._known != (matching.echoes, matching.patience):
            self._find_regular(echoes=matching.echoes, patience=matching.patience)
        at = int(self._irregular.searchsorted(first))
        stop = min(last, int(self._irregular[at])) if at < self._irregular.size else last
        if stop <= first:
            return first
        matching.turn()
        stop = self._before_other_list(first, stop)
        if stop <= first:
            return first
        matching.end_exchange(float(self._packets.times[self._begins[first]]))
        asked = int(sent.turns.searchsorted(first))
        events = slice(*received.turns.searchsorted([first, stop]))
        each = 1 + matching.echoes
        answered = self._first + asked + np.arange(stop - first)
        self._answers[events.start + each - 1 : events.stop : each] = (
            answered if matching.trusted else NO_REQUEST
        )
        event = asked + stop - first - 1
        body = sent.body(event)
        assert body is not None
        matching.follow(stop - first, body, sent.wire(event))
        return stop

    def _before_other_list(self, first: int, stop: int) -> int:
        """Return the first turn where a response to 63 does not fit the list; else `stop`."""
        listed = self._matching.listed
        if listed is None:
            return stop
        begin, end = self._listed.searchsorted([first, stop])
        if begin == end:
            return stop
        if self._listed_lengths[begin] != listed:
            return int(self._listed[begin])
        change = int(self._changes.searchsorted(begin, "right"))
        if change < self._changes.size and self._changes[change] < end:
            return int(self._listed[self._changes[change]])
        return stop

    def _find_regular(self, *, echoes: bool, patience: float) -> None:
        """Find the irregular turns, and those with 63."""
        self._known = echoes, patience
        sent, received = self._requests, self._responses
        each = 1 + echoes
        numbers = np.arange(self._count)
        regular = (np.bincount(sent.turns, minlength=self._count) == 1) & (
            np.bincount(received.turns, minlength=self._count) == each
        )
        sends = self._packets.sent & (self._packets.lengths > 0)
        regular &= np.bincount(self._turns[sends], minlength=self._count) == 1
        turns = numbers[regular]
        asked = sent.turns.searchsorted(turns)
        whole = sent.starts[asked] + sent.block.origin == sent.came[turns]
        whole &= sent.lengths[asked] == sent.brought[turns]
        first = received.turns.searchsorted(turns)
        answer = first + each - 1
        fits = ~_are_alike(sent, asked, received, answer)
        if echoes:
            fits &= _are_alike(sent, asked, received, first)
        fits &= whole & (received.starts[first] + received.block.origin == received.came[turns])
        fits &= received.sound[first] & received.sound[answer]
        length = received.lengths[answer] + (received.lengths[first] if echoes else 0)
        fits &= length == received.brought[turns]
        body = received.body_lengths[answer]
        expected = self._expected[asked]
        fits &= (body == expected) | (expected == LISTED)
        due = sent.begins[asked] + sent.lengths[asked] * sent.byte_time
        if echoes:
            due = np.maximum(due, received.ends[first])
        else:
            began = received.stream.wire_times(received.block, received.index[answer])
            fits &= began >= due - sent.byte_time / 2
        fits &= received.begins[answer] - due <= patience
        regular[turns[~fits]] = False
        self._irregular = (~regular).nonzero()[0]
        of_list = fits & (expected == LISTED)
        self._listed, self._listed_lengths = turns[of_list], body[of_list]
        self._changes = (np.diff(self._listed_lengths) != 0).nonzero()[0] + 1


def _are_alike(sent: Events, asked: Index, received: Events, first: Index) -> Mask:
    """Return which of these received frames are byte for byte these requests."""
    alike: Mask = received.sound[first] & (received.lengths[first] == sent.lengths[asked])
    maybe = alike.nonzero()[0]
    alike[maybe] = equal(
        received.block.wire,
        received.starts[first[maybe]],
        sent.block.wire,
        sent.starts[asked[maybe]],
        sent.lengths[asked[maybe]],
    )
    return alike
