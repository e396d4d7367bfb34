"""Which `01`s are data, and which are the refusal of D10: the rule, over arrays of responses.

An `01` is doubtful as the first response of a stream of one byte, and as the response to a 61 with
one code of one byte. Later responses decide (on a live line, the client decides before it returns a
value):

- a stream's `01` counts if another response of that stream follows: a refusal comes only once;
- a 61's counts if the code's next datum, in whatever response, follows, and does not if the next
  response about the code is an `01` to a request for it twice (`61 P P`). After such an `01`, only
  a datum 01 that can't be a refusal makes the next ones count again;
- at the end of a recording a 61's counts after a datum 01 that can't be a refusal, or if two or
  more follow each other and `61 P P` was requested too: the tester accepted them.

Responses are numbered through all stretches of a port.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from mikas import commands as c
from mikas.commands.base import ERROR
from mikas.recording.exchanges.arrays import Index, Mask
from mikas.recording.exchanges.groups import ResponseGroup
from mikas.recording.exchanges.layouts import STREAMS, Layout
from mikas.recording.exchanges.result import Responses

Decide = Callable[[list[int], bool], None]
"""Takes the numbers of doubtful responses once they are decided, and whether they count."""

_Events = list[tuple[Index, Index]]  # rows and their kinds
# Responses that decide: a value other than 01, a certain datum 01, an `01` to `61 P P`; and one
# that waits.
_OTHER, _DATUM, _REFUSAL, _DOUBTFUL = range(4)
_ONE: Final = ERROR[0]
_READ: Final = c.ReadParameters.CODES[0]
_BELIEVED: Final = 2  # `01`s at the end
_NOWHERE: Final = np.empty(0, np.int64)


@dataclass(slots=True)
class _LoneResponses:
    """The rule for one code. `waiting`: the numbers of its undecided `01`s."""

    decide: Decide
    is_sure: bool = False  # the latest datum is a certain 01
    is_wary: bool = False  # after an `01` to `61 P P`, without a certain 01 since
    waiting: list[int] = field(default_factory=list)

    def take(self, kind: int) -> None:
        """Take a response that decides."""
        self._end(counts=kind == _DATUM or (kind == _OTHER and not self.is_wary))
        if kind != _OTHER:
            self.is_wary = kind == _REFUSAL
        self.is_sure = kind == _DATUM

    def conclude(self, *, asked_twice: bool) -> bool:
        """Decide at the end of the recording; return whether some waited, and count."""
        count = len(self.waiting)
        counts = self.is_sure or (asked_twice and not self.is_wary and count >= _BELIEVED)
        self._end(counts=counts)
        return counts and count > 0

    def _end(self, *, counts: bool) -> None:
        if self.waiting:
            self.decide(self.waiting, counts)
            self.waiting = []


def _is_twice(request: bytes) -> bool:
    """Return whether `request` is `61 P P`."""
    return len(request) == 3 and request[0] == _READ and request[1] == request[2]


class RefusalColumns:
    """Finds one port's doubtful responses, and decides which of them count.

    `doubtful`: which of the latest stretch are; `refused`: the numbers of those that do not count;
    `taken`: how many responses were taken.
    """

    def __init__(self, bodies: list[bytes], decide: Decide = lambda *_: None) -> None:
        self._bodies = bodies  # of requests, by number; grows
        self._decide = decide
        self.taken: int = 0
        self._begun: dict[int, int] = {}  # streams that began with 01: serial, number of that
        self._last_serials: dict[int, int] = {}  # of streams, by the request's number
        self._codes: dict[int, _LoneResponses] = {}
        self._latest: dict[Layout, tuple[int, bytes]] = {}
        self.doubtful: Mask = np.zeros(0, np.bool_)
        self.refused: list[int] = []

    def add_responses(self, groups: list[ResponseGroup], responses: Responses) -> set[int]:
        """Take the next responses; return the codes that have a certain value in them."""
        certain: list[ResponseGroup] = []
        lone: dict[int, ResponseGroup] = {}
        found: set[int] = set()
        self.doubtful = np.zeros(len(responses.starts), np.bool_)
        for group in groups:
            request = self._bodies[group.request]
            doubtful = _NOWHERE
            if len(request) != 2 or group.layout.length != 1:
                if _is_twice(request):
                    self._follow(request[1])
                certain.append(group)
            elif request[0] in STREAMS:
                doubtful = self._beginnings(group, responses)
                certain.append(replace(group, fitting=np.setdiff1d(group.fitting, doubtful)))
                continued = np.unique(responses.requests[certain[-1].fitting]).tolist()
                serials = responses.requests[doubtful].tolist()
                self._begun.update(zip(serials, (doubtful + self.taken).tolist(), strict=True))
                goes_on = [self._begun.pop(serial) for serial in continued if serial in self._begun]
                self._decided(goes_on, True)
            else:
                lone[request[1]] = group
                self._follow(request[1])
                doubtful = group.fitting[_is_one(group, responses)]
            self.doubtful[doubtful] = True
            if doubtful.size < group.fitting.size:
                found.update(code for code, _, _ in group.layout.places)
        self._remember(certain, responses)
        for code, events in self._events(certain, lone, responses).items():
            self._take(self._codes[code], *_in_order(events))
        self.taken += len(responses.starts)
        return found

    def conclude(self) -> set[int]:
        """Decide at the end of the recording; return codes whose last doubtful responses count."""
        self._decided(list(self._begun.values()), False)
        twice = {request[1] for request in self._bodies if _is_twice(request)}
        lone = self._codes.items()
        return {code for code, each in lone if each.conclude(asked_twice=code in twice)}

    def _decided(self, numbers: list[int], counts: bool) -> None:
        if not counts:
            self.refused += numbers
        self._decide(numbers, counts)

    def _beginnings(self, group: ResponseGroup, responses: Responses) -> Index:
        """Return the doubtful responses of a stream of one byte."""
        serials = responses.requests[group.rows]
        before = np.concatenate(([self._last_serials.get(group.request, -1)], serials[:-1]))
        self._last_serials[group.request] = int(serials[-1])
        first = np.isin(group.fitting, group.rows[serials != before])
        doubtful: Index = group.fitting[first & _is_one(group, responses)]
        return doubtful

    # The latest data before a code is followed

    def _follow(self, code: int) -> None:
        if code not in self._codes:
            data = [
                (number, body[place[0] : sum(place)])
                for layout, (number, body) in self._latest.items()
                if (place := layout.last.get(code)) is not None
            ]
            is_sure = bool(data) and max(data)[1] == ERROR
            self._codes[code] = _LoneResponses(self._decided, is_sure)

    def _remember(self, certain: list[ResponseGroup], responses: Responses) -> None:
        for group in certain:
            if group.fitting.size:
                last = int(group.fitting[-1])
                self._latest[group.layout] = self.taken + last, responses.body(last)

    # A 61 with one code

    def _take(self, lone: _LoneResponses, rows: Index, kinds: Index) -> None:
        # Where a kind repeats, the first one has decided.
        news = np.ones(kinds.size, np.bool_)
        news[1:] = (kinds[1:] != kinds[:-1]) | (kinds[1:] == _DOUBTFUL)
        numbers = (rows[news] + self.taken).tolist()
        for number, kind in zip(numbers, kinds[news].tolist(), strict=True):
            if kind == _DOUBTFUL:
                lone.waiting.append(number)
            else:
                lone.take(kind)

    def _events(
        self,
        certain: list[ResponseGroup],
        lone: Mapping[int, ResponseGroup],
        responses: Responses,
    ) -> dict[int, _Events]:
        """Return, by followed code, the rows that concern it, and their kinds."""
        events: dict[int, _Events] = {}
        for group in certain:
            if group.fitting.size:
                for code in self._codes.keys() & group.layout.last.keys():
                    begin, size = group.layout.last[code]
                    values = responses.bodies[responses.starts[group.fitting] + begin]
                    kinds = np.where((values == _ONE) & (size == 1), _DATUM, _OTHER)
                    events.setdefault(code, []).append((group.fitting, kinds))
            request = self._bodies[group.request]
            if _is_twice(request):
                short = group.rows[responses.lengths[group.rows] == 1]
                refused = short[responses.bodies[responses.starts[short]] == _ONE]
                kinds = np.full(refused.size, _REFUSAL)
                events.setdefault(request[1], []).append((refused, kinds))
        for code, group in lone.items():
            kinds = np.where(_is_one(group, responses), _DOUBTFUL, _OTHER)
            events.setdefault(code, []).append((group.fitting, kinds))
        return events


def _in_order(events: _Events) -> tuple[Index, Index]:
    """Return the rows of all events, rising, and their kinds."""
    rows, kinds = (np.concatenate(column) for column in zip(*events, strict=True))
    order = rows.argsort(kind="stable")
    return rows[order], kinds[order]


def _is_one(group: ResponseGroup, responses: Responses) -> Mask:
    one: Mask = responses.bodies[responses.starts[group.fitting]] == _ONE
    return one
