"""Open recordings and their summaries, kept until their files change.

Recordings stay open so that scrolling does not read them each time; two at most, as ten hours take
some 130 MB. The recording in progress grows all the time: it is read again when it is requested
some seconds later. A summary is made once for each state of a file.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Final

from mikas.catalog import Catalog
from mikas.dashboard.library.folder import RecordingFile
from mikas.recording.recording import Recording
from mikas.recording.summary import Summary, summarise

_MAX_OPEN: Final = 2
_GROWING: Final = 10.0  # s that the recording in progress is shown as it was


@dataclass(frozen=True, slots=True)
class _Open:
    stamp: tuple[int, int, int]
    at: float
    recording: Recording


class RecordingCache:
    """Open recordings; any thread may call. `clock`: seconds that never run back."""

    def __init__(self, catalog: Catalog, interpretation: str, clock: Callable[[], float]) -> None:
        self._catalog, self._interpretation, self._clock = catalog, interpretation, clock
        self._open: OrderedDict[str, _Open] = OrderedDict()
        self.using = threading.Lock()
        """To be held while a recording of this cache is used: one thread at a time."""

    def one(self, file: RecordingFile, *, growing: bool) -> Recording:
        """Return the recording, opened now or before. `growing`: it is in progress."""
        kept = self._open.get(file.id)
        if kept is None or not self._is_current(kept, file, growing=growing):
            recording = Recording(file.path, self._catalog, self._interpretation)
            kept = _Open(file.stamp, self._clock(), recording)
        self._open[file.id] = kept
        self._open.move_to_end(file.id)
        while len(self._open) > _MAX_OPEN:
            self._open.popitem(last=False)
        return kept.recording

    def _is_current(self, kept: _Open, file: RecordingFile, *, growing: bool) -> bool:
        if kept.stamp == file.stamp:
            return True
        same_file = kept.stamp[2] == file.stamp[2]
        return growing and same_file and self._clock() - kept.at < _GROWING


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
        names = {file.id for file in present}
        for name in [name for name in self._kept if name not in names]:
            self._kept.pop(name, None)
