"""The library of recordings: the folder, summaries and open recordings, kept until files change.

Recordings stay open so that scrolling does not read them each time; two at most, as ten hours take
some 130 MB. The recording in progress grows all the time: it is read again when it is requested
some seconds later. Heavy work (an export, a report) runs in a thread, one piece at a time; a queue
that grows too long is refused.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final, TypeVar

from mikas.catalog import Catalog
from mikas.client.connecting import ConnectionOptions
from mikas.dashboard.errors import Busy
from mikas.dashboard.library.folder import RecordingFile, RecordingFolder
from mikas.i18n import Text
from mikas.recording.recording import Recording
from mikas.recording.summary import Summary, summarise

T = TypeVar("T")

_MAX_OPEN: Final = 2
_GROWING: Final = 10.0  # s until the recording in progress is read again
_MAX_QUEUE: Final = 8
_MANY: Final = Text(
    "several exports and reports are being made already", "уже готовятся другие таблицы и отчёты"
)


@dataclass(frozen=True, slots=True)
class _Open:
    stamp: tuple[int, int, int]
    at: float
    recording: Recording


class SummaryCache:
    """Summaries; any thread may call, one at a time makes a summary."""

    def __init__(self, catalog: Catalog) -> None:
        self._catalog = catalog
        self._kept: dict[str, tuple[tuple[int, int, int], Summary]] = {}
        self._making = threading.Lock()

    def of(self, file: RecordingFile) -> Summary:
        """Return the summary of `file`, made now or before."""
        kept = self._kept.get(file.id)
        if kept is None or kept[0] != file.stamp:
            with self._making:
                kept = self._kept.get(file.id)
                if kept is None or kept[0] != file.stamp:
                    kept = (file.stamp, summarise(file.path, self._catalog))
                    self._kept[file.id] = kept
        return kept[1]

    def keep_only(self, present: Iterable[RecordingFile]) -> None:
        """Drop the summaries of all other files."""
        for name in self._kept.keys() - {file.id for file in present}:
            self._kept.pop(name, None)


class RecordingService:
    """`in_progress`: the file name of the recording in progress; None: there is none.

    `clock`: seconds that never run back.
    """

    def __init__(
        self,
        folder: RecordingFolder,
        options: ConnectionOptions,
        *,
        clock: Callable[[], float],
        in_progress: Callable[[], str | None],
    ) -> None:
        self.folder = folder
        self.catalog, self.interpretation = options.catalog, options.interpretation
        self.summaries = SummaryCache(self.catalog)
        self._clock, self._in_progress = clock, in_progress
        self._open: dict[str, _Open] = {}  # the latest used last
        self._using = threading.Lock()
        self._busy = asyncio.Lock()
        self._waiting = 0

    def is_growing(self, file: RecordingFile) -> bool:
        """Whether the recording is in progress."""
        return self._in_progress() == file.id

    @contextmanager
    def opened(self, file: RecordingFile) -> Iterator[Recording]:
        """Return the recording, opened now or before, for one thread at a time."""
        with self._using:
            kept = self._open.pop(file.id, None)
            if kept is None or not self._is_current(kept, file):
                recording = Recording(file.path, self.catalog, self.interpretation)
                kept = _Open(file.stamp, self._clock(), recording)
            self._open[file.id] = kept
            if len(self._open) > _MAX_OPEN:
                del self._open[next(iter(self._open))]
            yield kept.recording

    def _is_current(self, kept: _Open, file: RecordingFile) -> bool:
        if kept.stamp == file.stamp:
            return True
        same_file = kept.stamp[2] == file.stamp[2]
        return self.is_growing(file) and same_file and self._clock() - kept.at < _GROWING

    async def run_alone(self, work: Callable[[], T]) -> T:
        """Return the result of `work`, run in a thread after the work before it. Raises `Busy`."""
        if self._waiting >= _MAX_QUEUE:
            raise Busy(problem=_MANY)
        self._waiting += 1
        try:
            async with self._busy:
                doing = asyncio.ensure_future(asyncio.to_thread(work))
                try:
                    return await asyncio.shield(doing)
                finally:  # a cancelled request's work uses the computer until it ends
                    await asyncio.wait({doing})
        finally:
            self._waiting -= 1
