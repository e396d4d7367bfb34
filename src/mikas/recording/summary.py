"""The summary of a recording, for a list of many: a fraction of a second even for ten hours.

The file is searched once (`index`); of packets only the first and last ones are read, and some
pieces of a long file. So all figures are exact but `samples` of a long file (`samples_exact`) and
the `rate` computed from it. An unreadable file has a summary with a `problem`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas import commands as c
from mikas.catalog import Catalog, shipped
from mikas.client.cars import NO_CAR, CarDetails
from mikas.errors import CaptureError, MikasError
from mikas.i18n import Text
from mikas.link.base import Direction
from mikas.recording.annotations.cars import several
from mikas.recording.annotations.events import (
    RecordedUnit,
    car_of,
    comment_of,
    events_of,
    first_unit,
)
from mikas.recording.annotations.fields import LONGEST_COMMENT
from mikas.recording.capture.notes import Note
from mikas.recording.capture.opening import capture_error, opened_capture, reason_of
from mikas.recording.capture.reader import Packet
from mikas.recording.capture.scan import scan
from mikas.recording.capture.sections import Sections
from mikas.recording.exchanges import count_responses
from mikas.recording.exchanges.scalar import DecodedFrame
from mikas.recording.inspect import decode
from mikas.recording.splitting import cars_in_sections
from mikas.recording.table.channels import PLAINLY_UNIX
from mikas.sampling.events import ClockChanged, Gap, Marker, TextNote

if TYPE_CHECKING:
    from mikas.recording.recording import Recording

_COUNTED: Final = 1 << 22  # bytes; of a longer file pieces are counted
_MOST_CHANGES: Final = 3  # of the clock, in words
_MOST_SECTIONS: Final = 100  # of a file whose responses are counted: each costs milliseconds
_PIECE: Final = 1 << 17
_PIECES: Final = 8
_MOST_PACKETS: Final = 64  # after a request, in which its response must be
_NEAR: Final = 1 << 13  # bytes of them


@dataclass(frozen=True, slots=True)
class Summary:
    """The facts that a list shows. None: unknown.

    `date`: UNIX time of the begin; None for a simulated clock, too. `length`: sum of the seconds
    from each session's first packet to its last. `samples`: responses with data. `rate`: samples a
    second without the gaps. `faults`: codes of the last response to 02; None without one. `note`: a
    person's comment. `car`: as the person names it. `clock`: the latest changes of the computer's
    date in words. `problem`: why the file can't be read.
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
    car: CarDetails = NO_CAR
    recordings: int = 0
    clock: tuple[Text, ...] = ()
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
    """Return the summary of `path`. Never raises for the file's contents."""
    path = Path(path)
    catalog = catalog or shipped()
    size = 0
    try:
        size = path.stat().st_size
        with opened_capture(path) as file:
            return _summary(path, Sections(file), catalog)
    except CaptureError as error:
        return Summary(path, size, problem=error.problem)
    except OSError as error:
        return Summary(path, size, problem=reason_of(error))


def summary_of(recording: Recording) -> Summary:
    """Return the summary of a recording that has been read. Raises `CaptureError` if it is gone."""
    raw, path = recording.raw, recording.path
    try:
        size = path.stat().st_size
    except OSError as error:
        raise capture_error(path, error) from error
    readings = [reading for port in raw.fault_readings.values() for reading in port]
    latest = max(readings, key=lambda reading: reading.time, default=None)
    sessions = [*raw.spans, *(note.recording for note in raw.notes)]
    spans, rows = [*raw.spans.values()], recording.row_count
    return replace(
        _described(path, raw.notes, spans, rows, recording.catalog),
        bytes=size,
        faults=latest.codes if latest else None,
        recordings=max(sessions, default=-1) + 1,
    )


def _summary(path: Path, sections: Sections, catalog: Catalog) -> Summary:
    cars = cars_in_sections(sections)
    if len(cars) > 1:
        return Summary(path, sections.index.size, problem=several(cars))
    samples, is_exact = _samples(path, sections, catalog)
    numbers = range(len(sections.index.sections))
    spans = [span for number in numbers if (span := sections.span(number))]
    return replace(
        _described(path, sections.index.notes, spans, samples, catalog),
        bytes=sections.index.size,
        samples_exact=is_exact,
        faults=_faults(sections),
        recordings=len(sections.index.sections),
    )


def _described(
    path: Path,
    notes: Sequence[Note],
    spans: Sequence[tuple[float, float]],
    samples: int | None,
    catalog: Catalog,
) -> Summary:
    """Return what follows from the notes and the sessions' first and last times."""
    events = events_of(notes, catalog)
    gaps = [event for event in events if isinstance(event, Gap)]
    texts = (event.text for event in events if isinstance(event, TextNote))
    first = spans[0][0] if spans else None
    length = sum(last - begin for begin, last in spans) if spans else None
    silent = sum(
        max(0.0, min(gap.ended, last) - max(gap.began, begin))
        for gap in gaps
        if gap.ended is not None
        for begin, last in spans
    )
    sampled = (length or 0.0) - silent
    return Summary(
        path=path,
        date=first if first is not None and first >= PLAINLY_UNIX else None,
        first=first,
        length=length,
        unit=first_unit(notes, catalog),
        samples=samples,
        rate=samples / sampled if samples and sampled > 0 else None,
        gaps=len(gaps),
        markers=sum(isinstance(event, Marker) for event in events),
        clock=tuple(it.text for it in events if isinstance(it, ClockChanged))[-_MOST_CHANGES:],
        note=comment_of(notes) or next(texts, "")[:LONGEST_COMMENT],
        car=car_of(notes),
    )


def _faults(sections: Sections) -> tuple[int, ...] | None:
    """Return the codes of the last response to 02."""
    for offset in reversed(sections.index.fault_requests):
        section = sections.index.section(offset)
        if section < 0:
            continue
        exchange: list[Packet] = []
        for packet in sections.packets(section, offset, _NEAR):
            is_next = exchange and packet.direction is Direction.SENT
            if is_next or len(exchange) >= _MOST_PACKETS:
                break
            exchange.append(packet)
        for item in decode(exchange):
            if isinstance(item, DecodedFrame) and item.request == b"\x02":
                with suppress(MikasError):
                    return tuple(c.ReadFaults().read(item.frame.body))
    return None


def _samples(path: Path, sections: Sections, catalog: Catalog) -> tuple[int | None, bool]:
    """Return the number of responses with data, and whether it was counted."""
    if sections.index.size > _COUNTED or len(sections.index.sections) > _MOST_SECTIONS:
        return _estimated(sections, catalog), False
    from mikas.recording.recording import Recording

    with suppress(MikasError):
        return Recording(path, catalog).row_count, True
    return None, True


def _estimated(sections: Sections, catalog: Catalog) -> int:
    """Count responses in pieces of the file, and assume the same density elsewhere."""
    size = sections.index.size
    read = responses = 0
    step = size // _PIECES
    for offset in range(step // 2, size, step):
        section = max(0, sections.index.section(offset))
        blocks, order = sections.head(section)[0], sections.index.orders[section]
        item = next(scan(sections.file, offset & -4, order), None)
        begin = item.end if item is not None else size
        piece = range(begin, min(size, begin + _PIECE))
        file, size_of = sections.file, catalog.size_of
        more, length = count_responses(file, piece, order, copy(blocks), size_of)
        responses, read = responses + more, read + length
    return round(responses * size / read) if read else 0
