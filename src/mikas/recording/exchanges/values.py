"""Responses to columns: groups of the same layout, and the values of their data (§3, §4).

A conversion's normal form is three integers (`catalog.conversion`), and every quotient of 64-bit
floats below is the one that `Conversion.decode` computes: the values are the same, bit for bit. A
response whose length does not fit its request makes a row without a value. Which `01` is a refusal
(D10) is decided by `refusal_columns`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from mikas.catalog import Catalog
from mikas.catalog.conversion import Conversion
from mikas.recording.exchanges.arrays import Bytes, Floats, Index, side_by_side
from mikas.recording.exchanges.columnar import ExchangeColumns, ResponseColumns
from mikas.recording.exchanges.layouts import (
    LIST_IS_SET,
    READ_LIST,
    WRITE_LIST,
    Layout,
    Layouts,
)
from mikas.recording.table import Channel


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


class Definitions:
    """A catalog in one interpretation, as layouts and channels."""

    def __init__(self, catalog: Catalog, interpretation: str) -> None:
        self._catalog = catalog
        self._conversions = {p.name: p.interpretation(interpretation) for p in catalog.parameters}
        self.layouts = Layouts(catalog.size_of)

    def names(self, codes: Collection[int]) -> set[str]:
        """Return the parameters that have these codes."""
        return {p.name for code in codes for p in self._catalog.by_code(code)}

    def conversions(self, code: int) -> list[tuple[str, Conversion]]:
        """Return the parameters that have this code, with their conversions."""
        return [(p.name, self._conversions[p.name]) for p in self._catalog.by_code(code)]

    def channels(self, names: Collection[str]) -> tuple[Channel, ...]:
        """Return the columns of these parameters, in the order of the catalog."""
        return tuple(
            Channel(p.name, self._conversions[p.name].unit, p.text, p.is_flag, p.decimals)
            for p in self._catalog.parameters
            if p.name in names
        )


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


def converted(
    group: ResponseGroup,
    responses: ResponseColumns,
    definitions: Definitions,
    names: Collection[str],
) -> Iterator[tuple[str, Floats]]:
    """Yield the values of the group's fitting rows, a parameter at a time."""
    table = side_by_side(responses.bodies, responses.starts[group.fitting], group.layout.length)
    for code, begin, _ in group.layout.places:
        for name, conversion in definitions.conversions(code):
            if name in names:
                yield name, values(table[:, begin : begin + conversion.size], conversion)


def values(raw: Bytes, conversion: Conversion) -> Floats:
    """Return `Conversion.decode` of every row of raw bytes; flags are 0 and 1."""
    numbers = np.zeros(len(raw), np.int64)
    for at in range(conversion.size):
        numbers |= raw[:, at].astype(np.int64) << (8 * at)
    if conversion.signed:
        half = 1 << (8 * conversion.size - 1)
        numbers -= (numbers & half) << 1
    floats: Floats
    if conversion.is_flag:
        floats = ((numbers & conversion.mask) != 0).astype(np.float64)
    else:
        exact = numbers * conversion.numerator + conversion.constant
        floats = exact / float(conversion.denominator)
    return floats
