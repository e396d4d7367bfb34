"""Exchanges as arrays: their types, and how columns made without numpy become such.

Whatever works with arrays of exchanges imports this. The stages that make them from the bytes of a
file (`exchanges.columnar`) need more of numpy than there is in a browser (`exchanges.pieces`).
"""

from __future__ import annotations

from array import array
from dataclasses import fields, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from mikas.recording.exchanges.result import Exchanges, ExchangesOf, Requests, Responses

Bytes = NDArray[np.uint8]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]
Floats = NDArray[np.float64]
ResponseColumns = Responses[Bytes, Floats, Index]
ExchangeColumns = ExchangesOf[Bytes, Floats, Index]
_SMALL: Final = 4096


def as_columns(exchanges: Exchanges) -> ExchangeColumns:
    """Return exchanges whose columns may be `array.array`, all as arrays."""
    requests: Requests[Floats, Index] = _converted(exchanges.requests)
    responses: ResponseColumns = _converted(exchanges.responses)
    damaged = np.asarray(exchanges.damaged)
    found: Any = replace(exchanges, requests=requests, responses=responses, damaged=damaged)
    columns: ExchangeColumns = found
    return columns


def _converted(columns: Any) -> Any:  # noqa: ANN401  (requests or responses, of either kind)
    changed: dict[str, Any] = {}
    for each in fields(columns):
        value = getattr(columns, each.name)
        if isinstance(value, bytes):
            changed[each.name] = np.frombuffer(value, np.uint8)
        elif isinstance(value, array):
            changed[each.name] = np.asarray(value)
    return replace(columns, **changed)


def present(numbers: Index) -> list[int]:
    """Return the numbers, 0 and up, that occur; of small ones quicker than `np.unique`."""
    small = numbers.size and int(numbers.max()) < max(_SMALL, numbers.size)
    found: list[int] = (np.bincount(numbers).nonzero()[0] if small else np.unique(numbers)).tolist()
    return found
