"""The address of a webhook: http on this computer, and nowhere else.

`check_webhook` looks at the text alone. Before it is used, `mikas.conditions.webhooks` resolves it
once, refuses it unless every address of the name is a loopback one, and connects to those
only: a name that is later another computer's can't move the request.
"""

from __future__ import annotations

from ipaddress import ip_address
from typing import Final
from urllib.parse import SplitResult, urlsplit

from mikas.cleaning import clean_line
from mikas.errors import UsageError, usage_error

LONGEST: Final = 500
_EXAMPLE: Final = "http://127.0.0.1:1880/hot"


def check_webhook(url: str) -> SplitResult:
    """Return the parts of a webhook's address. Raises `UsageError`."""
    try:
        parts = urlsplit(url)
        port = parts.port
    except ValueError:
        raise _wrong("the port is a number up to 65535", "порт — число до 65535") from None
    if len(url) > LONGEST or clean_line(url) != url or any(map(str.isspace, url)):
        raise _wrong("it has signs that no address has", "в нём знаки, которых в адресе не бывает")
    if not url.isascii():
        raise _wrong("other signs are written as %D0%9F", "другие знаки пишутся как %D0%9F")
    if parts.scheme != "http":
        raise _wrong("it begins with http://", "он начинается с http://")
    if not parts.hostname or port == 0:
        raise _wrong("the host is missing", "нет имени компьютера")
    if parts.username is not None or parts.password is not None:
        raise _wrong("a user name and a password have no place in it", "имени и пароля в нём нет")
    if parts.fragment:
        raise _wrong("nothing follows a #", "после # ничего нет")
    if is_address(parts.hostname) and not is_loopback(parts.hostname):
        raise not_here(parts.hostname)
    return parts


def is_address(host: str) -> bool:
    """Return whether a host is written as an address, not as a name."""
    try:
        ip_address(host)
    except ValueError:
        return False
    return True


def is_loopback(address: str) -> bool:
    """Return whether an address leads to this computer alone: 127.0.0.0/8, ::1."""
    found = ip_address(address)
    mapped = getattr(found, "ipv4_mapped", None)
    return bool(mapped.is_loopback if mapped is not None else found.is_loopback)


def not_here(host: str) -> UsageError:
    """Return the error for a host that is not this computer alone."""
    return usage_error(
        f"{host} is not this computer: a webhook goes to localhost or 127.0.0.1 only",
        f"{host} — не этот компьютер: вебхук возможен только на localhost или 127.0.0.1",
    )


def _wrong(en: str, ru: str) -> UsageError:
    return usage_error(
        f"is no address of a webhook: {en}, as {_EXAMPLE}",
        f"это не адрес вебхука: {ru}, например {_EXAMPLE}",
    )
