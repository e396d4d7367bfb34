"""Which columns a recording has: what was recorded, what follows from it, and what is wanted."""

from __future__ import annotations

from collections.abc import Iterable

from mikas.catalog import Catalog, Derived
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.recording.table import Channel


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
