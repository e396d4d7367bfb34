"""The server's TCP connections: how many there are, of whom, and how long one may wait.

A connection counts from the moment it is accepted until its socket is closed, also during a TLS
handshake. A full server makes room: it drops the connection that has waited longest for its
client, so half-open ones never keep anyone out. Only if all are at work is a new one refused.
Some places are kept for this computer, and each address in the network has a limit of its own.

    waits for a request, or for TLS and a request    10 s
    waits for the rest of a request's body           30 s
    at work, or a WebSocket                          no limit here
    the client takes none of what was sent           30 s, in each of these

`sweep` ends what has waited too long; the server calls it every second. All of it runs in the event
loop. `clock`: seconds that never run back.
"""

from __future__ import annotations

import asyncio
import errno
import os
import socket
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from typing import Final

from mikas.dashboard.listening import ListeningSocket, is_loopback

HEAD_SECONDS: Final = 10.0
BODY_SECONDS: Final = 30.0
STALL_SECONDS: Final = 30.0
MAX_TOTAL: Final = 256
MAX_NEW: Final = 50  # of an address in the network, each second
_MIN_TOTAL = 64
_OTHER_FILES = 256  # descriptors of recordings, exports, ports, and of connections being closed
_DESCRIPTORS = 1024  # more would not do: pyserial waits by select()
_REFUSED_AT_ONCE = 64
_EXHAUSTED = (errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM)


class TcpPhase(Enum):
    """What a connection waits for."""

    REQUEST = HEAD_SECONDS
    BODY = BODY_SECONDS
    NOTHING = None


@dataclass(frozen=True, slots=True)
class TcpLimits:
    """Connections at once: of all, those of them kept for this computer, of another address."""

    total: int = MAX_TOTAL

    @property
    def kept(self) -> int:
        """The connections that only this computer may have."""
        return self.total // 4

    @property
    def each(self) -> int:
        """The connections of one address in the network."""
        return self.total // 8

    @classmethod
    def of_this_process(cls) -> TcpLimits:
        """Return the limits that the system's limit of open files allows."""
        return cls(max(_MIN_TOTAL, min(MAX_TOTAL, _descriptors() - _OTHER_FILES)))


class TcpConnection:
    """An accepted connection. `address`: of an address in the network; None: of this computer."""

    __slots__ = ("_drop", "_moved", "_transport", "_unsent", "address", "phase", "since")

    def __init__(self, address: str | None, drop: Callable[[], object], now: float) -> None:
        self.address = address
        self.phase = TcpPhase.REQUEST
        self._drop: Callable[[], object] | None = drop
        self._transport: asyncio.Transport | None = None
        self.since = self._moved = now
        self._unsent = 0

    def attach(self, transport: asyncio.Transport) -> None:
        """Set the transport, once there is one; for TLS after the handshake."""
        self._transport = transport
        if self._drop is not None:
            self._drop = transport.abort

    def enter(self, phase: TcpPhase, now: float) -> None:
        """Set the phase; its time begins, unless it is the present one."""
        if phase is not self.phase:
            self.phase, self.since = phase, now

    @property
    def unsent(self) -> int:
        """Bytes that the client has not taken; the system's own buffer is not counted."""
        return self._transport.get_write_buffer_size() if self._transport else 0

    @property
    def dropped(self) -> bool:
        """Whether it was dropped; its socket may still be open for a moment."""
        return self._drop is None

    @property
    def waits(self) -> bool:
        """Whether it has waited for its client since `since`, and may be dropped for another."""
        return not self.dropped and self.phase is not TcpPhase.NOTHING and not self.unsent

    def is_late(self, now: float) -> bool:
        """Return whether the client has kept the server waiting for too long."""
        before, self._unsent = self._unsent, self.unsent
        if not before or self._unsent < before:
            self._moved = now
        if self._unsent:
            self.since = now  # the client is still taking the last response
            return now - self._moved >= STALL_SECONDS
        return self.phase.value is not None and now - self.since >= self.phase.value

    def drop(self) -> None:
        """End the connection at once."""
        drop, self._drop = self._drop, None
        if drop is not None:
            with suppress(OSError):  # the client has gone already
                drop()


