"""A capture in a temporary file."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from tempfile import TemporaryFile
from typing import BinaryIO, cast


def temporary_capture(write: Callable[[BinaryIO], object]) -> BinaryIO:
    """Return a temporary file with the bytes that `write` writes; its close removes it.

    An error of `write` removes it, too.
    """
    with ExitStack() as on_error:
        out = cast("BinaryIO", on_error.enter_context(TemporaryFile()))
        write(out)
        on_error.pop_all()
        return out
