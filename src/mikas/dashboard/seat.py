"""The controller's seat: one client at a time decides what the line does, the others watch.

The seat is taken by asking for it while it is free, and is free again when its holder has been away
for a while: 15 s after the last WebSocket was closed (a reload, a lid that was shut for a moment),
60 s after the last request of a client that has none (a script).
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

from mikas.dashboard.refusals import NotAllowed, NotController

AFTER_SOCKET = 15.0
AFTER_REQUEST = 60.0


@dataclass(frozen=True, slots=True)
class Client:
    """Who asks. `may_control`: whether it may take the seat at all."""

    id: str
    name: str
    may_control: bool


class Seat:
    """Who holds it. `clock` gives seconds that never run back; any thread may ask."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._holder: Client | None = None
        self._until = 0.0  # for a holder without a socket
        self._sockets: dict[str, int] = {}

    @property
    def holder(self) -> Client | None:
        """Who decides now; None: the seat is free."""
        with self._lock:
            return self._held()

    @property
    def viewers(self) -> int:
        """How many clients look on, the holder included."""
        with self._lock:
            return len(self._sockets)

    def demand(self, client: Client, *, force: bool = False) -> None:
        """Lets the holder pass; gives a free seat, or with `force` any.

        Raises `NotAllowed`, `NotController`.
        """
        if not client.may_control:
            raise NotAllowed
        with self._lock:
            held = self._held()
            if held is not None and held.id != client.id and not force:
                raise NotController(holder=held.name or held.id)
            self._holder = client
            self._until = self._clock() + AFTER_REQUEST

    def release(self, client: Client) -> None:
        """Frees the seat, if `client` holds it."""
        with self._lock:
            if self._holder is not None and self._holder.id == client.id:
                self._holder = None

    def opened(self, client: Client) -> None:
        """`client` has one WebSocket more."""
        with self._lock:
            self._sockets[client.id] = self._sockets.get(client.id, 0) + 1

    def closed(self, client: Client) -> None:
        """`client` has one WebSocket less."""
        with self._lock:
            left = self._sockets.pop(client.id) - 1
            if left:
                self._sockets[client.id] = left
            elif self._holder is not None and self._holder.id == client.id:
                self._until = self._clock() + AFTER_SOCKET

    def _held(self) -> Client | None:
        holder = self._holder
        if holder is not None and holder.id not in self._sockets and self._clock() >= self._until:
            self._holder = holder = None
        return holder
