"""Numbers as text, fast: what CSV and .msl are made of.

A parameter of one byte has 256 different values, so each different value is spelled once and the
column is put together from that: about 2 µs a row of 24 columns, not the 12 µs of spelling each.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mikas.recording.table.channels import Channel


def spelled(
    channel: Channel, values: NDArray[np.float64], *, missing: str, decimal: str = "."
) -> list[str]:
    """`values` with the channel's decimals, never “-0”; `missing` for NaN and infinity."""
    different, places = np.unique(values, return_inverse=True)
    decimals = max(channel.decimals, 0)
    texts = np.empty(len(different), object)
    texts[:] = [
        f"{value:z.{decimals}f}".replace(".", decimal) if finite else missing
        for value, finite in zip(different.tolist(), np.isfinite(different).tolist(), strict=True)
    ]
    column: list[str] = texts[places].tolist()
    return column


def lines(columns: Sequence[Sequence[str]], separator: str) -> bytes:
    """Rows of `columns`, each ended by a line feed."""
    rows = map(separator.join, zip(*columns, strict=True))
    return ("\n".join(rows) + "\n").encode()


def without(text: str, *unwanted: str) -> str:
    """`text` for a header that nobody has to unquote: what would need it becomes a space."""
    for piece in unwanted:
        text = text.replace(piece, " ")
    return " ".join(text.split())
