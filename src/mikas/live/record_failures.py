"""The failure of a recording: raised, or handed to a function, once."""

from __future__ import annotations

from collections.abc import Callable

from mikas.errors import CaptureError


class RecordFailures:
    """Calls `on_failure` with the failure of a recording, or raises it where there is none."""

    def __init__(self, on_failure: Callable[[CaptureError], object] | None) -> None:
        self._on_failure = on_failure
        self._reported: CaptureError | None = None

    def report(self, failure: CaptureError | None, *, again: bool = False) -> None:
        """Report a failure the first time that it is met. `again`: raise it each time."""
        if failure is None:
            return
        is_new = failure is not self._reported
        self._reported = failure
        if self._on_failure is None:
            if is_new or again:
                raise failure
        elif is_new:
            self._on_failure(failure)
