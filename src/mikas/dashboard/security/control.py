"""Who may change anything, and what: the control lease, confirmations, the lock on writing.

One client at a time controls the line, the others view. A client is known by its id, a secret that
it chose. The id itself is not kept: it is replaced by a digest with a key of this process, and what
others see of a client, the handle, is derived from that digest. So nothing that is shown, logged or
stored gives a client's rights to another.

A client takes the lease by a request while it is free. The lease is free again when its holder has
been away: 15 s after its page's WebSocket closed (a reload, a lid shut for a moment), 60 s after
the last request of a client that never had one (a script). Another page's WebSocket with the same
id does not keep the lease. A request of a page whose WebSocket is gone counts as the former: the
page is being reloaded, or was closed. An invalid or refused request is undone: it did not use the
lease. Viewing (`take` False) needs a lease that is free or one's own, and does not take it.

A change that was shown to a person is kept until that person confirms it by its nonce, once. A
nonce is bound to its client, to the content shown and to the present unit; it lasts two minutes,
and the attempt uses it up, whatever its result. The lock on memory and parameters is open for some
minutes, on one connection, for the client that opened it, while that has control. The approval
lets the client library's gate pass exactly the confirmed change, and the sampler's own reversible
ones.
"""

from __future__ import annotations

import hmac
import secrets
import threading
from collections import deque
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Final, Self

from mikas.client import Change
from mikas.commands import Safety
from mikas.dashboard import errors
from mikas.i18n import Text

AFTER_SOCKET = 15.0
AFTER_REQUEST = 60.0
Undo = Callable[[], None]
_MAX_GONE = 100  # clients without a WebSocket that are remembered
_KEY = secrets.token_bytes(32)
_HANDLE = 8  # hexadecimal digits


def _digest(text: str) -> str:
    return hmac.digest(_KEY, text.encode(), "sha256").hex()


@dataclass(frozen=True, slots=True)
class Client:
    """The sender of a request. `may_control`: whether it may take the lease at all.

    `id` distinguishes clients and is never shown; empty: a client without one.
    """

    id: str = field(repr=False)
    name: str
    may_control: bool
    local: bool = True
    """On this computer."""

    @classmethod
    def with_secret(cls, secret: str, name: str, *, may_control: bool, local: bool) -> Self:
        """Return the client with that secret; one in the network never is one on this computer."""
        return cls(_digest(f"{'here' if local else 'network'} {secret}"), name, may_control, local)

    @property
    def handle(self) -> str:
        """The mark of this client that others may see; new at each start."""
        return _digest(f"handle {self.id}")[:_HANDLE]


class ControlLease:
    """`clock`: seconds that never run back; `changed` is called when the holder changes.

    Any thread may call.
    """

    def __init__(
        self, clock: Callable[[], float], changed: Callable[[], object] = lambda: None
    ) -> None:
        self._clock = clock
        self._changed = changed
        self._requests = 0
        self._lock = threading.Lock()
        self._holder: Client | None = None
        self._page: str | None = None  # the holder's page, whose WebSocket keeps the lease
        self._until = 0.0  # for a holder without it
        self._sockets: dict[str, list[str]] = {}  # the pages of each client, one for each WebSocket
        self._gone: deque[str] = deque(maxlen=_MAX_GONE)

    @property
    def holder(self) -> Client | None:
        """The client in control; None: the lease is free."""
        with self._lock:
            return self._current()

    @property
    def viewers(self) -> int:
        """The number of clients with a WebSocket, the holder included."""
        with self._lock:
            return len(self._sockets)

    def demand(self, client: Client, *, force: bool = False, take: bool = True) -> Undo:
        """Check that `client` has control, or give it a free lease; with `force` any lease.

        Returns the function that undoes this, unless another request came after it. Without `take`
        a free lease stays free. Raises `NotAllowed`, `NotController`.
        """
        if not client.may_control:
            raise errors.NotAllowed
        with self._lock:
            holder = self._current()
            if holder is not None and holder.id != client.id and not force:
                raise errors.NotController(holder=holder.name or holder.handle)
            if holder is None and not take:
                return lambda: None
            self._requests += 1
            undo = partial(self._undo, self._requests, holder, self._page, self._until)
            self._give(client)
            pages = self._sockets.get(client.id, [])
            if pages and self._page is None:
                self._page = pages[0]
            after = AFTER_SOCKET if client.id in self._gone else AFTER_REQUEST
            self._until = self._clock() + after
            return undo

    def release(self, client: Client) -> None:
        """Free the lease, if `client` holds it."""
        with self._lock:
            if self._holder is not None and self._holder.id == client.id:
                self._give(None)

    def expel(self) -> None:
        """Free the lease, if a client in the network holds it."""
        with self._lock:
            if self._holder is not None and not self._holder.local:
                self._give(None)

    def socket_opened(self, client: Client, page: str) -> None:
        """Count one more WebSocket of `client`'s `page`."""
        with self._lock:
            self._sockets.setdefault(client.id, []).append(page)
            holder = self._current()
            if holder is not None and holder.id == client.id and self._page is None:
                self._page = page

    def socket_closed(self, client: Client, page: str) -> None:
        """Count one WebSocket of `client`'s `page` less."""
        with self._lock:
            pages = self._sockets[client.id]
            pages.remove(page)
            if not pages:
                del self._sockets[client.id]
                self._gone.append(client.id)
            holds = self._holder is not None and self._holder.id == client.id
            if holds and self._page == page and page not in pages:
                self._page = None
                self._until = self._clock() + AFTER_SOCKET

    def _undo(self, request: int, holder: Client | None, page: str | None, until: float) -> None:
        with self._lock:
            if request == self._requests:
                self._give(holder)
                open_pages = self._sockets.get(holder.id, []) if holder else []
                self._page = page if page in open_pages else None
                self._until = until

    def _current(self) -> Client | None:
        holder = self._holder
        if holder is not None and self._page is None and self._clock() >= self._until:
            holder = None
            self._give(None)
        return holder

    def _give(self, client: Client | None) -> None:
        before, self._holder = self._holder, client
        if (before and before.id) != (client and client.id):
            self._page = None
            self._changed()


