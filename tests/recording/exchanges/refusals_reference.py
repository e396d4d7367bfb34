"""The rule of `mikas.recording.exchanges.refusals`, response by response: its reference."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from mikas import commands as c
from mikas.commands.base import ERROR
from mikas.recording.exchanges.layouts import STREAMS, Layout

OTHER, DATUM, REFUSAL = 0, 1, 2
"""Responses that decide: a value other than 01, a certain datum 01, an `01` to `61 P P`."""
_READ: Final = c.ReadParameters.CODES[0]
_BELIEVED: Final = 2  # `01`s at the end


@dataclass(slots=True)
class LoneResponses:
    """The rule for one code: its doubtful `01`s, numbered from 0. `count`: how many there were.

    `waiting`: the number of the first undecided one. `refused`: ranges (start, stop) of numbers
    that do not count.
    """

    is_sure: bool = False  # the latest datum is a certain 01
    is_wary: bool = False  # after an `01` to `61 P P`, without a certain 01 since
    count: int = 0
    waiting: int = 0
    refused: list[tuple[int, int]] = field(default_factory=list)

    def decide(self, kind: int) -> bool:
        """Take a response that decides; return whether the waiting ones count."""
        counts = kind == DATUM or (kind == OTHER and not self.is_wary)
        self._end(counts=counts)
        if kind != OTHER:
            self.is_wary = kind == REFUSAL
        self.is_sure = kind == DATUM
        return counts

    def conclude(self, *, asked_twice: bool) -> bool:
        """Decide at the end of the recording; return whether the waiting ones count."""
        believed = asked_twice and not self.is_wary and self.count - self.waiting >= _BELIEVED
        counts = self.is_sure or believed
        self._end(counts=counts)
        return counts

    def _end(self, *, counts: bool) -> None:
        if not counts and self.waiting < self.count:
            self.refused.append((self.waiting, self.count))
        self.waiting = self.count


def is_twice(request: bytes) -> bool:
    """Return whether `request` is `61 P P`."""
    return len(request) == 3 and request[0] == _READ and request[1] == request[2]


def is_lone(request: bytes, layout: Layout) -> bool:
    """Return whether an `01` to `request` is doubtful: one code of one byte."""
    return len(request) == 2 and layout.length == 1


class RefusalResolver:
    """The responses with data of one port in one recording, in order.

    `decide(item, counts)` is called once a doubtful response is decided, with the item that `take`
    got with it.
    """

    def __init__(self, decide: Callable[[Any, bool], None]) -> None:
        self._decide = decide
        self._codes: dict[int, tuple[LoneResponses, list[Any]]] = {}
        self._twice: set[int] = set()
        self._streams: dict[bytes, tuple[int, list[Any]]] = {}  # serial, its first if doubtful
        self._latest: dict[Layout, tuple[int, bytes]] = {}
        self._taken = 0
        self._places: dict[Layout, list[tuple[int, int, int]]] = {}  # of followed codes

    def sent(self, request: bytes) -> None:
        """Note that `request` was sent."""
        if is_twice(request):
            self._twice.add(request[1])

    def is_certain_value(
        self, item: Any, request: bytes, serial: int, layout: Layout, body: bytes
    ) -> bool:
        """Return whether `body` is certainly data; otherwise it is doubtful, or has no data."""
        if is_lone(request, layout) and request[0] in STREAMS:
            known, first = self._streams.get(request, (None, []))
            if serial != known:
                self._streams[request] = serial, []
                for each in first:
                    self._decide(each, False)
                if body == ERROR:
                    self._streams[request][1].append(item)
                    return False
            elif first and len(body) == layout.length:
                self._decide(first.pop(), True)
        elif is_twice(request):
            self._follow(request[1])
            if body == ERROR:
                self._settle(request[1], REFUSAL)
        elif is_lone(request, layout):
            lone, waiting = self._follow(request[1])
            if body == ERROR:
                lone.count += 1
                waiting.append(item)
                return False
        if len(body) != layout.length:
            return False
        self.pass_over(layout, body)
        return True

    def pass_over(self, layout: Layout, body: bytes) -> None:
        """Take certain data."""
        self._taken += 1
        self._latest[layout] = self._taken, body
        for code, begin, size in self._followed(layout):
            self._settle(code, DATUM if body[begin : begin + size] == ERROR else OTHER)

    def conclude(self) -> None:
        """Decide the waiting responses, at the end of the recording."""
        for _, first in self._streams.values():
            for each in first:
                self._decide(each, False)
        for code, (lone, waiting) in self._codes.items():
            counts = lone.conclude(asked_twice=code in self._twice)
            for each in waiting:
                self._decide(each, counts)

    def _followed(self, layout: Layout) -> list[tuple[int, int, int]]:
        if layout not in self._places:
            places = ((code, layout.last.get(code)) for code in self._codes)
            self._places[layout] = [(code, *place) for code, place in places if place]
        return self._places[layout]

    def _follow(self, code: int) -> tuple[LoneResponses, list[Any]]:
        if code not in self._codes:
            self._codes[code] = LoneResponses(is_sure=was_one(code, self._latest)), []
            self._places.clear()
        return self._codes[code]

    def _settle(self, code: int, kind: int) -> None:
        lone, waiting = self._codes[code]
        counts = lone.decide(kind)
        for each in waiting:
            self._decide(each, counts)
        waiting.clear()


def was_one(code: int, latest: Mapping[Layout, tuple[int, bytes]]) -> bool:
    """Return whether the code's latest datum was 01. `latest`: by layout, (order, body)."""
    data = [
        (order, body[place[0] : sum(place)])
        for layout, (order, body) in latest.items()
        if (place := layout.last.get(code)) is not None
    ]
    return bool(data) and max(data)[1] == ERROR
