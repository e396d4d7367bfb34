"""What a response with data is made of: the parameters of its request, and where each one stands.

Requests that return data are 61, 71 and 7F … 83, whose codes name the data, and 63, whose codes
came with the last 64. A list holds from the `00` that answered its 64 until the next 64 is sent:
in between it is not known which one the unit has.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Final

from mikas import commands as c

READ_LIST: Final = bytes(c.ReadList.CODES)
WRITE_LIST: Final = bytes(c.WriteList.CODES)
LIST_IS_SET: Final = 0
"""The completion code of a 64."""
STREAMS: Final = frozenset([*c.StreamCyclic.CODES, *c.StreamAtStroke.CODES])
DATA: Final = (c.ReadParameters, c.StreamCyclic, c.StreamAtStroke)


@dataclass(frozen=True, slots=True, eq=False)
class Layout:
    """A body of `length` bytes; `places`: (code, where its datum begins, its size), in order."""

    length: int
    places: tuple[tuple[int, int, int], ...]

    def last_of(self, code: int) -> tuple[int, int] | None:
        """Return where the code's last datum begins, and its size; None if it has none."""
        for each, begin, size in reversed(self.places):
            if each == code:
                return begin, size
        return None


def layout_of(parameters: Iterable[c.Datum]) -> Layout:
    """Return the layout of these data."""
    places: list[tuple[int, int, int]] = []
    length = 0
    for datum in parameters:
        places.append((datum.code, length, datum.size))
        length += datum.size
    return Layout(length, tuple(places))


class Layouts:
    """The layouts of all requests. `size_of`: bytes of a code's datum; None: not known."""

    def __init__(self, size_of: Callable[[int], int | None]) -> None:
        self._size_of = size_of
        self._known: dict[bytes, Layout | None] = {}

    def of(self, request: bytes) -> Layout | None:
        """Return the layout of the responses to `request`; of a 64, that of the list it sets.

        None: no data, or a code whose size is not known.
        """
        if request not in self._known:
            self._known[request] = self._made(request)
        return self._known[request]

    def _made(self, request: bytes) -> Layout | None:
        try:
            command: c.Command[Any] = c.parse(request, self._size_of)
        except c.MalformedRequest:
            return None
        if not isinstance(command, (*DATA, c.WriteList)):
            return None
        return layout_of(command.parameters)
