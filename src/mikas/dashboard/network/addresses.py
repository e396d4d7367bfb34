"""This computer's addresses in its networks, those that a phone can reach first.

Each interface that is up counts; a default route is not needed, and a VPN that has it comes last:

    1  Wi-Fi, Ethernet, a hotspot: private IPv4, ULA, public IPv4, global IPv6, 169.254.*
    2  VPN, tunnel, bridge or card of containers and virtual machines: in the same order

IPv6 link-local addresses are left out: they need a zone (`fe80::1%wlan0`), which no browser takes.
So are temporary ones.
"""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Sequence
from contextlib import suppress
from typing import Final

from mikas.dashboard.network.interfaces import Address, InterfaceKind

_PRIVATE: Final = tuple(
    ipaddress.IPv4Network(each) for each in ("10.0.0.0/8", "172.16.0.0/12", "192.168.0.0/16")
)
_ULA: Final = ipaddress.IPv6Network("fc00::/7")


def own_addresses() -> tuple[str, ...]:
    """Return this computer's addresses in the network, the likeliest first, then its names."""
    try:
        from mikas.dashboard.network.system import system_addresses
        from mikas.dashboard.network.temporary import temporary_addresses

        passing = temporary_addresses()
        found = in_order([each for each in system_addresses() if each.number not in passing])
    except (ImportError, OSError, AttributeError):  # a system that forbids, or has not, the list
        found = _of_default_route()
    name = socket.gethostname()
    names = (name,) if name.endswith(".local") else (name, f"{name}.local")
    return (*found, *names)


def is_ipv6(host: str) -> bool:
    """Return whether `host` is an IPv6 address; no name has a colon."""
    return ":" in host


def is_number(host: str) -> bool:
    """Return whether `host` is an address, not a name."""
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


def in_order(addresses: Sequence[Address]) -> tuple[str, ...]:
    """Return the addresses that a browser can open, the likeliest to be reached first."""
    usable = [each for each in addresses if _reach(each.number) is not None]
    usable.sort(key=lambda it: (it.kind is InterfaceKind.VIRTUAL, _reach(it.number), it.kind))
    return tuple(dict.fromkeys(each.number for each in usable))


def _reach(number: str) -> int | None:
    """Return the place of an address among those of an interface; None: it is not offered."""
    address = ipaddress.ip_address(number)
    if address.is_loopback or address.is_unspecified or address.is_multicast:
        return None
    if isinstance(address, ipaddress.IPv4Address):
        if address.is_link_local:
            return 4
        return 0 if any(address in network for network in _PRIVATE) else 2
    if address.is_link_local:
        return None
    return 1 if address in _ULA else 3


def _of_default_route() -> tuple[str, ...]:
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1", 9))  # nothing is sent: the system chooses the interface
        return in_order([Address(str(probe.getsockname()[0]), "", InterfaceKind.OTHER)])
    return ()
