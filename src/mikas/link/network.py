"""pyserial's network ports, with five defects of version 3.5 corrected.

Both kinds sleep 0.3 s in `close`, leave their socket open if the other end closed first, and accept
a write to a closed connection. `socket://` also delays small writes (Nagle), up to 40 ms a request.
`rfc2217://` reads all that comes into memory, however fast and whether it is used or not.
"""

from __future__ import annotations

import queue
import socket
import sys
import threading
import warnings
from contextlib import suppress
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from serial import SerialException, SerialTimeoutException, rfc2217
from serial.urlhandler import protocol_socket

from mikas.errors import BadPortUrl
from mikas.i18n import Text
from mikas.link.urls import parse

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

_MOST_UNREAD = 1 << 14  # bytes that the reader thread keeps; more waits at the far end
_PATIENCE = 7.0  # seconds for pyserial's reader thread to end; its own socket time-out is 5


class SocketPort(protocol_socket.Serial):
    """Plain TCP (`socket://`): no baud rate, no control lines, no break. Connects within 5 s."""

    _socket: socket.socket | None = None

    def open(self) -> None:
        """Connect. Raises `SerialException`."""
        try:
            super().open()
            if self._socket is not None:
                self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        except BaseException:
            self.close()
            raise

    def write(self, b: ReadableBuffer, /) -> int | None:
        """Send, or raise if the other end has closed: the first bytes would be lost unnoticed."""
        if self._closed_remotely():
            raise SerialException("socket disconnected")
        return super().write(b)

    def close(self) -> None:
        """Close at once."""
        self.is_open = False
        sock, self._socket = self._socket, None
        if sock is not None:
            with suppress(OSError):
                sock.shutdown(socket.SHUT_RDWR)
            sock.close()

    def _closed_remotely(self) -> bool:
        try:
            return self._socket is None or not self._socket.recv(1, socket.MSG_PEEK)
        except BlockingIOError:
            return False
        except OSError:
            return True


class Rfc2217Port(rfc2217.Serial):
    """A port of a terminal server, with baud rate, control lines and break (`rfc2217://`)."""

    _socket: socket.socket | None
    _thread: threading.Thread | None
    _unread: queue.Queue[bytes | None] | None = None

    def open(self) -> None:
        """Connect and agree on the settings. Raises `SerialException`, `ValueError`."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # 3.5 still calls Thread.setDaemon
            super().open()

    @property
    def _read_buffer(self) -> queue.Queue[bytes | None] | None:
        """The bytes that the reader thread has received, each by itself."""
        return self._unread

    @_read_buffer.setter
    def _read_buffer(self, created: queue.Queue[bytes | None] | None) -> None:
        """Bound the queue that pyserial has created: its reader thread waits for room."""
        if created is not None:
            created.maxsize = _MOST_UNREAD
        self._unread = created

    def write(self, b: ReadableBuffer, /) -> int | None:
        """Send, unless the reader thread has met the end of the connection."""
        if self._thread is None or not self._thread.is_alive():
            raise SerialException("socket disconnected")
        try:
            return super().write(b)
        except SerialException as error:
            if isinstance(error.__context__, TimeoutError):
                raise SerialTimeoutException("write timeout") from error
            raise

    def close(self) -> None:
        """Close as soon as the reader has ended."""
        self.is_open = False
        if self._socket is not None:
            with suppress(OSError):
                self._socket.shutdown(socket.SHUT_RDWR)  # which ends the reader
        thread, self._thread = self._thread, None
        if self._unread is not None:
            self._make_room(self._unread)
        if thread is not None:
            thread.join(_PATIENCE)
        sock, self._socket = self._socket, None
        if sock is not None:
            sock.close()

    @staticmethod
    def _make_room(unread: queue.Queue[bytes | None]) -> None:
        """Let the reader thread put down all that it holds, so that it can end."""
        with unread.mutex:
            unread.maxsize = sys.maxsize  # 0 would not end a `put` that waits already
            unread.not_full.notify_all()


def host_and_port(url: str) -> str:
    """Return the `host:port` of a network URL, an IPv6 host in brackets. Raises `BadPortUrl`."""
    address = parse(url).address
    try:
        parts = urlsplit(f"//{address}")
        host, port = parts.hostname, parts.port
    except ValueError:  # the port is not a number below 65536, or a bracket is open
        host, port = None, None
    if not host or not port or parts.path or "@" in address:
        scheme = parse(url).scheme
        problem = Text(
            f"it needs a host and a port number, as in {scheme}://192.168.0.5:4001",
            f"нужны адрес и номер порта, например {scheme}://192.168.0.5:4001",
        )
        raise BadPortUrl(url=url, problem=problem)
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
