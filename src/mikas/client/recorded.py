"""The recording that `Ecu.record` returns. `mikas.live.recording` makes it: it stands above."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Final, Protocol, Self

from mikas.errors import CaptureError

_MAKER: Final = "mikas.live.recording"


class EcuRecording(ABC):
    """A running recording of one unit, to be closed; or used in a `with` statement."""

    @property
    @abstractmethod
    def path(self) -> Path:
        """The file."""

    @property
    @abstractmethod
    def bytes(self) -> int:
        """The size of the file, in whole blocks."""

    @property
    @abstractmethod
    def failure(self) -> CaptureError | None:
        """Why it ended early; None: it did not."""

    @abstractmethod
    def mark(self, label: str = "") -> float | None:
        """Mark this moment; return its time, None before any byte."""

    @abstractmethod
    def note(self, text: str) -> None:
        """Write a person's words, as of now."""

    @abstractmethod
    def close(self) -> None:
        """End the recording; the unit stays open. A second call does nothing.

        Raises `CaptureError`, or calls `on_failure`, if its end can't be written.
        """

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        close_after(kind, self.close)


def close_after(error: object, close: Callable[[], None]) -> None:
    """Close what records, after a block that raised `error` or, None, nothing.

    A `CaptureError` is raised only then: what has ended the work matters more.
    """
    try:
        close()
    except CaptureError:
        if error is None:
            raise


class _Maker(Protocol):
    def __call__(
        self,
        ecu: object,
        path: str | os.PathLike[str],
        *,
        on_failure: Callable[[CaptureError], object] | None,
    ) -> EcuRecording: ...


def recorded(
    ecu: object,
    path: str | os.PathLike[str],
    on_failure: Callable[[CaptureError], object] | None,
) -> EcuRecording:
    """As `Ecu.record`, of the `Ecu`."""
    make: _Maker = import_module(_MAKER).LineRecording
    return make(ecu, path, on_failure=on_failure)
