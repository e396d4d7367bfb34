"""Layouts of responses with data: the parameters of the request, and where each datum stands.

Requests for data are 61, 71 and 7F … 83, which name their codes, and 63, whose codes were in the
last 64. A list holds from the `00` that answered its 64 until the next 64 is sent: after that, the
unit may have either list.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

from mikas import commands as c

READ_LIST: Final = bytes(c.ReadList.CODES)
WRITE_LIST: Final = bytes(c.WriteList.CODES)
LIST_IS_SET: Final = 0
"""The completion code of a 64."""
STREAMS: Final = frozenset([*c.StreamCyclic.CODES, *c.StreamAtStroke.CODES])
DATA: Final = (c.ReadParameters, c.StreamCyclic, c.StreamAtStroke)


@dataclass(frozen=True, eq=False)
class Layout:
    """A body of `length` bytes; `places`: (code, where its datum begins, its size), in order."""

    length: int
    places: tuple[tuple[int, int, int], ...]

    @cached_property
    def last(self) -> Mapping[int, tuple[int, int]]:
        """By code, where its last datum begins, and its size."""
        return {code: (begin, size) for code, begin, size in self.places}


class Layouts:
    """The layouts of all requests. `size_of`: bytes of a code's datum; None: not known yet."""

    def __init__(self, size_of: Callable[[int], int | None]) -> None:
        self._size_of = size_of
        self._known: dict[bytes, Layout] = {}

    def layout_of(self, request: bytes) -> Layout | None:
        """Return the layout of the responses to `request`; of a 64, that of the list it sets.

        None: no data, or a code whose size is not known.
        """
        if (layout := self._known.get(request)) is None and (layout := self._parsed(request)):
            self._known[request] = layout
        return layout

    def _parsed(self, request: bytes) -> Layout | None:
        try:
            command: c.Command[Any] = c.parse(request, self._size_of)
        except c.MalformedRequest:
            return None
        if not isinstance(command, (*DATA, c.WriteList)):
            return None
        places: list[tuple[int, int, int]] = []
        length = 0
        for datum in command.parameters:
            places.append((datum.code, length, datum.size))
            length += datum.size
        return Layout(length, tuple(places))