class TcpConnections:
    """All connections of a server."""

    def __init__(self, limits: TcpLimits, clock: Callable[[], float]) -> None:
        self.limits = limits
        self.clock = clock
        self._open: dict[int, TcpConnection] = {}
        """By file descriptor."""
        self._new: Counter[str] = Counter()
        self._second = 0.0
        self._spare: int | None = None

    def __len__(self) -> int:
        """Return the number of connections whose sockets are open."""
        return len(self._open)

    def of(self, transport: asyncio.Transport) -> TcpConnection:
        """Return the connection of `transport`, and attach it."""
        own, peer = transport.get_extra_info("socket"), transport.get_extra_info("peername")
        connection = self._open.get(own.fileno()) if own is not None else None
        if connection is None:  # not accepted by a `ListeningSocket`
            connection = TcpConnection(_address(peer), transport.abort, self.clock())
        connection.attach(transport)
        return connection

    def accept(self, listening: ListeningSocket) -> tuple[socket.socket, object]:
        """Accept a connection. Raises `BlockingIOError` if none that may come in is waiting."""
        if self._spare is None:
            self._spare = _spare()
        for _ in range(_REFUSED_AT_ONCE):
            try:
                own, peer = listening.accept_any()
            except OSError as error:
                if not is_exhausted(error) or self._spare is None:
                    raise  # asyncio waits for a second
                self._refuse_by_spare(listening)
                continue
            accepted = _Accepted(own.family, own.type, own.proto, fileno=own.detach())
            if self.admit(accepted, _address(peer)):
                return accepted, peer
            accepted.close()
        raise BlockingIOError

    def admit(self, accepted: _Accepted, address: str | None) -> bool:
        """Return whether a new connection of `address` may come in, and count it."""
        now = self.clock()
        if address is not None and not (self._is_fair(address, now) and self._fits(address)):
            return False
        live = self._live()
        if len(live) >= self.limits.total:
            others = [it for it in live if it.address is not None]
            if not (self._make_room(others) or self._make_room(live)):
                return False
        number = accepted.fileno()
        self._open[number] = TcpConnection(
            address, lambda: accepted.shutdown(socket.SHUT_RDWR), now
        )
        accepted.left = lambda: self._open.pop(number, None)
        return True

    def sweep(self) -> None:
        """Drop the connections that have kept the server waiting for too long."""
        now = self.clock()
        for connection in self._live():
            if connection.is_late(now):
                connection.drop()

    def _live(self) -> list[TcpConnection]:
        return [it for it in self._open.values() if not it.dropped]

    def _is_fair(self, address: str, now: float) -> bool:
        if now - self._second >= 1:
            self._new.clear()
            self._second = now
        self._new[address] += 1
        return self._new[address] <= MAX_NEW

    def _fits(self, address: str) -> bool:
        others = [it for it in self._live() if it.address is not None]
        same = [it for it in others if it.address == address]
        if len(same) >= self.limits.each:
            return self._make_room(same)
        return len(others) < self.limits.total - self.limits.kept or self._make_room(others)

    @staticmethod
    def _make_room(among: Iterable[TcpConnection]) -> bool:
        """Drop the one that has waited longest, of the address that has most; False: none waits."""
        waiting = [it for it in among if it.waits]
        if not waiting:
            return False
        many = Counter(it.address for it in waiting)
        min(waiting, key=lambda it: (-many[it.address], it.since)).drop()
        return True

    def _refuse_by_spare(self, listening: ListeningSocket) -> None:
        """Close one waiting connection, with no descriptor left but the spare one."""
        assert self._spare is not None
        self._make_room(self._live())
        os.close(self._spare)
        self._spare = None
        try:
            listening.accept_any()[0].close()
        finally:
            self._spare = _spare()


def is_exhausted(error: object) -> bool:
    """Return whether the system had no descriptor or memory for a connection."""
    return isinstance(error, OSError) and error.errno in _EXHAUSTED


class _Accepted(socket.socket):
    """A connection's socket; `left` is called when it is closed."""

    left: Callable[[], object] | None = None

    def close(self) -> None:
        """Close the socket, and count it no longer."""
        left, self.left = self.left, None
        if left is not None:
            left()
        super().close()


def _address(peer: object) -> str | None:
    address = str(peer[0]) if isinstance(peer, tuple) and peer else ""
    return None if is_loopback(address) else address


def _spare() -> int | None:
    try:
        return os.open(os.devnull, os.O_RDONLY)
    except OSError:
        return None


def _descriptors() -> int:
    """Return the number of files that this process may open, raised to 1024 if it is less."""
    try:
        import resource
    except ImportError:  # Windows, where sockets are no files
        return _DESCRIPTORS
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY:
        return _DESCRIPTORS
    wanted = _DESCRIPTORS if hard == resource.RLIM_INFINITY else min(_DESCRIPTORS, hard)
    if soft < wanted:
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
            soft = wanted
    return soft
