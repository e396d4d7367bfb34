"""The summary of a recording, for a list of many: a fraction of a second even for ten hours.

The file is searched once (`index`); of packets only the first and last ones are read, and some
pieces of a long file. So all figures are exact but one: `samples` of a long file is an estimate
(`samples_exact`), and `rate` follows from it.

Any file has a summary; that of an unreadable one has a `problem`.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import BinaryIO, Final

from mikas import commands as c
from mikas.catalog import Catalog, shipped
from mikas.errors import CaptureError, MikasError
from mikas.i18n import Text
from mikas.link.tee import Direction
from mikas.recording.annotations.events import RecordedUnit, comment_of, events_of, unit_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.index import FileIndex, index
from mikas.recording.capture.notes import Kind, Note
from mikas.recording.capture.reader import Blocks, CaptureReader, Packet, reason_of
from mikas.recording.capture.scan import scan
from mikas.recording.exchanges.scalar import ScalarMatcher
from mikas.recording.table.channels import PLAINLY_UNIX
from mikas.sampling.events import Gap

_TAIL: Final = 1 << 14
_COUNTED: Final = 1 << 22  # bytes; of a longer file pieces are counted
_PIECE: Final = 1 << 17
_PIECES: Final = 8
_MOST_PACKETS: Final = 64  # behind a request, in which its response must be


@dataclass(frozen=True, slots=True)
class Summary:
    """The facts that a list shows. None: not known.

    `date`: UNIX time of the beginning; None for a simulated clock, too. `length`: seconds from each
    session's first packet to its last. `samples`: responses with data. `rate`: of them a second,
    gaps left out. `faults`: codes of the last response to 02; None: there is none. `note`: a
    person's words on it all. `problem`: why the file can't be read.
    """

    path: Path
    bytes: int = 0
    date: float | None = None
    first: float | None = None
    length: float | None = None
    unit: RecordedUnit | None = None
    samples: int | None = None
    samples_exact: bool = True
    rate: float | None = None
    gaps: int = 0
    faults: tuple[int, ...] | None = None
    markers: int = 0
    note: str = ""
    recordings: int = 0
    problem: Text | None = None

    @property
    def model(self) -> Text | None:
        """The unit's model."""
        return self.unit.model if self.unit else None

    @property
    def passport(self) -> tuple[str | None, ...] | None:
        """51–58 as in the notes."""
        return self.unit.passport if self.unit else None


def summarise(path: str | os.PathLike[str], catalog: Catalog | None = None) -> Summary:
    """What there is to say of `path`. Never raises for what is in it."""
    path = Path(path)
    catalog = catalog or shipped()
    size = 0
    try:
        size = path.stat().st_size
        CaptureReader(path)  # raises, if it is no capture
        with path.open("rb") as file:
            return _summed_up(path, file, catalog)
    except CaptureError as error:
        return Summary(path, size, problem=error.problem)
    except OSError as error:
        return Summary(path, size, problem=reason_of(error))


def _summed_up(path: Path, file: BinaryIO, catalog: Catalog) -> Summary:
    places = index(file)
    notes = places.notes
    spans = list(_spans(file, places))
    events = events_of(notes, catalog)
    gaps = [event for event in events if isinstance(event, Gap)]
    first = spans[0][0] if spans else None
    length = sum(last - begin for begin, last in spans) if spans else None
    samples, exact = _samples(path, file, places, catalog)
    silent = sum(max(0.0, gap.ended - gap.began) for gap in gaps if gap.ended is not None)
    first_noted = next((note.recording for note in notes if note.kind == Kind.UNIT), 0)
    lasted = (length or 0.0) - silent
    return Summary(
        path=path,
        bytes=places.size,
        date=first if first is not None and first >= PLAINLY_UNIX else None,
        first=first,
        length=length,
        unit=unit_of((note for note in notes if note.recording == first_noted), catalog),
        samples=samples,
        samples_exact=exact,
        rate=samples / lasted if samples and lasted > 0 else None,
        gaps=len(gaps),
        faults=_faults(file, places),
        markers=sum(note.kind == Kind.MARKER for note in notes),
        note=comment_of(notes) or _first_words(notes),
        recordings=len(places.sections),
    )


