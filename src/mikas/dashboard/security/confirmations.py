"""Safeguards of changes: confirmations, the lock on writing, the approval of one change.

A change that was shown to a person is kept until that person confirms it by its nonce, once. A
nonce is bound to its client, to the content shown and to the present unit; it lasts two minutes,
and the attempt uses it up, whatever its result. The lock on memory and parameters is open for some
minutes, on one connection, for the client that opened it, while that has control. The approval
lets the client library's gate pass exactly the confirmed change, and the sampler's own reversible
ones.
"""

from __future__ import annotations

import secrets
import threading
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final

from mikas.client import Change
from mikas.commands import Safety
from mikas.dashboard.errors import ConfirmationExpired, ConfirmationOutdated, Locked
from mikas.dashboard.security.control import Client
from mikas.i18n import Text

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
            raise ConfirmationExpired
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
            raise Locked

    @property
    def left(self) -> float | None:
        """Seconds until the lock closes automatically; None: it is closed."""
        until = self._until
        left = 0.0 if until is None else until - self.clock()
        return left if left > 0 else None


class WriteApproval:
    """Belongs to the sampling thread, where changes are made as jobs inside `given`.

    The gate asks last, with the content that it has just read. If that content differs from the
    one shown, nothing is sent.
    """

    def __init__(self) -> None:
        self._before: str | None = None
        self._in_force = False

    @contextmanager
    def given(self, before: str | None) -> Iterator[None]:
        """Approve the one change made inside; `before`: the content shown, in spaced hex."""
        self._before, self._in_force = before, True
        try:
            yield
        finally:
            self._in_force = False

    def confirm(self, change: Change) -> bool:
        """Answer the gate's question. Raises `ConfirmationOutdated`."""
        if not self._in_force:
            return change.safety <= Safety.REVERSIBLE
        if change.before != self._before:
            raise ConfirmationOutdated
        return True
