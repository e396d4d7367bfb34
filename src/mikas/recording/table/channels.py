"""Columns over time, the source of every export and data frame; and which ones a recording has.

A recording of ten hours does not fit a table at once, so it comes in stretches (`Rows`), each with
the same columns. A value that is missing (a gap, a parameter asked less often) is NaN, never the
last one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Final

from mikas.catalog import Catalog, Derived
from mikas.errors import UsageError
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


def named(catalog: Catalog, name: str) -> str:
    """The channel's name in full. Raises `UsageError` for what has no column."""
    found = catalog.channel(name).name
    if found not in catalog.derived and all(found != each.name for each in catalog.parameters):
        raise UsageError(
            problem=Text(
                f"{name}: a bare code has no column; name a parameter, or describe the code in a "
                "catalog file of your own",
                f"{name}: у голого кода нет столбца; назовите параметр или опишите код в своём "
                "файле каталога",
            )
        )
    return found


def is_recorded(name: str, catalog: Catalog, recorded: Iterable[str]) -> bool:
    """Whether all is recorded that this channel is made of."""
    if name not in catalog.derived:
        return name in recorded
    from mikas.sampling.derived import DerivedChannels

    return set(DerivedChannels(catalog, [name]).requires) <= set(recorded)


def all_channels(
    read: Iterable[Channel], catalog: Catalog, recorded: Iterable[str], wanted: Iterable[str]
) -> dict[str, Channel]:
    """What was recorded, what follows from it, and what is wanted all the same."""
    known = {channel.name: channel for channel in read}
    for derived in catalog.derived.values():
        if is_recorded(derived.name, catalog, recorded):
            known[derived.name] = _column(derived)
    for name in wanted:
        if name not in known:
            channel = catalog.channel(name)
            known[name] = (
                _column(channel)
                if isinstance(channel, Derived)
                else Channel(name, channel.unit, channel.text, channel.is_flag, channel.decimals)
            )
    return known


def _column(derived: Derived) -> Channel:
    return Channel(derived.name, derived.unit, derived.text, decimals=derived.decimals)
