"""A TCP connection to a bridge, as a port of `SerialLink` (`socket://`).

- **Every wait ends.** Resolving a name, connecting and writing have bounds; closing never waits.
- **All addresses count**, IPv6 and IPv4. The next one is tried soon, and not at once: a bridge that
  serves one client at a time may have both.
- **A connection that died without a word is replaced from the same local port.** Where the other
  end still holds it, another port would be a second client, which many bridges refuse. The same one
  makes the other end ask (challenge ACK, RFC 9293 3.10.7.4), this system deny (RST), and the
  repeated SYN succeed.
"""

from __future__ import annotations

import errno
import os
import select
import socket
import struct
import sys
import threading
import time
from contextlib import suppress
from typing import Any, Final

CONNECTING: Final = 2.0  # s
RESOLVING: Final = 3.0  # s
MOST_KEPT: Final = 256  # bytes that `first` and `last` keep

_NEXT_ADDRESS: Final = 0.3  # s until the next address is tried too
_USER_TIMEOUT: Final = 10_000  # ms without an acknowledgement; whoever asks has given up by then
_KEEPALIVE: Final = {"TCP_KEEPIDLE": 10, "TCP_KEEPALIVE": 10, "TCP_KEEPINTVL": 5, "TCP_KEEPCNT": 3}
# SO_LINGER: RST, and nothing of the connection stays here. Windows has two shorts.
_AT_ONCE: Final = struct.pack("hh" if sys.platform == "win32" else "ii", 1, 0)
_PORT_IN_USE: Final = {errno.EADDRINUSE, errno.EADDRNOTAVAIL, errno.EINVAL, errno.EACCES}
_ENDED_SOON: Final = {errno.ECONNRESET, errno.ECONNABORTED, errno.ENOTCONN, errno.EPIPE}
_UNDER_WAY: Final = {0, errno.EINPROGRESS, errno.EWOULDBLOCK, errno.EALREADY}

Place = tuple[str, int]
_Address = tuple[Any, ...]
_Info = tuple[socket.AddressFamily, _Address]

_known: dict[Place, list[_Info]] = {}
"""The addresses of the latest success, for a name that is not resolved without the network."""

_given_up: dict[_Address, _Address] = {}
"""The local end of a connection that the other end, by its address, may still hold."""


class ConnectionEnded(ConnectionError):
    """The other end has closed the connection."""


class WriteTimeout(TimeoutError):
    """The other end takes no more bytes."""


