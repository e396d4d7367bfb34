"""Confirmations: changes that were shown to a person, kept until that person confirms them, once.

A nonce is bound to its client, to the content shown and to the unit of that moment; it lasts two
minutes. The attempt uses it up, whatever its result.
"""

from __future__ import annotations

import secrets
import threading
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any, Final

from mikas.dashboard.errors import ConfirmationExpired
from mikas.dashboard.security.control import Client
from mikas.i18n import Text

LIFETIME: Final = 120.0
_MAX_KEPT: Final = 100


@dataclass(frozen=True, slots=True)
class PendingChange:
    """A change, ready to be confirmed. `make` makes it, and returns the content before and after.

    `make` checks once more whether `before` still holds, and raises `ConfirmationOutdated` if not.
    `lost`: what the change destroys, as JSON; `needs_unlock`: only while writing is unlocked.
    """

    what: Text
    before: Any
    after: Any
    make: Callable[[], Awaitable[dict[str, Any]]]
    danger: bool = False
    lost: tuple[Any, ...] = ()
    meaning: Text | None = None
    needs_unlock: bool = False


@dataclass(frozen=True, slots=True)
class _Kept:
    client: str
    until: float
    change: PendingChange


@dataclass(slots=True)
class ConfirmationStore:
    """Pending changes by nonce. Any thread may call. `clock`: seconds that never run back."""

    clock: Callable[[], float]
    _kept: dict[str, _Kept] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def keep(self, client: Client, change: PendingChange) -> str:
        """Keep `change` and return the nonce that confirms it."""
        nonce = secrets.token_urlsafe(16)
        with self._lock:
            now = self.clock()
            self._kept = {key: kept for key, kept in self._kept.items() if kept.until > now}
            while len(self._kept) >= _MAX_KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[nonce] = _Kept(client.id, now + LIFETIME, change)
        return nonce

    def use(self, client: Client, nonce: str) -> PendingChange:
        """Return the change that `nonce` confirms, once. Raises `ConfirmationExpired`."""
        with self._lock:
            kept = self._kept.get(nonce)
            if kept is None or kept.client != client.id:
                raise ConfirmationExpired
            del self._kept[nonce]
            if self.clock() >= kept.until:
                raise ConfirmationExpired
        return kept.change

    def clear(self) -> None:
        """Drop all: there is another unit, or none."""
        with self._lock:
            self._kept.clear()
