"""Temporary IPv6 addresses (RFC 8981), which no link for a phone has.

Each is replaced daily, and with it the certificate would be, of which a phone then warns again.
"""

from __future__ import annotations

import ipaddress
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final

_LIST: Final = Path("/proc/net/if_inet6")
_FLAG: Final = 0x01  # IFA_F_TEMPORARY
_IFCONFIG: Final = "/sbin/ifconfig"
_PATIENCE: Final = 5.0  # s
_ADVERTISED, _RANDOM = 4, 5  # IpPrefixOriginRouterAdvertisement, IpSuffixOriginRandom


def temporary_addresses() -> frozenset[str]:
    """Return those of Linux, macOS and FreeBSD; Windows has the mark in its list of addresses."""
    with suppress(OSError, ValueError, subprocess.SubprocessError):
        if sys.platform == "linux":
            return in_list(_LIST.read_text("ascii"))
        if sys.platform.startswith(("darwin", "freebsd")):
            return in_ifconfig(ifconfig())
    return frozenset()


def ifconfig() -> str:
    """Return the system's words on its IPv6 addresses. Raises `OSError`, `SubprocessError`."""
    words = [_IFCONFIG, "-a", "inet6"]
    answer = subprocess.run(words, capture_output=True, timeout=_PATIENCE, check=True)
    return answer.stdout.decode(errors="replace")


def in_list(text: str) -> frozenset[str]:
    """Return those of Linux's list. A line: address, index, prefix, scope, flags, name."""
    found = set()
    for line in text.splitlines():
        number, _, _, _, flags, _ = line.split()
        if int(flags, 16) & _FLAG:
            found.add(str(ipaddress.IPv6Address(int(number, 16))))
    return frozenset(found)


def in_ifconfig(text: str) -> frozenset[str]:
    """Return those that `ifconfig` marks: `inet6 2001:db8::1 prefixlen 64 autoconf temporary`."""
    found = set()
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["inet6"] and "temporary" in words[2:]:
            found.add(str(ipaddress.IPv6Interface(words[1]).ip))
    return frozenset(found)


def is_temporary_windows(prefix: int, suffix: int) -> bool:
    """Return whether Windows made an address of these origins (IP_PREFIX_ORIGIN, IP_SUFFIX_ORIGIN).

    Of a stable one the suffix is of the link layer, by hand, or of DHCP, random as it may look.
    """
    return (prefix, suffix) == (_ADVERTISED, _RANDOM)
