"""A client that is known byte by byte: its TLS is its own, so it can end in the middle of it."""

from __future__ import annotations

import select
import socket
import ssl
import struct
from contextlib import suppress
from enum import Enum, auto
from typing import Final

_PATIENCE: Final = 60.0  # s; a server that takes longer hangs
_MOMENT: Final = 0.05  # s without a byte taken, after which no more is poured
_PIECE: Final = 1 << 16
_LINGER: Final = struct.pack("ii", 1, 0)

TEXT: Final = 1
BINARY: Final = 2
CLOSE: Final = 8
PING: Final = 9


class Stuck(AssertionError):
    """The server neither responds nor closes the connection."""


class Cut(Exception):
    """The client has sent as many bytes as it was to send."""


class End(Enum):
    """How a client goes. HALF and SILENT keep their socket."""

    GOODBYE = auto()
    """TLS is ended, then TCP."""
    ABRUPT = auto()
    RESET = auto()
    HALF = auto()
    SILENT = auto()


class Caller:
    """A connection. `context`: None for plain TCP. `budget`: the bytes after which it is `Cut`."""

    def __init__(
        self, own: socket.socket, context: ssl.SSLContext | None, budget: int | None = None
    ) -> None:
        self.own, self.budget, self.sent = own, budget, 0
        own.settimeout(_PATIENCE)
        self._incoming, self._outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
        self._tls: ssl.SSLObject | None = None
        if context is not None:
            self._tls = context.wrap_bio(self._incoming, self._outgoing, server_hostname="garage")

    def shake_hands(self) -> None:
        """Begin TLS, if it is used."""
        while self._tls is not None:
            try:
                self._tls.do_handshake()
            except ssl.SSLWantReadError:
                self._flush()
                self._fill()
            else:
                self._flush()
                return

    def send(self, data: bytes) -> None:
        """Send all."""
        if self._tls is None:
            self.send_raw(data)
        else:
            self._tls.write(data)
            self._flush()

    def send_raw(self, data: bytes) -> None:
        """Send bytes that TLS does not make."""
        if self.budget is not None:
            data = data[: self.budget - self.sent]
        try:
            self.own.sendall(data)
        except TimeoutError:
            raise Stuck(f"{len(data)} bytes were not taken") from None
        self.sent += len(data)
        if self.sent == self.budget:
            raise Cut

    def pour(self, data: bytes, times: int) -> None:
        """Send `data` so often, or until the server takes no more of it."""
        for _ in range(times):
            if not select.select([], [self.own], [], _MOMENT)[1]:
                return
            self.send(data)

    def read(self) -> bytes:
        """Return some bytes; none: the server has ended."""
        while True:
            if self._tls is None:
                return self._receive()
            with suppress(ssl.SSLWantReadError):
                return self._tls.read(_PIECE)
            self._fill()

    def read_until(self, wanted: bytes) -> bytes:
        """Return what comes until `wanted` is in it, or until the end."""
        got = b""
        while wanted not in got and (piece := self.read()):
            got += piece
        return got

    def read_to_end(self) -> bytes:
        """Return all until the server ends."""
        got = b""
        with suppress(ConnectionError, ssl.SSLError):
            while piece := self.read():
                got += piece
        return got

    def leave(self, how: End) -> None:
        """Go."""
        with suppress(OSError, Cut):
            if how is End.GOODBYE:
                self.say_goodbye()
            elif how is End.RESET:
                self.own.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _LINGER)
            elif how is End.HALF:
                self.own.shutdown(socket.SHUT_WR)
        if how not in (End.HALF, End.SILENT):
            self.own.close()

    def say_goodbye(self) -> None:
        """End TLS on this side; the socket stays open."""
        if self._tls is not None:
            with suppress(ssl.SSLError):
                self._tls.unwrap()
            self._flush()

    def _flush(self) -> None:
        if data := self._outgoing.read():
            self.send_raw(data)

    def _fill(self) -> None:
        if data := self._receive():
            self._incoming.write(data)
        else:
            self._incoming.write_eof()

    def _receive(self) -> bytes:
        try:
            return self.own.recv(_PIECE)
        except TimeoutError:
            raise Stuck("no byte came, and no end") from None


def frame(kind: int, payload: bytes = b"", *, final: bool = True, masked: bool = True) -> bytes:
    """Return a WebSocket frame of a client."""
    length, mask = len(payload), 0x80 * masked
    if length < 126:
        size = bytes([mask | length])
    elif length < 1 << 16:
        size = bytes([mask | 126]) + length.to_bytes(2, "big")
    else:
        size = bytes([mask | 127]) + length.to_bytes(8, "big")
    return bytes([0x80 * final | kind]) + size + bytes(4 * masked) + payload