def _first_words(notes: Iterable[Note]) -> str:
    for note in notes:
        text = note.data.get("text")
        if note.kind == Kind.NOTE and isinstance(text, str):
            return text
    return ""


def _head(file: BinaryIO, start: int, stop: int) -> tuple[Blocks, Packet | None]:
    """Return a section's ports and its first packet."""
    blocks = Blocks()
    for item in scan(file, start):
        if item.offset >= stop:
            break
        for told in blocks.read(item):
            if isinstance(told, Packet):
                return blocks, told
    return blocks, None


def _spans(file: BinaryIO, places: FileIndex) -> Iterator[tuple[float, float]]:
    """Yield each session's first and last time."""
    for start, stop in pairwise([*places.sections, places.size]):
        blocks, packet = _head(file, start, stop)
        if packet is not None:
            last = packet.time
            begin = max(packet.offset, stop - _TAIL)
            for later in _packets(file, blocks, begin, stop, places.order(start)):
                last = max(last, later.time)
            yield packet.time, last


def _packets(
    file: BinaryIO, blocks: Blocks, begin: int, stop: int, order: pcapng.Order
) -> Iterator[Packet]:
    for item in scan(file, begin, order):
        if item.offset >= stop:
            return
        for told in blocks.read(item):
            if isinstance(told, Packet):
                yield told


def _faults(file: BinaryIO, places: FileIndex) -> tuple[int, ...] | None:
    """Return the codes of the last response to 02."""
    edges = [*places.sections, places.size]
    for offset in reversed(places.fault_requests):
        section = places.section(offset)
        if section < 0:
            continue
        blocks, _ = _head(file, edges[section], edges[section + 1])
        order = places.orders[section]
        exchange: list[Packet] = []
        for packet in _packets(file, blocks, offset, edges[section + 1], order):
            again = exchange and packet.direction is Direction.SENT
            if again or len(exchange) >= _MOST_PACKETS:
                break
            exchange.append(packet)
        if not exchange:
            continue
        found = ScalarMatcher(exchange[0].source).feed(exchange)
        asked = {number for number, body in enumerate(found.bodies) if body == b"\x02"}
        for _, _, body in found.responses.of(asked):
            with suppress(MikasError):
                return tuple(c.ReadFaults().read(body))
    return None


def _samples(
    path: Path, file: BinaryIO, places: FileIndex, catalog: Catalog
) -> tuple[int | None, bool]:
    """Return the number of responses with data, and whether it was counted."""
    if places.size <= _COUNTED:
        from mikas.recording.table.reader import TableReader

        with suppress(MikasError):
            return sum(len(rows.times) for rows in TableReader(path, catalog).rows()), True
        return None, True
    return _estimated(file, places), False


def _estimated(file: BinaryIO, places: FileIndex) -> int:
    """Count responses in pieces of the file, and take the rest to be alike."""
    from mikas.recording.exchanges.columnar import ColumnarMatcher
    from mikas.recording.exchanges.packets import PacketColumns, Window

    edges = [*places.sections, places.size]
    heads: dict[int, Blocks] = {}
    seen = answers = 0
    step = places.size // _PIECES
    for offset in range(step // 2, places.size, step):
        section = max(0, places.section(offset))
        if section not in heads:
            heads[section] = _head(file, edges[section], edges[section + 1])[0]
        item = next(scan(file, offset & -4, places.orders[section]), None)
        begin = item.end if item is not None else places.size
        window = Window(file, begin, _PIECE, places.orders[section])
        found, end = window.run(begin)
        if found.size and heads[section].interfaces:
            seen += end - begin
            columns = PacketColumns(window, found, heads[section])
            for packets in columns.packets(0, found.size):
                answers += len(ColumnarMatcher(packets.source).feed(packets).responses.times)
    return round(answers * places.size / seen) if seen else 0
