"""The types of arrays of exchanges.

Whatever works with such arrays imports this. The stages that make them from the bytes of a
file (`exchanges.columns`) need more of numpy than there is in a browser (`columns.pieces`).
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]
Floats = NDArray[np.float64]
_SMALL: Final = 4096


def present(numbers: Index) -> list[int]:
    """Return the numbers, 0 and up, that occur; of small ones quicker than `np.unique`."""
    small = numbers.size and int(numbers.max()) < max(_SMALL, numbers.size)
    found: list[int] = (np.bincount(numbers).nonzero()[0] if small else np.unique(numbers)).tolist()
    return found
