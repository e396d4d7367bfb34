"""When the content of a recording happens in its replay, whose times count from the first packet.

Several recordings in one file (it was appended to) follow each other with a short silence between,
however long it really was; where times run back, they go on from there.
"""

from __future__ import annotations

from typing import Final

from mikas.recording.exchanges.result import JUMP, Exchanges
from mikas.replay.model import ReplayData
from mikas.replay.outages import Outages

PAUSE: Final = 3.0  # s between two recordings in a file
AFTER: Final = 0.5  # s that the end of a recording is longer than its last packet


class Timeline:
    """Places stretches of exchanges, one after another. `shift`: from the present one's own times
    to those of the replay. `latest`: the time of the last packet; `began`: of the recording.
    """

    def __init__(self, data: ReplayData, outages: Outages) -> None:
        self.shift = self.latest = self.began = 0.0
        self.recording: int | None = None
        self._data = data
        self._outages = outages

    def enter(self, stretch: Exchanges) -> None:
        """Place a stretch, within which times do not run back."""
        recording = stretch.source.recording
        if self.recording is None:
            self._data.begin, self.shift = stretch.begin, -stretch.begin
            self._data.baud = stretch.source.baud or self._data.baud
        elif recording != self.recording:
            self._outages.without_supply(self.latest + AFTER, self.latest + PAUSE)
            self.began = self.latest + PAUSE
            self.shift = self.began - stretch.begin
        elif stretch.begin + self.shift < self.latest - JUMP:
            self.shift = self.latest - stretch.begin
        self.recording = recording
        for begin, end in stretch.gaps:
            since = max(begin + self.shift, self.latest)
            self._outages.passed(recording, since, end + self.shift, self.shift)
        self.latest = max(self.latest, stretch.end + self.shift)
