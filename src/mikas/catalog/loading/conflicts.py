"""Names and codes that two entries of a catalog can't both have."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from mikas.catalog.loading.entries import Entries, Entry
from mikas.i18n import Text

_TAKEN: Final = {
    "parameter": Text("is the name of a parameter", "имя занято параметром"),
    "derived": Text("is the name of a derived channel", "имя занято производным каналом"),
    "instrument": Text("is the name of an instrument's channel", "имя занято каналом прибора"),
}


def check_names(entries: Entries) -> None:
    """Refuse a name of channels of two kinds, in the later file."""
    seen: dict[str, tuple[str, Entry]] = {}
    for family in _TAKEN:
        for name, entry in entries[family].items():
            other, first = seen.setdefault(name, (family, entry))
            if first is entry:
                continue
            if first.first[0].order > entry.first[0].order:
                raise first.wrong_name(_TAKEN[family])
            raise entry.wrong_name(_TAKEN[other])


def check_sizes(entries: Mapping[str, Entry]) -> None:
    """Refuse two sizes of one code, in the later file."""
    first: dict[int, tuple[str, Entry]] = {}
    for name, entry in entries.items():
        code, size = entry.values["code"], entry.values["size"]
        other_name, other = first.setdefault(code, (name, entry))
        if size == (other_size := other.values["size"]):
            continue
        latest, key = max(
            ((each, key) for each in (entry, other) for key in (("size",), ("code",))),
            key=lambda candidate: candidate[0].order(candidate[1]),
        )
        raise latest.wrong(
            key,
            Text(
                f"makes code 0x{code:02X} of two sizes in bytes: {other_name} has {other_size}, "
                f"{name} has {size}",
                f"у кода 0x{code:02X} два размера: в {other_name} байтов {other_size}, "
                f"в {name} — {size}",
            ),
        )
