"""Responses of one port in groups of the same layout, as arrays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mikas.recording.exchanges.arrays import Index
from mikas.recording.exchanges.columnar import ExchangeColumns, ResponseColumns
from mikas.recording.exchanges.layouts import (
    LIST_IS_SET,
    READ_LIST,
    WRITE_LIST,
    Layout,
    Layouts,
)


@dataclass(frozen=True, slots=True)
class ResponseGroup:
    """Rows that have the same layout. `fitting`: those of `rows` that have values, all of the right
    length. `request`: the number of the request that they answer.
    """

    request: int
    layout: Layout
    rows: Index
    fitting: Index

    def only(self, fitting: Index) -> ResponseGroup:
        """Return the same rows, of which these have values."""
        return replace(self, fitting=fitting)


class ResponseClassifier:
    """The responses of one port by layout. Remembers the list that a 64 has set."""

    def __init__(self, layouts: Layouts) -> None:
        self._layouts = layouts
        self._setting: int | None = None  # the serial of the last 64
        self._setting_request = b""
        self._list: Layout | None = None

    def groups(self, exchanges: ExchangeColumns) -> Iterator[ResponseGroup]:
        """Yield the groups; every response that has a layout is in one of them."""
        responses, bodies = exchanges.responses, exchanges.bodies
        lists = self._lists(exchanges)
        for number in np.unique(responses.numbers).tolist():
            if number < 0 or not (request := bodies[number]):
                continue
            rows = (responses.numbers == number).nonzero()[0]
            if request.startswith(WRITE_LIST):
                continue
            if request == READ_LIST:
                edges = [since for since, _ in lists] + [len(responses.numbers)]
                for (_, layout), start, stop in zip(lists, edges, edges[1:], strict=False):
                    listed = rows[(rows >= start) & (rows < stop)]
                    if layout and listed.size:
                        yield _group(number, layout, listed, responses)
            elif layout := self._layouts.of(request):
                yield _group(number, layout, rows, responses)

    def _lists(self, exchanges: ExchangeColumns) -> list[tuple[int, Layout | None]]:
        """Return from which response on which list holds."""
        requests, responses, bodies = exchanges.requests, exchanges.responses, exchanges.bodies
        lists = [(0, self._list)]
        sets_list = [n for n, body in enumerate(bodies) if body.startswith(WRITE_LIST)]
        sent = np.isin(requests.numbers, sets_list).nonzero()[0]
        known = [] if self._setting is None else [(self._setting, self._setting_request)]
        news = zip((sent + requests.first).tolist(), requests.numbers[sent].tolist(), strict=True)
        settings = known + [(serial, bodies[number]) for serial, number in news]
        for at, (serial, request) in enumerate(settings):
            start = int(responses.after.searchsorted(serial))
            until = settings[at + 1][0] if at + 1 < len(settings) else np.inf
            stop = int(responses.after.searchsorted(until))
            if serial != self._setting:
                lists.append((start, None))
            number = bodies.index(request)
            done = (responses.numbers[start:stop] == number) & (responses.lengths[start:stop] == 1)
            done[done] = responses.bodies[responses.starts[start:stop][done]] == LIST_IS_SET
            lists += [
                (start + row, self._layouts.of(request)) for row in done.nonzero()[0].tolist()
            ]
        if settings:
            self._setting, self._setting_request = settings[-1]
        self._list = lists[-1][1]
        return lists


def _group(number: int, layout: Layout, rows: Index, responses: ResponseColumns) -> ResponseGroup:
    return ResponseGroup(number, layout, rows, rows[responses.lengths[rows] == layout.length])
