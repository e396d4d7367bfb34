"""The HTTP server's sockets; nothing heavy is imported for them."""

from __future__ import annotations

import errno
import ipaddress
import socket
import sys

from mikas.errors import reason_of, usage_error

FIRST_PORT = 8071
_TRIED = 20
_SEND_BUFFER = 1 << 16  # bytes of a slow client that the system may queue


def is_loopback(address: str) -> bool:
    """Return whether a connection from `address` comes from this computer."""
    try:
        return ipaddress.ip_address(address).is_loopback
    except ValueError:
        return False


def listen(port: int | None, *, lan: bool) -> socket.socket:
    """Return a socket on `port`, or on the first free one from 8071 on. Raises `UsageError`."""
    wanted = range(FIRST_PORT, FIRST_PORT + _TRIED) if port is None else [port]
    failure: OSError | None = None
    for number in (*wanted, *([0] if port is None else [])):
        try:
            return bound("0.0.0.0" if lan else "127.0.0.1", number)
        except OSError as error:
            failure = error
            if error.errno not in (errno.EADDRINUSE, errno.EACCES):
                break
    assert failure is not None
    why = reason_of(failure)
    failed = usage_error(
        f"The dashboard can't listen on port {port or FIRST_PORT}: {why.en}; choose another "
        "with --host-port, or omit it to take a free one",
        f"Панель не может занять порт {port or FIRST_PORT}: {why.ru}; укажите другой ключом "
        "--host-port или уберите его, тогда найдётся свободный",
    )
    raise failed.caused_by(failure) from failure


def listen_ipv6(port: int) -> list[socket.socket]:
    """Return a socket on all IPv6 addresses at `port`; none where there is no IPv6, or no port."""
    try:
        return [bound("::", port)]
    except OSError:
        return []


def bound(host: str, port: int) -> socket.socket:
    """Return a listening socket at one address. Raises `OSError`."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    # With its protocol named, asyncio sends without waiting for more (TCP_NODELAY).
    own = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    try:
        if family == socket.AF_INET6:  # IPv4 has a socket of its own
            own.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        if sys.platform != "win32":  # where the option would share the port with another program
            own.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        own.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        own.bind((host, port))
        own.listen()  # without it, two programs may be bound to one port
    except OSError:
        own.close()
        raise
    return own
