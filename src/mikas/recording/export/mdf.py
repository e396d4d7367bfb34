"""ASAM MDF 4.10, by asammdf: one group, its master `time` in seconds, the start in the header.

A channel is a float of 64 bits with its unit; both texts are its comment; a missing value is NaN.
Markers, notes and alarms are events (bookmarks) of the file, a gap is an interrupt of the
acquisition with a begin and an end.
Records are collected in a file next to OUT and packed (transposed, deflate) at the end.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from tempfile import NamedTemporaryFile, TemporaryDirectory
from typing import Final

import numpy as np
from asammdf import MDF, Signal
from asammdf.blocks import v4_constants as v4
from asammdf.blocks.v4_blocks import EventBlock

from mikas.recording.export.sheet import Column, Sheet, program

_PACKED: Final = 2
_EVENTS: Final = {
    "marker": (v4.EVENT_TYPE_MARKER, v4.EVENT_CAUSE_USER),
    "note": (v4.EVENT_TYPE_MARKER, v4.EVENT_CAUSE_USER),
    "alarm": (v4.EVENT_TYPE_MARKER, v4.EVENT_CAUSE_TOOL),
    "gap": (v4.EVENT_TYPE_ACQUISITION_INTERRUPT, v4.EVENT_CAUSE_ERROR),
}
"""The type and the cause of an event, by the kind of moment."""
_UNKNOWN = datetime(1970, 1, 1, tzinfo=UTC)
_BEYOND = datetime(2554, 1, 1, tzinfo=UTC)  # the header has 64 bits for nanoseconds


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet."""
    with (
        path.open("wb+") as file,
        TemporaryDirectory(dir=path.parent, prefix=f"{path.name[:100]}.") as folder,
        _collecting(folder) as mdf,
    ):
        started = sheet.started or _UNKNOWN
        mdf.start_time = started if started < _BEYOND else _UNKNOWN
        mdf.header.comment = _comment(sheet)
        batches = sheet.batches()
        empty = np.empty(0)
        times, columns = next(batches, (empty, [empty] * len(sheet.channels)))
        mdf.append(_signals(sheet, times, columns), common_timebase=True)
        for times, columns in batches:
            mdf.extend(0, [(times, None), *((column, None) for column in columns)])
        _add_events(mdf, sheet)
        mdf.save(file, compression=_PACKED)


@contextmanager
def _collecting(folder: str) -> Iterator[MDF]:
    """Give an empty MDF that collects its records in a file in `folder`.

    asammdf prints a traceback itself where its file can't be made (in a destructor), and where its
    own `with` can't write the rest of a buffer. Neither happens so.
    """
    NamedTemporaryFile(dir=folder).close()  # raises where asammdf's could not be made
    mdf = MDF(version="4.10", temporary_folder=folder)
    try:
        yield mdf
    finally:
        with suppress(OSError):  # all is saved by then, or a write has failed before
            mdf.close()


def _signals(sheet: Sheet, times: Column, columns: list[Column]) -> list[Signal]:
    return [
        Signal(
            samples=values,
            timestamps=times,
            name=channel.name,
            unit=channel.unit,
            comment=f"{channel.text.en} / {channel.text.ru}",
        )
        for channel, values in zip(sheet.channels, columns, strict=True)
    ]


def _add_events(mdf: MDF, sheet: Sheet) -> None:
    events: list[EventBlock] = mdf.events
    for moment in sheet.moments:
        text = moment.text
        both = text.en if text.en == text.ru else f"{text.en} / {text.ru}"
        event = _event(moment.kind, moment.time, text.to(sheet.language), f"{moment.kind}: {both}")
        events.append(event)
        if moment.ended is not None:
            event.range_type = v4.EVENT_RANGE_TYPE_BEGINNING
            end = _event(moment.kind, moment.ended, event.name, event.comment)
            end.range_type = v4.EVENT_RANGE_TYPE_END
            end["range_start"] = len(events) - 1  # an index; saving makes it a link
            events.append(end)


def _event(kind: str, time: float, name: str, comment: str) -> EventBlock:
    event_type, cause = _EVENTS[kind]
    event = EventBlock(
        event_type=event_type,
        cause=cause,
        flags=0,
        range_type=v4.EVENT_RANGE_TYPE_POINT,
        sync_base=round(time * 1e6),
        sync_factor=1e-6,
    )
    event.name, event.comment = name, comment
    return event


def _comment(sheet: Sheet) -> str:
    facts = [program(), *(f"{title}: {text}" for title, text in sheet.about.items())]
    if sheet.started is None or sheet.started >= _BEYOND:
        facts.append(f"start: {sheet.started or 'unknown'}")
    return "\n".join(facts)
