"""Memory of the C library: all that was freed goes back to the system.

Python takes large objects from it, such as a response of 11 MB. glibc alone keeps what was freed:
for each thread apart (an arena), and of all arenas but the first one it never gives back the end.
"""

from __future__ import annotations

import sys
import threading
from contextlib import suppress
from typing import Final

_MOST_ARENAS: Final = -8  # M_ARENA_MAX
_TRIMMING: Final = threading.Lock()


def use_one_arena() -> None:
    """Let all threads take memory from one place; before they are started.

    Python's lock keeps them from waiting for one another there.
    """
    _call("mallopt", _MOST_ARENAS, 1)


def give_back_memory() -> None:
    """Let the C library return to the system what was freed. A moment, without Python's lock."""
    if _TRIMMING.acquire(blocking=False):
        try:
            _call("malloc_trim", 0)
        finally:
            _TRIMMING.release()


def _call(function: str, *values: int) -> None:
    """Call a function of glibc; elsewhere there is none."""
    if sys.platform == "linux":
        import ctypes

        with suppress(OSError, AttributeError):  # another C library
            getattr(ctypes.CDLL(None), function)(*values)
