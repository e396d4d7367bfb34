"""Recorded exchanges: one interpretation of the traffic in a capture."""

from __future__ import annotations

import os
from collections.abc import Iterator

from mikas.recording.capture.reader import Problem
from mikas.recording.exchanges.result import Exchanges


def read_exchanges(path: str | os.PathLike[str]) -> Iterator[Exchanges | Problem]:
    """Yield the exchanges of a capture, a stretch of a port at a time, and problems in between.

    They come as arrays, or from the scalar reference where numpy is missing. Raise as
    `CaptureReader` does.
    """
    try:
        from mikas.recording.exchanges.columnar import column_exchanges
    except ModuleNotFoundError as error:
        if error.name != "numpy":
            raise
        from mikas.recording.exchanges.scalar import scalar_exchanges

        return scalar_exchanges(path)
    return column_exchanges(path)
