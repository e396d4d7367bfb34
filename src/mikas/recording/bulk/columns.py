"""Responses to columns: where each datum stands in a body, and what it is worth (§3, §4).

Requests that carry data are 61, 71 and 7F … 83, whose codes say what comes back, and 63, whose
codes came with the last 64. A list counts from the `00` that answered its 64 up to the next 64 that
was sent: in between nobody knows which one the unit has.

A conversion's normal form is three integers (`catalog.conversion`), and every quotient of 64-bit
floats below is the one that `Conversion.decode` comes to: the values are the same, bit for bit. A
response whose length does not fit its request makes a row without a value. Which `01` is one, and
which a refusal (D10), is for `doubt` to say.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from mikas import commands as c
from mikas.catalog import Catalog
from mikas.catalog.conversion import Conversion
from mikas.recording.bulk.arrays import Bytes, Floats, Index, side_by_side
from mikas.recording.bulk.match import Answers
from mikas.recording.table import Channel

_DATA: Final = (c.ReadParameters, c.StreamCyclic, c.StreamAtStroke)
_READ_LIST: Final = bytes(c.ReadList.CODES)
_WRITE_LIST: Final = bytes(c.WriteList.CODES)
_LIST_IS_SET: Final = 0  # the completion code


@dataclass(frozen=True, slots=True)
class Place:
    """Where a parameter's datum stands in a body."""

    name: str
    code: int
    start: int
    conversion: Conversion


@dataclass(frozen=True, slots=True)
class Layout:
    """What a body of `length` bytes is made of."""

    length: int
    places: tuple[Place, ...]

    def last_of(self, code: int) -> int | None:
        """Where the code's last datum begins; None: it has none here."""
        return next((place.start for place in reversed(self.places) if place.code == code), None)


@dataclass(frozen=True, slots=True)
class Part:
    """Rows that have the same layout. `fitting`: those of `rows` that have values, all of the right
    length. `request`: the number of what they answer.
    """

    request: int
    layout: Layout
    rows: Index
    fitting: Index

    def only(self, fitting: Index) -> Part:
        """The same rows, of which these have values."""
        return replace(self, fitting=fitting)


class Definitions:
    """A catalog in one reading, as layouts and channels."""

    def __init__(self, catalog: Catalog, interpretation: str) -> None:
        self._catalog = catalog
        self._conversions = {p.name: p.interpretation(interpretation) for p in catalog.parameters}
        self._layouts: dict[bytes, Layout | None] = {}

    def layout(self, request: bytes) -> Layout | None:
        """That of the responses to `request`; of a 64, that of the list it sets. None: no data, or
        a code whose size is not known.
        """
        if request not in self._layouts:
            self._layouts[request] = self._made(request)
        return self._layouts[request]

    def _made(self, request: bytes) -> Layout | None:
        try:
            command: c.Command[Any] = c.parse(request, self._catalog.size_of)
        except c.MalformedRequest:
            return None
        if not isinstance(command, (*_DATA, c.WriteList)):
            return None
        places: list[Place] = []
        start = 0
        for datum in command.parameters:
            places += [
                Place(parameter.name, datum.code, start, self._conversions[parameter.name])
                for parameter in self._catalog.by_code(datum.code)
            ]
            start += datum.size
        return Layout(start, tuple(places))

    def names(self, codes: Collection[int]) -> set[str]:
        """The parameters that have these codes."""
        return {p.name for code in codes for p in self._catalog.by_code(code)}

    def channels(self, names: Collection[str]) -> tuple[Channel, ...]:
        """The columns of these parameters, in the order of the catalog."""
        return tuple(
            Channel(p.name, self._conversions[p.name].unit, p.text, p.is_flag, p.decimals)
            for p in self._catalog.parameters
            if p.name in names
        )


class Sorter:
    """The answers of one port by layout. Remembers the list that 64 has set."""

    def __init__(self, definitions: Definitions, bodies: list[bytes]) -> None:
        self._definitions = definitions
        self.bodies = bodies  # of requests, by number; grows
        self._sets = 0
        self._list: Layout | None = None

    def parts(self, answers: Answers) -> Iterator[Part]:
        """Every answer that has a layout is in one part."""
        lists = self._lists(answers)
        for number in np.unique(answers.requests).tolist():
            if number < 0 or not (request := self.bodies[number]):
                continue
            rows = (answers.requests == number).nonzero()[0]
            if request.startswith(_WRITE_LIST):
                continue
            if request == _READ_LIST:
                edges = [since for since, _ in lists] + [len(answers.requests)]
                for (_, layout), start, stop in zip(lists, edges, edges[1:], strict=False):
                    listed = rows[(rows >= start) & (rows < stop)]
                    if layout and listed.size:
                        yield _part(number, layout, listed, answers)
            elif layout := self._definitions.layout(request):
                yield _part(number, layout, rows, answers)

    def _lists(self, answers: Answers) -> list[tuple[int, Layout | None]]:
        """From which answer on which list holds."""
        if not answers.sets.size:
            return [(0, self._list)]
        changed = np.concatenate(([self._sets], answers.sets[:-1])) != answers.sets
        sets_list = np.array([body[:1] == _WRITE_LIST for body in self.bodies], np.bool_)
        about = (answers.requests >= 0) & (answers.lengths == 1)
        about &= answers.requests == answers.set_by
        about[about] = sets_list[answers.requests[about]]
        about[about] = answers.bodies[answers.starts[about]] == _LIST_IS_SET
        lists = [(0, self._list)]
        for event in (changed | about).nonzero()[0].tolist():
            if changed[event]:
                lists.append((event, None))
            if about[event]:
                request = self.bodies[int(answers.requests[event])]
                lists.append((event, self._definitions.layout(request)))
        self._sets = int(answers.sets[-1])
        self._list = lists[-1][1]
        return lists


def _part(number: int, layout: Layout, rows: Index, answers: Answers) -> Part:
    return Part(number, layout, rows, rows[answers.lengths[rows] == layout.length])


def converted(part: Part, answers: Answers, names: Collection[str]) -> Iterator[tuple[str, Floats]]:
    """The values of the part's fitting rows, a parameter at a time."""
    table = side_by_side(answers.bodies, answers.starts[part.fitting], part.layout.length)
    for place in part.layout.places:
        if place.name in names:
            size = place.conversion.size
            yield place.name, values(table[:, place.start : place.start + size], place.conversion)


def values(raw: Bytes, conversion: Conversion) -> Floats:
    """`Conversion.decode` of every row of raw bytes; flags are 0 and 1."""
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