class RawTcpPort:
    """A connection. Its calls raise `OSError`.

    `patience`: seconds that a write may wait. `first`, `last`: bytes that came since connecting.
    `telnet`: whether they are free of Telnet's own. `number`: of the port there. `ended_there`:
    whether the other end has closed the connection, or reset it at once.
    """

    timeout = 0  # the system can wait on `fileno`
    telnet = False
    can_break = False
    break_condition: bool = False
    baudrate: int = 0  # the other end has the port
    _socket: socket.socket

    def __init__(self, *, patience: float) -> None:
        self.first: bytes = b""
        self.last: bytes = b""
        self.number: int = 0
        self._patience = patience
        self.ended_there: bool = False

    def open(self, place: Place) -> None:
        """Connect."""
        self.number = place[1]
        try:
            self._socket, there = _connected(place)
        except OSError as error:
            self.ended_there = error.errno in _ENDED_SOON
            raise
        self._ends = there, self._socket.getsockname()

    def fileno(self) -> int:
        return self._socket.fileno()

    def read(self, size: int) -> bytes:
        """Return what has arrived, at most `size` bytes, without waiting."""
        data = self._receive(size)
        self._note(data)
        return data

    def write(self, data: bytes) -> int:
        """Send all of `data`, unless the other end has closed: that would be lost unnoticed."""
        if self._closed_there():
            raise ConnectionEnded(errno.ECONNRESET, "closed by the other end")
        self._send(data)
        return len(data)

    def close(self) -> None:
        """Close at once, however the other end behaves."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)  # ends a wait of another thread
        self._socket.close()

    def give_up(self) -> None:
        """Close a connection whose other end may not learn of it; the next one replaces it."""
        if not self.ended_there:
            there, here = self._ends
            _given_up[there] = here
            with suppress(OSError):
                self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _AT_ONCE)
        # Without `shutdown`, which would send FIN and wait for its acknowledgement.
        self._socket.close()

    def _note(self, data: bytes) -> None:
        if len(self.first) < MOST_KEPT:
            self.first += data[: MOST_KEPT - len(self.first)]
        self.last = (self.last + data)[-MOST_KEPT:]

    def _receive(self, size: int) -> bytes:
        try:
            data = self._socket.recv(size)
        except BlockingIOError:
            return b""
        except ConnectionError:
            self.ended_there = True
            raise
        if not data:
            self.ended_there = True
            raise ConnectionEnded(errno.ECONNRESET, "closed by the other end")
        return data

    def _send(self, data: bytes) -> None:
        until = time.monotonic() + self._patience
        left = memoryview(data)
        while left:
            try:
                left = left[self._socket.send(left) :]
            except BlockingIOError:
                if (seconds := until - time.monotonic()) <= 0:
                    raise WriteTimeout("write timeout") from None
                select.select([], [self._socket], [], seconds)
            except ConnectionError:
                self.ended_there = True
                with suppress(OSError):  # the end of the connection follows what came before it
                    while True:
                        self.read(MOST_KEPT)
                raise

    def _closed_there(self) -> bool:
        try:
            self.ended_there = not self._socket.recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return False
        except ConnectionError:
            self.ended_there = True
        return self.ended_there


def _connected(place: Place) -> tuple[socket.socket, _Address]:
    """Return a connection to one of the addresses of `place`, and which. Raises `OSError`."""
    infos = _resolved(place)
    attempts = _Attempts(time.monotonic() + CONNECTING)
    try:
        for info in infos:
            attempts.begin(*info)
            if connected := attempts.wait(_NEXT_ADDRESS):
                break
        else:
            connected = attempts.wait(CONNECTING)
        if connected is None:
            raise attempts.error or TimeoutError(errno.ETIMEDOUT, "timed out")
    finally:
        attempts.close()
    try:
        _set_options(connected)
        there = connected.getpeername()
        _given_up.pop(there, None)
    except BaseException:
        connected.close()
        raise
    _known[place] = infos
    return connected, there


class _Attempts:
    """Connections that are being made, until one of them is."""

    def __init__(self, until: float) -> None:
        self.error: OSError | None = None
        self._until = until
        self._waiting: list[socket.socket] = []

    def begin(self, family: socket.AddressFamily, address: _Address) -> None:
        """Begin to connect, from the local end of a connection that this one replaces."""
        local = _given_up.get(address)
        code = self._begin(family, address, local)
        if code in _PORT_IN_USE and local is not None:
            code = self._begin(family, address, None)
        if code:
            self._failed(code)

    def _begin(
        self, family: socket.AddressFamily, address: _Address, local: _Address | None
    ) -> int:
        """Return the number of the error, or 0."""
        sock = None
        try:
            sock = socket.socket(family, socket.SOCK_STREAM)
            sock.setblocking(False)
            if local is not None:
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                sock.bind(local)
            code = sock.connect_ex(address)
        except OSError as error:
            code = error.errno or errno.EINVAL
        if sock is not None and code in _UNDER_WAY:
            self._waiting.append(sock)
            return 0
        if sock is not None:
            sock.close()
        return code

    def wait(self, seconds: float) -> socket.socket | None:
        """Return the first connection that is made in so many seconds."""
        until = min(time.monotonic() + seconds, self._until)
        while self._waiting and (left := until - time.monotonic()) > 0:
            # Windows shows a failed attempt as an exceptional condition.
            _, ready, failed = select.select([], self._waiting, self._waiting, left)
            for sock in {*ready, *failed}:
                self._waiting.remove(sock)
                code = sock.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
                if not code:
                    return sock
                sock.close()
                self._failed(code)
        return None

    def close(self) -> None:
        for sock in self._waiting:
            sock.close()

    def _failed(self, code: int) -> None:
        self.error = self.error or OSError(code, os.strerror(code))


def _set_options(sock: socket.socket) -> None:
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in {**_KEEPALIVE, "TCP_USER_TIMEOUT": _USER_TIMEOUT}.items():
        if (option := getattr(socket, name, None)) is not None:
            with suppress(OSError):  # not every system that names it has it
                sock.setsockopt(socket.IPPROTO_TCP, option, value)


def _resolved(place: Place) -> list[_Info]:
    """Return the addresses of a name, or those of the latest connection. Raises `OSError`.

    The system gives no bound to a resolver without its network, so a thread asks.
    """
    with suppress(OSError):
        return _asked(place, socket.AI_NUMERICHOST)
    answer: list[list[_Info] | Exception] = []

    def ask() -> None:
        try:
            answer.append(_asked(place))
        except Exception as error:  # any: a thread that fails would print it
            answer.append(error)

    thread = threading.Thread(target=ask, daemon=True)
    thread.start()
    thread.join(RESOLVING)
    match answer:
        case [list() as infos]:
            return infos
    if place in _known:
        return _known[place]
    match answer:
        case [Exception() as error]:
            raise error
    raise socket.gaierror(socket.EAI_AGAIN, "the name was not resolved in time")


def _asked(place: Place, flags: int = 0) -> list[_Info]:
    found = socket.getaddrinfo(*place, type=socket.SOCK_STREAM, flags=flags)
    return [(family, address) for family, _, _, _, address in found]
