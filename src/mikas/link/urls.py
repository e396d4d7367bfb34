"""From a port's URL `scheme:address?option=value&…` to its link.

- A scheme is the text before the first colon, in any case, if a link is registered for it.
- Anything else is a serial port of the system: `/dev/ttyUSB0`, `COM3`, `/dev/ttyUSB0?baud=10400`.
- Two slashes before the address are optional: `socket://host:port`.

Links register through the entry-point group `mikas.links`: an entry's name is the scheme, its
object the `Opener`. So a higher layer or another distribution can add a scheme. The group is read
at the first lookup, and only the opener in use is imported.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, cast
from urllib.parse import parse_qsl, urlencode, urlsplit

from mikas.distributions import entries_of, is_of_mikas, loaded, unfit
from mikas.errors import BadPortUrl, MikasError, PortFailed, PortKind, UsageError, reason_of
from mikas.i18n import Text
from mikas.link.base import Link
from mikas.link.flood import FloodGuard
from mikas.link.interface import lacking
from mikas.link.suspension import SuspensionGuard
from mikas.options import OptionParser, nearest, with_nearest

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

Opener = Callable[[str, dict[str, str]], Link]
"""Takes the whole URL and its decoded options, checks these (`mikas.options`), and returns an open
link. A plain `UsageError` that it raises becomes a `BadPortUrl`.
"""

GROUP = "mikas.links"
_OF_ADAPTERS = ("serial", "webserial", "webusb")
_OF_NETWORKS = ("socket", "rfc2217")
_NO_NAME = Text("a browser opens no port by its name", "по такому имени браузер порт не открывает")
_IN_A_BROWSER = Text(
    "A page reaches only cables that were chosen in the browser's list: press “Choose the cable…”. "
    "Its ports look like webserial:0403:6001 (the cable's USB vendor and product; on a phone "
    "webusb:0403:6001), sim: or replay:FILE.",
    "Странице доступны только кабели, выбранные в списке браузера: нажмите «Выбрать кабель…». "
    "Порты здесь пишутся так: webserial:0403:6001 (USB-номера кабеля; на телефоне "
    "webusb:0403:6001), sim:, replay:FILE.",
)
_NO_OPENER = Text(
    "is not a function of an address and its options",
    "не функция от адреса и его параметров",
)
_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):")  # two letters at least: C: is a drive


@dataclass(frozen=True, slots=True)
class PortUrl:
    """The parts of a URL. `scheme` is registered; a bare path or COM name has `serial`."""

    scheme: str
    address: str
    options: dict[str, str]

    @property
    def name(self) -> str:
        """The URL without its options: an adapter's `Port.url`."""
        return self.address if self.scheme == "serial" else f"{self.scheme}:{self.address}"

    @property
    def is_adapter(self) -> bool:
        """Whether it names an adapter that is plugged in here, and may come back elsewhere."""
        return self.scheme in _OF_ADAPTERS


def open_link(url: str, /, **options: str | float) -> Link:
    """Open the link of `url`; `options` override those of its query.

    A link that brings more bytes than its line can carry raises `LineFlooded`, one that was not
    read for a while `ReadingSuspended`.

    Raises `BadPortUrl` for an invalid URL or option, `NoConnection` if the port does not open,
    `UsageError` for a link that can't be loaded; an opener may raise other usage errors.
    """
    if options:
        given = {name: _as_text(value) for name, value in options.items()}
        url = f"{url.partition('?')[0]}?{urlencode(parse(url).options | given)}"
    parsed = parse(url)
    if parsed.scheme not in registered():  # a name without scheme
        raise bad_port_url(url, _NO_NAME)
    link = _opened(url, parsed)
    return link if link.is_virtual else FloodGuard(SuspensionGuard(link))


def parse(url: str) -> PortUrl:
    """Split `url` into its parts. Raises `BadPortUrl`."""
    place, _, query = url.partition("?")
    match = _SCHEME.match(place)
    scheme = match[1].lower() if match else ""
    if match and scheme in registered():
        address = place[match.end() :].removeprefix("//")
    else:
        _refuse_unknown(url, scheme, slashes=bool(match) and "://" in place)
        scheme, address = "serial", place
    if scheme == "serial" and not address.strip():
        raise bad_port_url(url, Text("it is empty", "он пуст"))
    if "\0" in url:
        raise bad_port_url(url, Text("it holds a zero byte", "в нём нулевой байт"))
    return PortUrl(scheme, address, _options(url, query))


