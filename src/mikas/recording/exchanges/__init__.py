"""Recorded exchanges: one interpretation of the traffic in a capture.

All that reads exchanges chooses here, once: array by array (`exchanges.columns`), or turn by turn
(`exchanges.turns`) where, as in a browser, numpy has not all that is needed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cache
from typing import BinaryIO

from mikas.commands.base import SizeOf
from mikas.recording.capture.blocks import Order
from mikas.recording.capture.notes import Note
from mikas.recording.capture.reader import Blocks, Problem
from mikas.recording.exchanges.result import Exchanges


def read_exchanges(
    path: str | os.PathLike[str], size_of: SizeOf
) -> Iterator[Exchanges | Problem | Note]:
    """Yield the exchanges of a capture, a stretch of a port at a time, with problems and notes.

    `size_of`: bytes of a parameter's datum by its code (None: not known), for a response has to fit
    its request (D13). Raise as `CaptureReader` does.
    """
    if has_whole_numpy():
        from mikas.recording.exchanges.columns.matcher import column_exchanges

        return column_exchanges(path, size_of)
    from mikas.recording.exchanges.turns import quick_exchanges

    return quick_exchanges(path, size_of)


def count_responses(
    file: BinaryIO, piece: range, order: Order, blocks: Blocks, size_of: SizeOf
) -> tuple[int, int]:
    """Return the number of responses in the first packets of a piece of a file, and their bytes.

    `blocks`: as before the piece, which begins with a block.
    """
    if has_whole_numpy():
        from mikas.recording.exchanges.columns import matcher

        return matcher.responses_in(file, piece, order, blocks, size_of)
    from mikas.recording.exchanges import turns

    return turns.responses_in(file, piece, order, blocks, size_of)


@cache
def has_whole_numpy() -> bool:
    """Return whether numpy is there, and not only what stands in for it in a browser."""
    try:
        import mikas.recording.exchanges.columns.pieces  # noqa: F401  (whether it can be)
    except ModuleNotFoundError as error:
        if error.name == "numpy.lib":
            return False
        raise
    return True
