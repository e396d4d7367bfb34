"""This computer's addresses in its networks, those that a phone can reach first.

Each interface that is up counts; a default route is not needed, and a VPN that has it comes last:

    1  Wi-Fi, Ethernet, a hotspot: private IPv4, ULA, public IPv4, global IPv6, 169.254.*
    2  VPN, tunnel, bridge or card of containers and virtual machines: in the same order

IPv6 link-local addresses are left out: they need a zone (`fe80::1%wlan0`), which no browser takes.
So are temporary ones (RFC 8981), where the system names them (Linux): each is replaced daily, and
with it the certificate would be, of which a phone then warns again.

Linux says of its interfaces what they are (/sys/class/net), Windows the type and the description;
elsewhere the name and the flag of a point-to-point link have to do.
"""

from __future__ import annotations

import ctypes
import ipaddress
import re
import socket
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Final


class Kind(IntEnum):
    """The kind of an interface, the likeliest to share a network with a phone first."""

    WIRELESS = 0
    OTHER = 1
    VIRTUAL = 2


@dataclass(frozen=True, slots=True)
class Address:
    """An address of an interface that is up."""

    number: str
    interface: str
    kind: Kind


_SYSTEM: Final = Path("/sys/class/net")
_IPV6_LIST: Final = Path("/proc/net/if_inet6")
_TEMPORARY: Final = 0x01  # IFA_F_TEMPORARY
_UP, _LOOPBACK, _POINT_TO_POINT, _RUNNING = 0x1, 0x8, 0x10, 0x40  # Linux, macOS, BSD
_ETHERNET: Final = range(1, 3), range(801, 804)  # ARPHRD_*: and of Wi-Fi
_VIRTUAL_NAME: Final = re.compile(
    "^(u?tun|tap|wg|ppp|ipsec|gif|stf|gre|sit|ip6tnl|vti|xfrm|vpn|tailscale|zt|ham[0-9]|nordlynx|"
    "nordtun|proton|pvpn|mullvad|cscotun|gpd|cloudflarewarp|outline|docker|br-|veth|virbr|vmnet|"
    "vmenet|vnet|vnic|vboxnet|lxc|lxd|incus|cni|flannel|cali|cilium|podman|kube|dummy)",
    re.IGNORECASE,
)
_VIRTUAL_DESCRIPTION: Final = re.compile(
    r"\b(vpn|openvpn|tap|wintun|wireguard|tunnel|tailscale|zerotier|hamachi|radmin|anyconnect|"
    r"fortinet|pangp|juniper|nordlynx|hyper-v virtual|vethernet|vmware|virtualbox|docker|wsl)\b",
    re.IGNORECASE,
)
_PRIVATE: Final = tuple(
    ipaddress.IPv4Network(each) for each in ("10.0.0.0/8", "172.16.0.0/12", "192.168.0.0/16")
)
_ULA: Final = ipaddress.IPv6Network("fc00::/7")


def own_addresses() -> tuple[str, ...]:
    """Return this computer's addresses in the network, the likeliest first, then its names."""
    try:
        passing = _temporary()
        found = in_order([each for each in _addresses() if each.number not in passing])
    except (OSError, AttributeError):  # a system that forbids, or has not, the list
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
    usable.sort(key=lambda it: (it.kind is Kind.VIRTUAL, _reach(it.number), it.kind))
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
        return in_order([Address(str(probe.getsockname()[0]), "", Kind.OTHER)])
    return ()


def _temporary() -> frozenset[str]:
    """Return the temporary IPv6 addresses. A line: address, index, prefix, scope, flags, name."""
    found = set()
    with suppress(OSError, ValueError):
        for line in _IPV6_LIST.read_text("ascii").splitlines():
            number, _, _, _, flags, _ = line.split()
            if int(flags, 16) & _TEMPORARY:
                found.add(str(ipaddress.IPv6Address(int(number, 16))))
    return frozenset(found)


def kind_of(name: str, *, is_point_to_point: bool = False, system: Path = _SYSTEM) -> Kind:
    """Return the kind of an interface of Linux, macOS or BSD."""
    folder = system / name
    if (folder / "device").exists():
        return Kind.WIRELESS if (folder / "phy80211").exists() else Kind.OTHER
    if (folder / "bridge").exists():  # it is what its ports are
        ports = [each.name for each in (folder / "brif").glob("*")]
        real = [each for each in ports if (system / each / "device").exists()]
        return min((kind_of(each, system=system) for each in real), default=Kind.VIRTUAL)
    with suppress(OSError, ValueError):
        kind = int((folder / "type").read_text())
        if not any(kind in known for known in _ETHERNET) or (folder / "tun_flags").exists():
            return Kind.VIRTUAL
    if is_point_to_point or _VIRTUAL_NAME.match(name):
        return Kind.VIRTUAL
    return Kind.WIRELESS if name.startswith("wl") else Kind.OTHER