LIFETIME: Final = 120.0
_MAX_KEPT: Final = 100


@dataclass(frozen=True, slots=True)
class FaultShown:
    """A stored fault that would be erased."""

    en: str
    ru: str
    code: int


@dataclass(frozen=True, slots=True)
class ValueShown:
    """A parameter's value. `raw`: hex."""

    value: bool | int | float
    unit: str
    raw: str


@dataclass(frozen=True, slots=True)
class RecordingShown:
    """A recording that would be deleted."""

    id: str
    bytes: int


@dataclass(frozen=True, slots=True)
class DumpShown:
    """A dump that would be deleted."""

    id: str
    file: str
    done: int
    total: int


Content = list[int] | ValueShown | RecordingShown | DumpShown | str | None
"""Of faults: their codes. Of memory: hex. None: not readable, or deleted."""


@dataclass(frozen=True, slots=True)
class PendingChange:
    """A change, ready to be confirmed. `make` makes it, and returns the content after it.

    `make` checks once more whether `before` still holds, and raises `ConfirmationOutdated` if not.
    `lost`: the destroyed content; `needs_unlock`: only while writing is unlocked.
    """

    what: Text
    before: Content
    after: Content
    make: Callable[[], Awaitable[Content]]
    danger: bool = False
    lost: tuple[FaultShown | RecordingShown | DumpShown, ...] = ()
    meaning: Text | None = None
    needs_unlock: bool = False


@dataclass(slots=True)
class ConfirmationStore:
    """Pending changes by nonce. Any thread may call. `clock`: seconds that never run back."""

    clock: Callable[[], float]
    _kept: dict[tuple[str, str], tuple[float, PendingChange]] = field(default_factory=dict)
    """The end and the change, by client and nonce."""
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def keep(self, client: Client, change: PendingChange) -> str:
        """Keep `change` and return the nonce that confirms it."""
        nonce = secrets.token_urlsafe(16)
        with self._lock:
            now = self.clock()
            self._kept = {key: kept for key, kept in self._kept.items() if kept[0] > now}
            while len(self._kept) >= _MAX_KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[client.id, nonce] = (now + LIFETIME, change)
        return nonce

    def use(self, client: Client, nonce: str) -> PendingChange:
        """Return the change that `nonce` confirms, once. Raises `ConfirmationExpired`."""
        with self._lock:
            until, change = self._kept.pop((client.id, nonce), (0.0, None))
        if change is None or self.clock() >= until:
            raise errors.ConfirmationExpired
        return change

    def clear(self) -> None:
        """Drop all; called when the unit is another one, or disconnected."""
        with self._lock:
            self._kept.clear()


@dataclass(slots=True)
class WriteLock:
    """`clock`: seconds that never run back. Closed whenever the control lease changes hands."""

    clock: Callable[[], float]
    _until: float | None = None
    _client: str = ""

    def open(self, client: Client, seconds: float) -> None:
        """Unlock writing by `client` for `seconds`."""
        self._client, self._until = client.id, self.clock() + seconds

    def close(self) -> None:
        """Lock writing."""
        self._until = None

    def check(self, client: Client) -> None:
        """Raise `Locked`, unless writing is unlocked for `client`."""
        if self.left is None or self._client != client.id:
            raise errors.Locked

    @property
    def left(self) -> float | None:
        """Seconds until the lock closes automatically; None: it is closed."""
        until = self._until
        left = 0.0 if until is None else until - self.clock()
        return left if left > 0 else None


class WriteApproval:
    """Belongs to the sampling thread, where changes are made as jobs inside `given`.

    The gate asks last, with the content that it has just read. If that content differs from the
    one shown, nothing is sent. A parameter is different: the running engine moves most of them
    all the time, so exactly the shown bytes are approved (`given_to`), whatever they replace.
    """

    def __init__(self) -> None:
        self._as_shown: Callable[[Change], bool] | None = None  # None: nothing is approved

    @contextmanager
    def given(self, before: str | None) -> Iterator[None]:
        """Approve the one change made inside; `before`: the content shown, in spaced hex."""
        with self._approved(lambda change: change.before == before):
            yield

    @contextmanager
    def given_to(self, name: str, after: str | None) -> Iterator[None]:
        """Approve writing `after`, in spaced hex, to the parameter `name`, made inside."""
        with self._approved(lambda change: (change.name, change.after) == (name, after)):
            yield

    @contextmanager
    def _approved(self, as_shown: Callable[[Change], bool]) -> Iterator[None]:
        self._as_shown = as_shown
        try:
            yield
        finally:
            self._as_shown = None

    def confirm(self, change: Change) -> bool:
        """Answer the gate's question. Raises `ConfirmationOutdated`."""
        if self._as_shown is None:
            return change.safety <= Safety.REVERSIBLE
        if not self._as_shown(change):
            raise errors.ConfirmationOutdated
        return True
