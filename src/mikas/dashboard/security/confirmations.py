"""Confirmations: what was shown to a person, kept until that person says yes, once.

A nonce is bound to its client, to what was shown, and to the unit that was there; it lasts two
minutes. It is used up by the attempt, whatever becomes of it.
"""

from __future__ import annotations

import secrets
import threading
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import Any

from mikas.dashboard.errors import NonceUnknown
from mikas.dashboard.security.control import Client
from mikas.i18n import Text

LIFETIME = 120.0
_MOST = 100
FOR_GOOD = Text(
    "The file is removed for good. Download it first if it may be needed.",
    "Файл удаляется насовсем. Если он может понадобиться, сначала скачайте его.",
)
"""What deleting a file means."""


@dataclass(frozen=True, slots=True)
class Prepared:
    """A change, ready to be confirmed. `make` does it, and returns what was there and is there now.

    `make` looks once more whether `before` still stands, and raises `ConfirmationOutdated` if not.
    `lost`: what is gone afterwards, as texts or JSON; `needs_unlock`: only while writing is
    unlocked.
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
    prepared: Prepared


@dataclass(slots=True)
class Nonces:
    """Any thread may ask. `clock`: seconds that never run back."""

    clock: Callable[[], float]
    _kept: dict[str, _Kept] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def keep(self, client: Client, prepared: Prepared) -> str:
        """The nonce that confirms `prepared`."""
        nonce = secrets.token_urlsafe(16)
        with self._lock:
            now = self.clock()
            self._kept = {key: it for key, it in self._kept.items() if it.until > now}
            while len(self._kept) >= _MOST:
                del self._kept[next(iter(self._kept))]
            self._kept[nonce] = _Kept(client.id, now + LIFETIME, prepared)
        return nonce

    def use(self, client: Client, nonce: str) -> Prepared:
        """What it confirms, once. Raises `NonceUnknown`."""
        with self._lock:
            kept = self._kept.get(nonce)
            if kept is None or kept.client != client.id:
                raise NonceUnknown
            del self._kept[nonce]
            if self.clock() >= kept.until:
                raise NonceUnknown
        return kept.prepared

    def clear(self) -> None:
        """Another unit, or none: nothing that was shown is to be confirmed any more."""
        with self._lock:
            self._kept.clear()
