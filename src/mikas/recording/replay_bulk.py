"""A long capture put in order for playing back: exchange after exchange is the same, but for data.

Everything goes through `replay_index`, packet by packet, until a request is known so well that one
more answer could bring nothing but data. From there on runs of such exchanges are taken at once, by
numpy; the first and the last of a run still go the usual way, so that whatever stands before or
behind it finds everything as if nothing had been passed over. The result is the same.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from mikas.catalog import Catalog
from mikas.commands.base import ERROR
from mikas.link.base import BITS_PER_BYTE
from mikas.link.tee import Direction
from mikas.recording.bulk.runs import Regular, Run, body_of
from mikas.recording.exchanges.arrays import Floats, Mask, joined
from mikas.recording.exchanges.capture import read
from mikas.recording.exchanges.packets import Packets
from mikas.recording.notes import Note
from mikas.recording.reader import CaptureReader, Packet, Problem, Source
from mikas.recording.replay_contents import ROUNDING
from mikas.recording.replay_index import Indexer, index
from mikas.recording.replay_recorded import Recorded, Series
from mikas.recording.replay_silences import SHORTEST

_NOT_BEFORE = 64  # packets: so far apart runs are looked for where none was found


class _SeveralPorts(Exception):
    """Their packets' order would be lost."""


def index_file(
    path: str | os.PathLike[str], catalog: Catalog, notes: Sequence[Note] = ()
) -> Recorded:
    """As `index` of all the file's packets. Raises as `CaptureReader` does."""
    indexer = Indexer(catalog, notes)
    try:
        return indexer.run(_fed(Path(path), indexer))
    except _SeveralPorts:
        return index(CaptureReader(path), catalog, notes)


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
    if indexer.times.placed(float(run.times[0])) < indexer.times.latest:
        return 0
    if run.size == 1:
        series = [indexer.series_of(None)]
        asked = np.zeros(run.count, np.int64)
    else:
        series = [indexer.series_of(body_of(wire) or b"") for wire in run.wires]
        asked = run.asked
    sizes = np.array([each.size if each is not None else -1 for each in series])
    fits = sizes[asked] == run.body_lengths
    fits &= run.ends - run.times <= SHORTEST
    count = int(fits.argmin()) if not fits.all() else run.count
    count -= 1  # the last one goes the usual way
    if count < 1:
        return 0
    times = _times(run, packets.source, indexer)
    kept = _beyond_doubt(run, count, times, series, indexer)
    places: dict[int, tuple[Series, list[int]]] = {}
    for number, each in enumerate(series):
        if each is not None:
            places.setdefault(id(each), (each, []))[1].append(number)
    for each, numbers in places.values():
        chosen = (np.isin(asked[:count], numbers) & kept).nonzero()[0]
        bodies = joined(run.bodies, run.body_starts[chosen], run.body_lengths[chosen])
        each.extend(times[chosen].tolist(), bodies.tobytes())
    _note_holes(run, count, packets.source, indexer)
    return count


def _beyond_doubt(
    run: Run, count: int, times: Floats, series: list[Series | None], indexer: Indexer
) -> Mask:
    """Which exchanges have data that count (D10); the doubts are told all of them."""
    kept = np.ones(count, np.bool_)
    asked = run.asked[:count] if run.size > 1 else np.zeros(count, np.int64)
    starts = run.body_starts[:count]
    requests = [body_of(wire) or b"" for wire in run.wires]
    doubts = indexer.contents.doubts
    for request, each in zip(requests, series, strict=False):  # a stream's run has no requests
        if each is not None:
            doubts.about(request, each)
    for code in doubts.followed:
        alone = np.isin(asked, [n for n, it in enumerate(requests) if it == bytes([0x61, code])])
        one = np.zeros(count, np.bool_)
        there = np.zeros(count, np.bool_)
        for number, each in enumerate(series):
            place = each.last_of(code) if each is not None else None
            if place is not None:
                mine = asked == number
                there |= mine
                begin, size = place
                one[mine] = (run.bodies[starts[mine] + begin] == ERROR[0]) & (size == 1)
        if code not in doubts.of:
            alone[:] = False  # of two bytes: a refusal is shorter
        doubtful = (alone & one).nonzero()[0]
        settling = (there & ~(alone & one)).nonzero()[0]
        counting = doubts.run(
            code,
            times[doubtful].tolist(),
            settling.searchsorted(doubtful).tolist(),
            times[settling].tolist(),
            one[settling].tolist(),
        )
        kept[doubtful[~np.array(counting, np.bool_)]] = False
    return kept


def _note_holes(run: Run, count: int, source: Source, indexer: Indexer) -> None:
    """Between the exchanges; what is within them is short."""
    shift = indexer.times.placed(0.0)
    begins = np.concatenate(([indexer.times.latest], run.ends[: count - 1] + shift))
    ends = run.times[:count] + shift
    for at in (ends - begins > SHORTEST).nonzero()[0].tolist():
        begin, end = float(begins[at]), float(ends[at])
        indexer.silences.passed(source.recording, begin, end, shift)
    size, until = run.size, float(run.ends[count - 1] + shift)
    indexer.passed_over(count, size=size, until=until)


def _times(run: Run, source: Source, indexer: Indexer) -> Floats:
    """To which moment the data belong: see `replay_index`."""
    shift = indexer.times.placed(0.0)
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