def are_of_two_cars(one: str, other: str) -> bool:
    """Return whether the units at two URLs are of two cars, whatever they say of themselves.

    Each virtual car has a URL of its own; the plug of an adapter is carried from car to car.
    """
    return one != other and "sim" in {parse(one).scheme, parse(other).scheme}


def kind_of(url: str) -> PortKind:
    """Return what lies between this computer and the K-Line, of any URL."""
    is_network = url.partition(":")[0].lower() in _OF_NETWORKS
    return PortKind.NETWORK if is_network else PortKind.CABLE


def host_and_port(url: str) -> tuple[str, int]:
    """Return the host and the port's number of a network URL. Raises `BadPortUrl`."""
    parsed = parse(url)
    try:
        parts = urlsplit(f"//{parsed.address}")
        host, port = parts.hostname, parts.port
    except ValueError:  # the port is not a number below 65536, or a bracket is open
        host, port = None, None
    if not host or not port or parts.path or "@" in parsed.address:
        problem = Text(
            f"it needs a host and a port number, as in {parsed.scheme}://192.168.0.5:4001",
            f"нужны адрес и номер порта, например {parsed.scheme}://192.168.0.5:4001",
        )
        raise bad_port_url(url, problem)
    return host, port


def bad_port_url(url: str, problem: Text) -> BadPortUrl:
    """Return the error, with the ports that there are here: a browser has none by name."""
    advice = None if "serial" in registered() else _IN_A_BROWSER
    return BadPortUrl(url=url, problem=problem, advice=advice)


def with_name(url: str, name: str) -> str:
    """Return the `url` of an adapter with another name and the same options."""
    return name + url.removeprefix(url.partition("?")[0])


def take_clock(options: dict[str, str]) -> bool:
    """Remove the option `clock`, `real` or `simulated`; return whether it is `simulated`."""
    clock = OptionParser(options).choice("clock", "real", ("real", "simulated"))
    options.pop("clock", None)
    return clock == "simulated"


@cache
def registered() -> dict[str, list[EntryPoint]]:
    """Return the entries by scheme; two entries of one scheme are of different distributions."""
    found = entries_of(GROUP)
    if "sim" not in found:  # what works everywhere
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


def opener_of(scheme: str) -> Opener:
    """Return the opener of a registered scheme. Raises `UsageError` if it can't be loaded."""
    entries = registered()[scheme]
    opener = loaded(scheme, entries)
    if not callable(opener):
        raise unfit(scheme, entries, _NO_OPENER)
    return cast("Opener", opener)


def _opened(url: str, parsed: PortUrl) -> Link:
    """Return the open link, whatever another distribution's opener does."""
    opener = opener_of(parsed.scheme)
    entries = registered()[parsed.scheme]
    try:
        link = opener(url, parsed.options)
    except UsageError as error:
        if error.kind is not UsageError:
            raise
        raise bad_port_url(url, error.reason).caused_by(error) from error
    except Exception as error:  # another distribution's code may raise anything
        if isinstance(error, MikasError) or is_of_mikas(entries):
            raise
        if isinstance(error, OSError):
            raise PortFailed(url=url, problem=reason_of(error)).caused_by(error) from error
        raise unfit(parsed.scheme, entries, _cannot_open(error)) from error
    if lacks := lacking(link):
        raise unfit(parsed.scheme, entries, _no_link(link, lacks))
    return link


def _cannot_open(error: Exception) -> Text:
    why = f"{type(error).__name__}: {error}"
    return Text(f"could not open the port ({why})", f"не открыл порт ({why})")


def _no_link(found: object, lacks: str) -> Text:
    return Text(
        f"opened no link: {found!r} has no {lacks}", f"открыл не порт: у {found!r} нет {lacks}"
    )


def _options(url: str, query: str) -> dict[str, str]:
    options: dict[str, str] = {}
    for name, value in parse_qsl(query, keep_blank_values=True):
        if name in options:
            problem = Text(f"{name} is given twice", f"{name} указано дважды")
            raise bad_port_url(url, problem)
        options[name] = value
    return options


def _refuse_unknown(url: str, scheme: str, *, slashes: bool) -> None:
    """Raise `BadPortUrl` for an unknown scheme; a path that contains a colon passes."""
    if slashes or (scheme and nearest(scheme, registered())):
        schemes = [f"{name}:" for name in sorted(registered())]
        known = ", ".join(schemes)
        absent = Text(f"there is no “{scheme}:”, only: {known}", f"«{scheme}:» нет, есть: {known}")
        raise bad_port_url(url, with_nearest(absent, f"{scheme}:", schemes))


def _as_text(value: str | float) -> str:
    return str(int(value)) if isinstance(value, bool) else str(value)
