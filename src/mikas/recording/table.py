"""Columns over time: what every export is made from, and every notebook gets.

A recording of ten hours does not fit a table at once, so it comes in stretches (`Rows`), each with
the same columns. A value that is missing (a gap, a parameter asked less often) is NaN, never the
last one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Final

from mikas.i18n import Text

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

PLAINLY_UNIX: Final = 1e9  # 2001; a simulated clock would have run for 31 years


@dataclass(frozen=True, slots=True)
class Channel:
    """A column: its mnemonic, its unit, what it is in both languages, how it is shown."""

    name: str
    unit: str
    text: Text
    is_flag: bool = False
    decimals: int = 0


@dataclass(frozen=True, slots=True)
class Rows:
    """A stretch of samples. `times`: seconds on the link's clock (UNIX time on a real one), rising.

    `values`: by channel name, as long as `times`, float64; flags are 0 and 1.
    """

    times: NDArray[np.float64]
    values: Mapping[str, NDArray[np.float64]]


def calendar(time: float) -> datetime | None:
    """What a calendar said at `time` of the link's clock, if that plainly counts from 1970.

    A damaged time that is beyond all calendars has none either.
    """
    if time < PLAINLY_UNIX:
        return None
    try:
        return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=time)
    except OverflowError:
        return None
