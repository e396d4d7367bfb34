"""What the gate of the client lets pass: the sampler's own lists, and just what was confirmed.

A change is made as a job in the sampling thread, inside `given`. The gate asks at the last moment,
with what it has just read; if that is no longer what the person saw, nothing is sent.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from mikas.client import Change
from mikas.commands import Safety
from mikas.dashboard.errors import ConfirmationOutdated


class Approval:
    """Belongs to the sampling thread."""

    def __init__(self) -> None:
        self._before: str | None = None
        self._in_force = False

    @contextmanager
    def given(self, before: str | None) -> Iterator[None]:
        """In force for the one change made inside; `before` is what was shown, in spaced hex."""
        self._before, self._in_force = before, True
        try:
            yield
        finally:
            self._in_force = False

    def confirm(self, change: Change) -> bool:
        """The gate's question. Raises `ConfirmationOutdated`."""
        if not self._in_force:
            return change.safety <= Safety.REVERSIBLE
        if change.before != self._before:
            raise ConfirmationOutdated
        return True
