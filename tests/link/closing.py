"""A link that another thread closes in the middle of a call, at each line of the port's code."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from types import FrameType

from mikas.errors import LinkLost
from mikas.link import Link
from mikas.testing.links import Rig

_MODULES = ("serial.", "mikas.link.network", "mikas.link.serial")
_LINES = 200  # more than any call has


def close_at_each_line(
    open_rig: Callable[[], AbstractContextManager[Rig]], use: Callable[[Link], object]
) -> int:
    """Close a link at line 0, 1, … of `use`, until that ends before; return the number of lines.

    Asserts that a call that was interrupted so raises `LinkLost`, if it raises.
    """
    for line in range(_LINES):
        with open_rig() as rig:
            closing = _Closing(rig.link, line)
            before = sys.gettrace()
            sys.settrace(closing.trace)
            try:
                use(rig.link)
            except LinkLost:
                assert closing.done
            finally:
                sys.settrace(before)
            if not closing.done:
                return line
    raise AssertionError("the call has no end")


class _Closing:
    """Traces the lines of the port's code; closes `link` when `left` of them have begun."""

    def __init__(self, link: Link, left: int) -> None:
        self._link = link
        self._left = left
        self.done = False

    def trace(self, frame: FrameType, event: str, _: object) -> Callable[..., object] | None:
        if self.done or not frame.f_globals.get("__name__", "").startswith(_MODULES):
            return None
        if event == "line":
            self._left -= 1
            if self._left < 0:
                self.done = True
                self._link.close()
        return self.trace
