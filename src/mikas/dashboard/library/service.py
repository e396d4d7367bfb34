"""The library of recordings as the routes use it: the folder, summaries, open recordings.

Heavy work (an export, a report) runs in a thread, one piece at a time; a queue that grows too long
is refused.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Final, TypeVar

from mikas.catalog import Catalog
from mikas.dashboard.errors import Busy
from mikas.dashboard.library.cache import RecordingCache, SummaryCache
from mikas.dashboard.library.folder import RecordingFile, RecordingFolder
from mikas.i18n import Text

T = TypeVar("T")

_MAX_QUEUE: Final = 8
_MANY: Final = Text(
    "several exports and reports are being made already", "уже готовятся другие таблицы и отчёты"
)


class RecordingService:
    """`in_progress`: the file name of the recording in progress; None: there is none."""

    def __init__(
        self,
        folder: RecordingFolder,
        catalog: Catalog,
        interpretation: str,
        *,
        clock: Callable[[], float],
        in_progress: Callable[[], str | None],
    ) -> None:
        self.folder = folder
        self.catalog, self.interpretation = catalog, interpretation
        self.open = RecordingCache(catalog, interpretation, clock)
        self.summaries = SummaryCache(catalog)
        self._in_progress = in_progress
        self._busy = asyncio.Lock()
        self._waiting = 0

    def is_growing(self, file: RecordingFile) -> bool:
        """Whether the recording is in progress."""
        return self._in_progress() == file.id

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
