"""Recordings that are being looked into: kept open, so that scrubbing does not read them each time.

Two at most: ten hours take some 130 MB. The one that is being made grows all the time; it is read
again when somebody looks at it after a while.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from mikas.catalog import Catalog
from mikas.dashboard.library.folder import Shelved
from mikas.recording.recording import Recording

_MOST: Final = 2
_GROWING: Final = 10.0  # s that a recording in progress is taken as it was


@dataclass(frozen=True, slots=True)
class _Kept:
    stamp: tuple[int, int, int]
    at: float
    recording: Recording


class Opened:
    """Any thread may ask; one at a time is served. `clock`: seconds that never run back."""

    def __init__(self, catalog: Catalog, interpretation: str, clock: Callable[[], float]) -> None:
        self._catalog, self._interpretation, self._clock = catalog, interpretation, clock
        self._kept: OrderedDict[str, _Kept] = OrderedDict()
        self.using = threading.Lock()
        """To be held while a recording from here is used: it is made for one thread at a time."""

    def one(self, it: Shelved, *, growing: bool) -> Recording:
        """The recording, opened now or before. `growing`: it is being made."""
        kept = self._kept.get(it.id)
        if kept is not None and not self._is_current(kept, it, growing=growing):
            kept = None
        if kept is None:
            recording = Recording(it.path, self._catalog, self._interpretation)
            kept = _Kept(it.stamp, self._clock(), recording)
        self._kept[it.id] = kept
        self._kept.move_to_end(it.id)
        while len(self._kept) > _MOST:
            self._kept.popitem(last=False)
        return kept.recording

    def _is_current(self, kept: _Kept, it: Shelved, *, growing: bool) -> bool:
        if kept.stamp == it.stamp:
            return True
        same_file = kept.stamp[2] == it.stamp[2]
        return growing and same_file and self._clock() - kept.at < _GROWING
