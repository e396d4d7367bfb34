"""Responses of one port in groups of the same layout, as arrays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mikas.recording.exchanges.arrays import Index, present
from mikas.recording.exchanges.layouts import (
    LIST_IS_SET,
    READ_LIST,
    WRITE_LIST,
    Layout,
    Layouts,
)
from mikas.recording.exchanges.result import Exchanges, Responses


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
        lists: list[tuple[int, Layout | None]] = []
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
        lists += [
            (int(responses.after.searchsorted(serial, "right")), None)
            for serial in exchanges.lists_lost
        ]
        lists.sort(key=lambda each: (each[0], each[1] is not None))
        lists.insert(0, (0, self._list))
        self._settings = settings[-1:]
        self._list = lists[-1][1]
        return lists


def _group(number: int, layout: Layout, rows: Index, responses: Responses) -> ResponseGroup:
    return ResponseGroup(number, layout, rows, rows[responses.lengths[rows] == layout.length])
