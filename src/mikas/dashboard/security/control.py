"""The controller's seat: one client at a time decides what the line does, the others watch.

The seat is taken by asking for it while it is free, and is free again when its holder has been away
for a while: 15 s after the last WebSocket was closed (a reload, a lid that was shut for a moment),
60 s after the last request of a client that never had one (a script). A page's request that comes
when its WebSocket is gone counts as the former: the page is reloaded, or was closed. A request that
was not understood or not allowed is taken back: it was no use of the seat. Looking (`take` False)
needs a seat that is free or one's own, and does not take it.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from mikas.dashboard.errors import NotAllowed, NotController

AFTER_SOCKET = 15.0
AFTER_REQUEST = 60.0
_REMEMBERED = 100  # pages that are gone


@dataclass(frozen=True, slots=True)
class Client:
    """Who asks. `may_control`: whether it may take the seat at all."""

    id: str
    name: str
    may_control: bool


@dataclass(frozen=True, slots=True)
class Before:
    """How the seat was before a request."""

    request: int
    holder: Client | None
    until: float


class Seat:
    """Who holds it. `clock` gives seconds that never run back; any thread may ask. `changed` is
    called whenever somebody else holds it than before, nobody among them.
    """

    def __init__(
        self, clock: Callable[[], float], changed: Callable[[], object] = lambda: None
    ) -> None:
        self._clock = clock
        self._changed = changed
        self._requests = 0
        self._lock = threading.Lock()
        self._holder: Client | None = None
        self._until = 0.0  # for a holder without a socket
        self._sockets: dict[str, int] = {}
        self._left: deque[str] = deque(maxlen=_REMEMBERED)

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

    def demand(self, client: Client, *, force: bool = False, take: bool = True) -> Before:
        """Lets the holder pass; gives a free seat, or with `force` any. For `take_back`. Without
        `take` a free seat stays free, and `client` may pass.

        Raises `NotAllowed`, `NotController`.
        """
        if not client.may_control:
            raise NotAllowed
        with self._lock:
            held = self._held()
            if held is not None and held.id != client.id and not force:
                raise NotController(holder=held.name or held.id)
            if held is None and not take:
                return Before(self._requests, held, self._until)
            self._requests += 1
            before = Before(self._requests, held, self._until)
            self._give(client)
            after = AFTER_SOCKET if client.id in self._left else AFTER_REQUEST
            self._until = self._clock() + after
            return before

    def take_back(self, before: Before) -> None:
        """That request counts for nothing, unless another came behind it."""
        with self._lock:
            if before.request == self._requests:
                self._give(before.holder)
                self._until = before.until

    def release(self, client: Client) -> None:
        """Frees the seat, if `client` holds it."""
        with self._lock:
            if self._holder is not None and self._holder.id == client.id:
                self._give(None)

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
                return
            self._left.append(client.id)
            if self._holder is not None and self._holder.id == client.id:
                self._until = self._clock() + AFTER_SOCKET

    def _held(self) -> Client | None:
        holder = self._holder
        if holder is not None and holder.id not in self._sockets and self._clock() >= self._until:
            holder = None
            self._give(None)
        return holder

    def _give(self, client: Client | None) -> None:
        before, self._holder = self._holder, client
        if (before and before.id) != (client and client.id):
            self._changed()
