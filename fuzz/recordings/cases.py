"""Case N of seed S, as bytes of a file: a changed recording, or crafted blocks."""

from __future__ import annotations

from io import BytesIO
from random import Random
from typing import Final

from fuzz.recordings import crafted, mutations
from fuzz.recordings.real import recordings
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.scan import RawBlock, scan

LONGEST: Final = 150_000  # bytes of a case


class Cases:
    """The cases of `seed`. Case 0 and the next ones are the real recordings, unchanged."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.real = recordings()
        self._all = list(self.real.values())
        self._chunks = sorted({chunk for data in self._all for chunk in _chunks(data)})

    def case(self, number: int) -> bytes:
        """Return the file of case `number`."""
        if number < len(self._all):
            return self._all[number]
        random = Random(f"{self.seed}:{number}")
        if random.random() < 0.35:
            data = crafted.recording(random, self._chunks)
            if random.random() < 0.8:
                return data[:LONGEST]
        else:
            data = random.choice(self._all)
        return mutations.mutated(random, data, self._all, self._chunks)[:LONGEST]


def _chunks(data: bytes) -> list[bytes]:
    """Return the data of the packets of a recording."""
    found = []
    for item in scan(BytesIO(data)):
        if isinstance(item, RawBlock):
            block = pcapng.parse(item.kind, item.body, item.order)
            if isinstance(block, pcapng.EnhancedPacket):
                found.append(block.data)
    return found
