"""Which port is whose: the unit and each instrument beside it have one of their own.

A virtual car has room for all, and gpsd serves many programs.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from mikas.errors import BadPortUrl
from mikas.link.ports import Port, only_likely, real_name
from mikas.link.urls import parse

GPSD: Final = "gpsd:"
SIM: Final = "sim:"


def at_one_port(one: str, other: str) -> bool:
    """Return whether two URLs are of one port; a link to a port of this computer is that port."""
    place = _place(one)
    return place is not None and place == _place(other)


def likely_beside(taken: Iterable[str], ports: Iterable[Port]) -> str:
    """Return the only likely one of `ports` at which no instrument is; `taken`: their URLs.

    Raises as `only_likely`.
    """
    urls = tuple(taken)
    return only_likely([it for it in ports if not any(at_one_port(it.url, url) for url in urls)])


def _place(url: str) -> tuple[str, str] | None:
    """Return the scheme and the address of a port; None: it is for one user or more."""
    if url.lower().startswith((GPSD, SIM)):
        return None
    try:
        parsed = parse(url)
    except BadPortUrl:  # said when it is opened
        return None
    if parsed.scheme == "serial":
        return parsed.scheme, real_name(parsed.address)
    return parsed.scheme, parsed.address.casefold()