def kind_of_windows(kind: int, texts: Sequence[str]) -> Kind:
    """Return the kind of an interface of Windows by IF_TYPE_* and its names.

    Its own hotspot is a “Wi-Fi Direct Virtual Adapter” of the type of Wi-Fi.
    """
    if kind == 71:
        return Kind.WIRELESS
    if kind in (23, 53, 131) or any(map(_VIRTUAL_DESCRIPTION.search, texts)):
        return Kind.VIRTUAL  # PPP, virtual, tunnel
    return Kind.OTHER


if sys.platform == "win32":
    from ctypes import wintypes

    class _SocketAddress(ctypes.Structure):
        _fields_ = [("address", ctypes.c_void_p), ("length", ctypes.c_int)]

    class _Unicast(ctypes.Structure):
        _fields_ = [
            ("length", wintypes.ULONG),
            ("flags", wintypes.DWORD),
            ("next", ctypes.c_void_p),
            ("socket", _SocketAddress),
        ]

    class _Adapter(ctypes.Structure):
        _fields_ = [
            ("length", wintypes.ULONG),
            ("index", wintypes.DWORD),
            ("next", ctypes.c_void_p),
            ("name", ctypes.c_char_p),
            ("unicast", ctypes.c_void_p),
            ("anycast", ctypes.c_void_p),
            ("multicast", ctypes.c_void_p),
            ("dns", ctypes.c_void_p),
            ("suffix", ctypes.c_wchar_p),
            ("description", ctypes.c_wchar_p),
            ("friendly", ctypes.c_wchar_p),
            ("physical", ctypes.c_ubyte * 8),
            ("physical_length", wintypes.ULONG),
            ("flags", wintypes.DWORD),
            ("mtu", wintypes.DWORD),
            ("type", wintypes.DWORD),
            ("status", ctypes.c_int),
        ]

    def _addresses() -> Iterator[Address]:
        """Yield the addresses of the interfaces that are up. Raises `OSError`."""
        size = wintypes.ULONG(1 << 15)
        for _ in range(4):  # the list may grow meanwhile
            memory = ctypes.create_string_buffer(size.value)
            code = ctypes.WinDLL("iphlpapi").GetAdaptersAddresses(
                0, 0, None, memory, ctypes.byref(size)
            )
            if code != 111:  # ERROR_BUFFER_OVERFLOW
                break
        if code == 232:  # ERROR_NO_DATA
            return
        if code:
            raise OSError(code, "GetAdaptersAddresses")
        at = ctypes.addressof(memory)
        while at:
            adapter = _Adapter.from_address(at)
            if adapter.status == 1:
                texts = adapter.description or "", adapter.friendly or ""
                kind, unicast = kind_of_windows(adapter.type, texts), adapter.unicast
                while unicast:
                    entry = _Unicast.from_address(unicast)
                    family = int.from_bytes(ctypes.string_at(entry.socket.address, 2), "little")
                    if (number := _number(family, entry.socket.address)) is not None:
                        yield Address(number, texts[1], kind)
                    unicast = entry.next
            at = adapter.next

else:

    class _Entry(ctypes.Structure):
        """`struct ifaddrs`."""

        _fields_ = [
            ("next", ctypes.c_void_p),
            ("name", ctypes.c_char_p),
            ("flags", ctypes.c_uint),
            ("address", ctypes.c_void_p),
        ]

    def _addresses() -> Iterator[Address]:
        """Yield the addresses of the interfaces that are up. Raises `OSError`, `AttributeError`."""
        system = ctypes.CDLL(None, use_errno=True)
        first = ctypes.c_void_p()
        if system.getifaddrs(ctypes.byref(first)):
            raise OSError(ctypes.get_errno(), "getifaddrs")
        try:
            at = first.value
            while at:
                entry = _Entry.from_address(at)
                at = entry.next
                is_up = entry.flags & (_UP | _RUNNING) == _UP | _RUNNING
                if not is_up or entry.flags & _LOOPBACK or not entry.address:
                    continue
                head = ctypes.string_at(entry.address, 2)
                family = int.from_bytes(head, sys.byteorder) if sys.platform == "linux" else head[1]
                if (number := _number(family, entry.address)) is not None:
                    name = entry.name.decode(errors="replace")
                    point = bool(entry.flags & _POINT_TO_POINT)
                    yield Address(number, name, kind_of(name, is_point_to_point=point))
        finally:
            system.freeifaddrs(first)


def _number(family: int, at: int) -> str | None:
    """Return the address of a `sockaddr_in` or `sockaddr_in6` in memory; None: another one."""
    if family == socket.AF_INET:
        return str(ipaddress.IPv4Address(ctypes.string_at(at + 4, 4)))
    if family == socket.AF_INET6:
        return str(ipaddress.IPv6Address(ctypes.string_at(at + 8, 16)))
    return None
