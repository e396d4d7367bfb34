"""Responses of one port in groups of the same layout, as arrays; the rule of `refusals` over them.

A recording is read twice: the first pass finds which doubtful responses do not count, the second
leaves their values out. Responses are numbered through all stretches of a port.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from mikas.commands.base import ERROR
from mikas.recording.exchanges.arrays import Index, Mask, present
from mikas.recording.exchanges.layouts import (
    LIST_IS_SET,
    READ_LIST,
    STREAMS,
    WRITE_LIST,
    Layout,
    Layouts,
)
from mikas.recording.exchanges.refusals import (
    DATUM,
    OTHER,
    REFUSAL,
    LoneResponses,
    is_lone,
    is_twice,
    was_one,
)
from mikas.recording.exchanges.result import Exchanges, Responses

_ONE: Final = ERROR[0]
_NOWHERE: Final = np.empty(0, np.int64)
_Events = list[tuple[Index, Index]]  # rows and their kinds
_DOUBTFUL: Final = 3  # beside the kinds of `refusals`


@dataclass(frozen=True, slots=True)
class ResponseGroup:
    """Rows with the same layout. `request`: the number of the request that they answer.
    `fitting`: the rows with values, all of the right length.
    """

    request: int
    layout: Layout
    rows: Index
    fitting: Index


class ResponseClassifier:
    """The responses of one port by layout. Keeps the list that the last 64 has set."""

    def __init__(self, layouts: Layouts) -> None:
        self._layouts = layouts
        self._settings: list[tuple[int, int]] = []  # serial and body's number of the last 64
        self._set_lists: set[int] = set()  # numbers of the bodies that are a 64
        self._known = 0  # bodies
        self._list: Layout | None = None

    def groups(self, exchanges: Exchanges) -> Iterator[ResponseGroup]:
        """Yield the groups; every response with a layout is in one of them."""
        responses, bodies = exchanges.responses, exchanges.bodies
        lists = self._lists(exchanges)
        for number in present(responses.numbers[responses.numbers >= 0]):
            request = bodies[number]
            if not request or request.startswith(WRITE_LIST):
                continue
            rows = (responses.numbers == number).nonzero()[0]
            if request == READ_LIST:
                edges = [since for since, _ in lists] + [len(responses.numbers)]
                for (_, layout), start, stop in zip(lists, edges, edges[1:], strict=False):
                    listed = rows[slice(*rows.searchsorted([start, stop]))]
                    if layout and listed.size:
                        yield _group(number, layout, listed, responses)
            elif layout := self._layouts.layout_of(request):
                yield _group(number, layout, rows, responses)

    def _lists(self, exchanges: Exchanges) -> list[tuple[int, Layout | None]]:
        """Return the lists with the response from which each holds."""
        requests, responses, bodies = exchanges.requests, exchanges.responses, exchanges.bodies
        lists = [(0, self._list)]
        for new in range(self._known, len(bodies)):
            if bodies[new].startswith(WRITE_LIST):
                self._set_lists.add(new)
        self._known = len(bodies)
        numbers = requests.numbers
        sets_list = self._set_lists.intersection(present(numbers[numbers >= 0]))
        sent = np.isin(numbers, list(sets_list)).nonzero()[0]
        earlier, settings = len(self._settings), self._settings.copy()
        settings += zip((sent + requests.first).tolist(), numbers[sent].tolist(), strict=True)
        for at, (serial, number) in enumerate(settings):
            start = int(responses.after.searchsorted(serial))
            until = settings[at + 1][0] if at + 1 < len(settings) else np.inf
            stop = int(responses.after.searchsorted(until))
            if at >= earlier:
                lists.append((start, None))
            done = (responses.numbers[start:stop] == number) & (responses.lengths[start:stop] == 1)
            done[done] = responses.bodies[responses.starts[start:stop][done]] == LIST_IS_SET
            lists += [
                (start + row, self._layouts.layout_of(bodies[number]))
                for row in done.nonzero()[0].tolist()
            ]
        self._settings = settings[-1:]
        self._list = lists[-1][1]
        return lists


def _group(number: int, layout: Layout, rows: Index, responses: Responses) -> ResponseGroup:
    return ResponseGroup(number, layout, rows, rows[responses.lengths[rows] == layout.length])


class RefusalColumns:
    """Finds one port's doubtful responses that do not count: the first pass of a recording."""

    def __init__(self, bodies: list[bytes]) -> None:
        self._bodies = bodies  # of requests, by number; grows
        self._taken = 0  # responses of earlier stretches
        self._begun: dict[int, int] = {}  # streams that began with 01: serial, number of that
        self._last_serials: dict[int, int] = {}  # of streams, by the request's number
        self._codes: dict[int, tuple[LoneResponses, list[Index]]] = {}  # numbers of the doubtful
        self._latest: dict[Layout, tuple[int, bytes]] = {}

    def add_responses(self, groups: list[ResponseGroup], responses: Responses) -> set[int]:
        """Take the next responses; return the codes that have a certain value in them."""
        certain: list[ResponseGroup] = []
        lone: dict[int, ResponseGroup] = {}
        found: set[int] = set()
        for group in groups:
            request = self._bodies[group.request]
            doubtful = _NOWHERE
            if not is_lone(request, group.layout):
                if is_twice(request):
                    self._follow(request[1])
                certain.append(group)
            elif request[0] in STREAMS:
                doubtful = self._beginnings(group, responses)
                certain.append(replace(group, fitting=np.setdiff1d(group.fitting, doubtful)))
                continued = np.unique(responses.requests[certain[-1].fitting]).tolist()
                serials = responses.requests[doubtful].tolist()
                self._begun.update(zip(serials, (doubtful + self._taken).tolist(), strict=True))
                for serial in continued:
                    self._begun.pop(serial, None)
            else:
                lone[request[1]] = group
                self._follow(request[1])
                doubtful = group.fitting[_is_one(group, responses)]
            if doubtful.size < group.fitting.size:
                found.update(code for code, _, _ in group.layout.places)
        self._remember(certain, responses)
        for code, events in self._events(certain, lone, responses).items():
            self._decide(code, *_in_order(events))
        self._taken += len(responses.starts)
        return found

    def conclude(self) -> tuple[Index, set[int]]:
        """Return the numbers of the responses that do not count, and codes whose last ones do."""
        believed = set()
        refused = [np.array(list(self._begun.values()), np.int64)]
        for code, (lone, numbers) in self._codes.items():
            waits = lone.waiting < lone.count
            twice = any(is_twice(request) and request[1] == code for request in self._bodies)
            if lone.conclude(asked_twice=twice) and waits:
                believed.add(code)
            doubtful = np.concatenate([_NOWHERE, *numbers])
            refused += [doubtful[start:stop] for start, stop in lone.refused]
        return np.sort(np.concatenate(refused)), believed

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
            self._codes[code] = LoneResponses(is_sure=was_one(code, self._latest)), []

    def _remember(self, certain: list[ResponseGroup], responses: Responses) -> None:
        for group in certain:
            if group.fitting.size:
                last = int(group.fitting[-1])
                start = int(responses.starts[last])
                body = responses.bodies[start : start + group.layout.length].tobytes()
                self._latest[group.layout] = self._taken + last, body

    # A 61 with one code

    def _decide(self, code: int, rows: Index, kinds: Index) -> None:
        lone, numbers = self._codes[code]
        numbers.append(rows[kinds == _DOUBTFUL] + self._taken)
        # Where a kind repeats, the first one has decided.
        news = np.ones(kinds.size, np.bool_)
        news[1:] = (kinds[1:] != kinds[:-1]) | (kinds[1:] == _DOUBTFUL)
        for kind in kinds[news].tolist():
            if kind == _DOUBTFUL:
                lone.count += 1
            else:
                lone.decide(kind)

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
                    kinds = np.where((values == _ONE) & (size == 1), DATUM, OTHER)
                    events.setdefault(code, []).append((group.fitting, kinds))
            request = self._bodies[group.request]
            if is_twice(request):
                short = group.rows[responses.lengths[group.rows] == 1]
                refused = short[responses.bodies[responses.starts[short]] == _ONE]
                kinds = np.full(refused.size, REFUSAL)
                events.setdefault(request[1], []).append((refused, kinds))
        for code, group in lone.items():
            kinds = np.where(_is_one(group, responses), _DOUBTFUL, OTHER)
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
