"""Whether an object is a link: for those that other code brings."""

from __future__ import annotations

from typing import Final

from mikas.link.base import Link

_NAMES: Final = ("url", *(name for name in dir(Link) if not name.startswith("_")))
_MOST: Final = 4  # names in a message


def lacking(link: object) -> str:
    """Return the first names of the interface `mikas.link.Link` that the object lacks."""
    if isinstance(link, Link) and hasattr(link, "url"):
        return ""
    names = [name for name in _NAMES if not _has(link, name)]
    return ", ".join(names[:_MOST]) + (" …" if names[_MOST:] else "")


def check_link(link: object, what: str) -> None:
    """Raise `TypeError` if the object, which `what` is, is no link."""
    if lacks := lacking(link):
        raise TypeError(
            f"{what} has to be an open link, of a class derived from mikas.link.Link; {link!r} "
            f"has no {lacks}"
        )


def _has(link: object, name: str) -> bool:
    is_method = callable(getattr(Link, name, None))
    return callable(getattr(link, name, None)) if is_method else hasattr(link, name)
