"""Which link a port's URL means: `scheme:address?option=value&…`, and the register of schemes.

- A scheme is what stands before the first colon, in any case, if it is registered.
- Anything else is a serial port of the system: `/dev/ttyUSB0`, `COM3`, `/dev/ttyUSB0?baud=10400`.
- Two slashes before the address are allowed and mean nothing: `socket://host:port`.

This module knows openers by name only and imports one when its scheme is used: `import mikas.link`
stays cheap, and a higher layer can bring a scheme of its own (`register`) without being known here.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import cast
from urllib.parse import parse_qsl, urlencode

from mikas.errors import BadPortUrl, UsageError
from mikas.i18n import Text
from mikas.link.base import Link
from mikas.options import OptionParser, nearest, with_nearest

Opener = Callable[[str, dict[str, str]], Link]
"""Takes the whole URL and its options, decoded; returns an open link or raises from `mikas.errors`.

It checks its options itself (`mikas.options`). A `UsageError` of its own becomes a `BadPortUrl`.
"""

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):")  # two letters at least: C: is a drive
_openers: dict[str, Opener | str] = {
    "serial": "mikas.link.serial:open_serial",
    "socket": "mikas.link.serial:open_socket",
    "rfc2217": "mikas.link.serial:open_rfc2217",
    "sim": "mikas.link.virtual:open_sim",
    "replay": "mikas.replay.port:open_replay",  # a higher layer's: known by its name only
}


@dataclass(frozen=True, slots=True)
class PortUrl:
    """A URL taken apart. `scheme` is registered; a bare path or COM name has `serial`."""

    scheme: str
    address: str
    options: dict[str, str]


def register(scheme: str, opener: Opener | str) -> None:
    """Make `scheme:` mean `opener`, or the opener at an import path like `package.module:name`.

    A later registration replaces an earlier one. Raises `ValueError` for a scheme that no URL can
    have: it takes two or more letters, digits, `+`, `.` and `-`, a letter first.
    """
    if not _SCHEME.fullmatch(f"{scheme}:"):
        raise ValueError(f"{scheme!r} can't be the scheme of a URL")
    _openers[scheme.lower()] = opener


def open_link(url: str, /, **options: str | float) -> Link:
    """Open what `url` names. `options` count as if they stood in its query, and win over those.

    Raises `BadPortUrl` if the URL or an option makes no sense, a `NoConnection` if the port does
    not open; a scheme's opener may add usage errors of its own.
    """
    if options:
        given = {name: _as_text(value) for name, value in options.items()}
        url = f"{url.partition('?')[0]}?{urlencode(parse(url).options | given)}"
    parsed = parse(url)
    opener = _openers[parsed.scheme]
    if isinstance(opener, str):
        module, _, name = opener.partition(":")
        opener = cast("Opener", getattr(import_module(module), name))
    try:
        return opener(url, parsed.options)
    except UsageError as error:
        if type(error) is not UsageError:
            raise
        raise BadPortUrl(url=url, problem=error.reason) from error


def parse(url: str) -> PortUrl:
    """Take `url` apart, opening nothing. Raises `BadPortUrl`."""
    place, _, query = url.partition("?")
    match = _SCHEME.match(place)
    scheme = match[1].lower() if match else ""
    if match and scheme in _openers:
        address = place[match.end() :].removeprefix("//")
    else:
        _refuse_unknown(url, scheme, slashes=bool(match) and "://" in place)
        scheme, address = "serial", place
    if scheme == "serial" and not address.strip():
        raise BadPortUrl(url=url, problem=Text("it is empty", "он пуст"))
    if "\0" in url:
        raise BadPortUrl(url=url, problem=Text("it holds a zero byte", "в нём нулевой байт"))
    return PortUrl(scheme, address, _options(url, query))


def take_clock(options: dict[str, str]) -> bool:
    """Take the option `clock` out of `options`; return whether it is `simulated`, not `real`.

    Raises `UsageError` for any other value.
    """
    clock = OptionParser(options).choice("clock", "real", ("real", "simulated"))
    options.pop("clock", None)
    return clock == "simulated"


def _options(url: str, query: str) -> dict[str, str]:
    options: dict[str, str] = {}
    for name, value in parse_qsl(query, keep_blank_values=True):
        if name in options:
            problem = Text(f"{name} is given twice", f"{name} указано дважды")
            raise BadPortUrl(url=url, problem=problem)
        options[name] = value
    return options


def _refuse_unknown(url: str, scheme: str, *, slashes: bool) -> None:
    """Refuse what was meant as a scheme and is none; a path with a colon in it passes."""
    if slashes or (scheme and nearest(scheme, _openers)):
        known = ", ".join(f"{name}:" for name in _openers)
        problem = Text(f"there is no “{scheme}:”, only: {known}", f"«{scheme}:» нет, есть: {known}")
        schemes = [f"{name}:" for name in _openers]
        raise BadPortUrl(url=url, problem=with_nearest(problem, f"{scheme}:", schemes))


def _as_text(value: str | float) -> str:
    return str(int(value)) if isinstance(value, bool) else str(value)
