"""Which link a port's URL means: `scheme:address?option=value&…`.

- A scheme is the text before the first colon, in any case, if a link is registered for it.
- Anything else is a serial port of the system: `/dev/ttyUSB0`, `COM3`, `/dev/ttyUSB0?baud=10400`.
- Two slashes before the address are allowed and mean nothing: `socket://host:port`.

Links register through the entry-point group `mikas.links`: the name of an entry is the scheme, its
object the `Opener`. So a higher layer or another distribution brings a scheme without being known
here. The group is read when the first scheme is looked up, and only the opener in use is imported.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, cast
from urllib.parse import parse_qsl, urlencode

from mikas.errors import BadPortUrl, UsageError
from mikas.i18n import Text
from mikas.link.base import Link
from mikas.options import OptionParser, nearest, with_nearest

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

Opener = Callable[[str, dict[str, str]], Link]
"""Takes the whole URL and its options, decoded; returns an open link or raises from `mikas.errors`.

It checks its options itself (`mikas.options`). A `UsageError` of its own becomes a `BadPortUrl`.
"""

GROUP = "mikas.links"
_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):")  # two letters at least: C: is a drive


@dataclass(frozen=True, slots=True)
class PortUrl:
    """A URL taken apart. `scheme` is registered; a bare path or COM name has `serial`."""

    scheme: str
    address: str
    options: dict[str, str]


def open_link(url: str, /, **options: str | float) -> Link:
    """Open what `url` names. `options` count as if they stood in its query, and win over those.

    Raises `BadPortUrl` for an invalid URL or option, a `NoConnection` if the port does not open,
    `UsageError` for a link that can't be loaded; an opener may add usage errors of its own.
    """
    if options:
        given = {name: _as_text(value) for name, value in options.items()}
        url = f"{url.partition('?')[0]}?{urlencode(parse(url).options | given)}"
    parsed = parse(url)
    opener = _opener(parsed.scheme)
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
    if match and scheme in _registered():
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


@cache
def _registered() -> dict[str, list[EntryPoint]]:
    """The entries of the group by scheme; more than one is a clash of two distributions."""
    from importlib.metadata import entry_points  # slow to import: some 20 ms

    found: dict[str, list[EntryPoint]] = {}
    for entry in entry_points(group=GROUP):
        found.setdefault(entry.name.lower(), []).append(entry)
    if "serial" not in found:
        raise UsageError(
            problem=Text(
                "mikas is not installed as it should: its metadata name no links",
                "mikas установлен неправильно: в его метаданных нет портов",
            ),
            advice=Text(
                "Install it again: pip install mikas; in its sources, pip install -e .",
                "Установите его заново: pip install mikas; в исходниках — pip install -e .",
            ),
        )
    return found


def _opener(scheme: str) -> Opener:
    entries = _registered()[scheme]
    if len(entries) > 1:
        names = _distributions(entries)
        raise UsageError(
            problem=Text(
                f"more than one distribution brings {scheme}: {names}",
                f"{scheme}: есть сразу в нескольких пакетах: {names}",
            ),
            advice=Text("Uninstall all but one of them.", "Удалите все, кроме одного."),
        )
    try:
        return cast("Opener", entries[0].load())
    except Exception as error:  # another distribution's code: whatever happens in it
        names, why = _distributions(entries), f"{type(error).__name__}: {error}"
        raise UsageError(
            problem=Text(
                f"{scheme}: of the distribution {names} can't be loaded ({why})",
                f"{scheme}: из пакета {names} не загружается ({why})",
            ),
            advice=Text(
                "Update, repair or uninstall that distribution.",
                "Обновите, исправьте или удалите этот пакет.",
            ),
        ) from error


def _distributions(entries: list[EntryPoint]) -> str:
    found = [entry.dist for entry in entries if entry.dist]
    return ", ".join(sorted(f"{dist.name} {dist.version}" for dist in found))


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
    if slashes or (scheme and nearest(scheme, _registered())):
        schemes = [f"{name}:" for name in sorted(_registered())]
        known = ", ".join(schemes)
        problem = Text(f"there is no “{scheme}:”, only: {known}", f"«{scheme}:» нет, есть: {known}")
        raise BadPortUrl(url=url, problem=with_nearest(problem, f"{scheme}:", schemes))


def _as_text(value: str | float) -> str:
    return str(int(value)) if isinstance(value, bool) else str(value)
