"""A long capture put in order for playing back: exchange after exchange is the same, but for data.

Everything goes through `replay_index`, packet by packet, until a request is known so well that one
more answer could bring nothing but data. From there on runs of such exchanges are taken at once, by
numpy; the first and the last of a run still go the usual way, so that whatever stands before or
behind it finds everything as if nothing had been passed over. The result is the same.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from mikas.catalog import Catalog
from mikas.link.base import BITS_PER_BYTE
from mikas.link.tee import Direction
from mikas.recording.bulk.arrays import Floats, joined
from mikas.recording.bulk.capture import read
from mikas.recording.bulk.packets import Packets
from mikas.recording.bulk.runs import Regular, Run, body_of
from mikas.recording.reader import CaptureReader, Packet, Problem, Source
from mikas.recording.replay_index import ROUNDING, Indexer, index
from mikas.recording.replay_recorded import Recorded, Series

_NOT_BEFORE = 64  # packets: so far apart runs are looked for where none was found


class _SeveralPorts(Exception):
    """Their packets' order would be lost."""


def index_file(path: str | os.PathLike[str], catalog: Catalog) -> Recorded:
    """As `index` of all the file's packets. Raises as `CaptureReader` does."""
    indexer = Indexer(catalog)
    try:
        return indexer.run(_fed(Path(path), indexer))
    except _SeveralPorts:
        return index(CaptureReader(path), catalog)


def _fed(path: Path, indexer: Indexer) -> Iterator[Packet | Problem]:
    """What the indexer has to see itself; the rest is given to it in between."""
    source: Source | None = None
    for item in read(path):
        if isinstance(item, Problem):
            yield item
            continue
        if source and source != item.source and source.recording == item.source.recording:
            raise _SeveralPorts
        source = item.source
        yield from _stretch(item, indexer)


def _stretch(packets: Packets, indexer: Indexer) -> Iterator[Packet]:
    regular = Regular(packets)
    at = again = 0
    steady = packets.sent.size - 1
    while at < packets.sent.size:
        size = indexer.repeats if again <= at < steady and at else 0
        if size and (size == 1 or packets.sent[at]):
            run = regular.run(at, size=size)
            if run is not None and (taken := _take(run, packets, indexer)):
                at += taken * size
            else:
                again = at + _NOT_BEFORE
        yield _packet(packets, at)
        at += 1


def _take(run: Run, packets: Packets, indexer: Indexer) -> int:
    """Keeps what the run brings, but for its last exchange; returns how many exchanges that was."""
    if indexer.placed(float(run.times[0])) < indexer.latest:
        return 0
    if run.size == 1:
        series = [indexer.series_of(None)]
        asked = np.zeros(run.count, np.int64)
    else:
        series = [indexer.series_of(body_of(wire) or b"") for wire in run.wires]
        asked = run.asked
    sizes = np.array([each.size if each is not None else -1 for each in series])
    fits = sizes[asked] == run.body_lengths
    count = int(fits.argmin()) if not fits.all() else run.count
    count -= 1  # the last one goes the usual way
    if count < 1:
        return 0
    places: dict[int, tuple[Series, list[int]]] = {}
    for number, each in enumerate(series):
        if each is not None:
            places.setdefault(id(each), (each, []))[1].append(number)
    for each, numbers in places.values():
        chosen = np.isin(asked[:count], numbers).nonzero()[0]
        bodies = joined(run.bodies, run.body_starts[chosen], run.body_lengths[chosen])
        each.extend(_times(run, packets.source, indexer)[chosen].tolist(), bodies.tobytes())
    indexer.passed_over(count, size=run.size)
    return count


def _times(run: Run, source: Source, indexer: Indexer) -> Floats:
    """To which moment the data belong: see `replay_index`."""
    shift = indexer.placed(0.0)
    if run.size > 1:
        return run.times + shift
    byte_time = BITS_PER_BYTE / (source.baud or 9600)
    began = (run.ends + shift) - run.wire_lengths * byte_time
    return began - ROUNDING


def _packet(packets: Packets, at: int) -> Packet:
    start = int(packets.at[at])
    data = packets.buffer[start : start + int(packets.lengths[at])].tobytes()
    return Packet(
        Direction.SENT if packets.sent[at] else Direction.RECEIVED,
        data,
        float(packets.times[at]),
        int(packets.offsets[at]),
        source=packets.source,
    )
