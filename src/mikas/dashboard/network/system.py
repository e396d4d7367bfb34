"""The addresses of this computer's interfaces, asked of the system itself.

By `getifaddrs` (Linux, macOS, BSD) or `GetAdaptersAddresses` (Windows). It is imported when they
are asked for: Pyodide has no interfaces, and need not load `ctypes`.
"""

from __future__ import annotations

import ctypes
import ipaddress
import socket
import sys
from collections.abc import Iterator

from mikas.dashboard.network.interfaces import Address, kind_of, kind_of_windows
from mikas.dashboard.network.temporary import is_temporary_windows

_UP, _LOOPBACK, _POINT_TO_POINT, _RUNNING = 0x1, 0x8, 0x10, 0x40  # Linux, macOS, BSD

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
            ("prefix_origin", ctypes.c_int),
            ("suffix_origin", ctypes.c_int),
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

    def system_addresses() -> Iterator[Address]:
        """Yield the addresses of the interfaces that are up, but no temporary ones.

        Raises `OSError`.
        """
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
                    number = _number(family, entry.socket.address)
                    passing = is_temporary_windows(entry.prefix_origin, entry.suffix_origin)
                    if number is not None and not passing:
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

    def system_addresses() -> Iterator[Address]:
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
