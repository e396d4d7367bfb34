"""The two guards of changes: the lock on writing, and the approval of one confirmed change.

The lock on memory and parameters is open for some minutes, on one connection, for the client that
opened it: it closes when control changes hands. The approval lets the client library's gate pass
exactly the change that was confirmed, and the sampler's own reversible ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from mikas.client import Change
from mikas.commands import Safety
from mikas.dashboard.errors import ConfirmationOutdated


@dataclass(slots=True)
class WriteLock:
    """`clock`: seconds that never run back."""

    clock: Callable[[], float]
    _until: float | None = None

    def open(self, seconds: float) -> None:
        """Unlock writing for `seconds`."""
        self._until = self.clock() + seconds

    def close(self) -> None:
        """Lock writing."""
        self._until = None

    @property
    def left(self) -> float | None:
        """Seconds until the lock closes automatically; None: it is closed."""
        until = self._until
        left = 0.0 if until is None else until - self.clock()
        return left if left > 0 else None


class WriteApproval:
    """Belongs to the sampling thread, where changes are made as jobs inside `given`.

    The gate asks at the last moment, with the content that it has just read. If that is no longer
    the content that the person saw, nothing is sent.
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
