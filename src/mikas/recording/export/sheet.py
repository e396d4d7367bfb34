"""The writers' input: channels, their rows in batches of one size with times from zero, moments.

A live log yields rows one by one, a recording yields ten thousands. Writers get `BATCH` rows at a
time (and the rest at the end), so a file does not depend on how its rows arrived, and memory is
bounded by `BATCH` and the longest piece of the source.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from importlib.metadata import version
from itertools import chain, islice
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mikas.catalog.synonyms import names_of
from mikas.i18n import Language, Text
from mikas.recording.table.channels import Channel, Rows, calendar, with_gaps
from mikas.sampling.events import AlarmChanged, Event, Gap, Marker, TextNote

if TYPE_CHECKING:
    from mikas.recording.export.dialects import Dialect

BATCH = 32_768  # × 24 columns × 8 bytes: 6 MB

Column = NDArray[np.float64]


def _joined(pieces: list[list[Column]]) -> list[Column]:
    if len(pieces) == 1:
        return pieces[0]
    return [np.concatenate(columns) for columns in zip(*pieces, strict=True)]


class Sheet:
    """All input of a writer; the parameters are those of `export`.

    Only the first rows are read at once, for the time of the beginning, `zero`; the writer reads
    the others.
    """

    def __init__(
        self,
        channels: Sequence[Channel],
        rows: Iterable[Rows],
        events: Iterable[Event],
        about: Mapping[str, str],
        *,
        language: Language,
        dialect: Dialect,
    ) -> None:
        events = list(events)
        self.channels: tuple[Channel, ...] = tuple(channels)
        """The columns but the time."""
        self.rows: int = 0
        """How many rows were yielded."""
        pieces = (self._columns(each) for each in with_gaps(rows, events) if len(each.times))
        first = list(islice(pieces, 1))
        self._pieces = chain(first, pieces)
        begins = [float(first[0][0][0])] if first else map(_begin, events)
        zero = min(begins, default=None)
        self.zero: float = zero or 0.0
        """The time of the first row, on the link's clock."""
        self.started: datetime | None = None if zero is None else calendar(zero)
        """The date of the first row; None: the clock does not count from 1970."""
        moments = _moments(events, self.zero)
        self.moments: tuple[Moment, ...] = tuple(sorted(moments, key=attrgetter("time")))
        """Markers, notes, gaps and alarms, in the order of their times."""
        self.about: dict[str, str] = {
            without(title): without(text) for title, text in about.items()
        }
        """Facts of the recording by title, each on one line."""
        self.language = language
        """The language of what is in one language."""
        self.dialect = dialect
        """The form of a CSV."""

    def batches(self) -> Iterator[tuple[Column, list[Column]]]:
        """Yield (times from `zero`, the channels' values in their order), once; never empty."""
        for columns in self._gathered():
            self.rows += len(columns[0])
            yield columns[0] - self.zero, columns[1:]

    def _gathered(self) -> Iterator[list[Column]]:
        size, count = BATCH, 0
        held: list[list[Column]] = []  # each: times, then the channels in their order
        for piece in self._pieces:
            held.append(piece)
            count += len(piece[0])
            if count >= size:
                whole = _joined(held)
                for at in range(0, count - size + 1, size):
                    yield [column[at : at + size] for column in whole]
                rest = count % size
                held = [[column[count - rest :] for column in whole]] if rest else []
                count = rest
        if count:
            yield _joined(held)

    def _columns(self, rows: Rows) -> list[Column]:
        times = np.asarray(rows.times, np.float64)
        columns = [times]
        for name in (channel.name for channel in self.channels):
            values = rows.values.get(name)
            if values is None:
                values = np.full(len(times), np.nan)
            elif len(values) != len(times):
                raise ValueError(f"{name}: values: {len(values)}, times: {len(times)}")
            columns.append(np.asarray(values, np.float64))
        return columns


def program() -> str:
    """Return the program's name with its version."""
    return f"mikas {version('mikas')}"


def without(text: str, *unwanted: str) -> str:
    """Return `text` on one line, with a space for each unwanted piece."""
    for piece in unwanted:
        text = text.replace(piece, " ")
    return " ".join(text.split())


# Moments: events, for the formats that have a place for them

_MARKER = Text("marker", "отметка")
_NO_REASON = Text("nothing came", "ничего не пришло")


@dataclass(frozen=True, slots=True)
class Moment:
    """An event of the recording, for the formats that have a place for it."""

    kind: str
    """marker, note, gap or alarm."""
    time: float
    """Seconds from the first row."""
    text: Text
    """What people read."""
    ended: float | None = None
    """The end of a gap; None: it lasted to the end."""
    facts: dict[str, Any] = field(default_factory=dict)
    """An alarm's fields by name, for programs."""
    brief: str = ""
    """An alarm in few letters; or empty."""

    def as_json(self) -> dict[str, Any]:
        """Return the moment as in a file's metadata."""
        form: dict[str, Any] = {"kind": self.kind, "time": round(self.time, 6)}
        if self.kind == Gap.kind:
            form["ended"] = None if self.ended is None else round(self.ended, 6)
        return form | self.facts | {"en": self.text.en, "ru": self.text.ru}


def _begin(event: Event) -> float:
    """Return when `event` began; a gap is noted when it ends."""
    return event.began if isinstance(event, Gap) else event.time


def _moments(events: Iterable[Event], zero: float) -> Iterator[Moment]:
    for event in events:
        time = _begin(event) - zero
        match event:
            case Marker():
                text = _line(Text(event.label, event.label))
                yield Moment(event.kind, time, text if text.en else _MARKER)
            case TextNote():
                yield Moment(event.kind, time, _line(Text(event.text, event.text)))
            case Gap():
                ended = None if event.ended is None else event.ended - zero
                yield Moment(event.kind, time, _gap(event, time, ended), ended)
            case AlarmChanged():
                text = event.text if event.text.en else Text(*[f"{event.name}: {event.level}"] * 2)
                facts = {
                    name: getattr(event, name)
                    for name in ("name", "level", "before", "side", "value", "limit")
                }
                yield Moment(event.kind, time, _line(text), facts=facts, brief=_brief(event))


def _brief(event: AlarmChanged) -> str:
    """Return `CLT 101 > 100: warning`, with the name of logs; the level is that of now."""
    value = "" if event.value is None else f" {event.value:g}"
    beyond = {"high": ">", "low": "<"}.get(event.side or "", "")
    if value and beyond and event.limit is not None and event.level != "none":
        value += f" {beyond} {event.limit:g}"
    return f"{names_of(event.name).log or event.name}{value}: {event.level}"


def _gap(event: Gap, time: float, ended: float | None) -> Text:
    reason = _line(event.reason or _NO_REASON)
    if ended is None:
        return Text(f"gap to the end: {reason.en}", f"разрыв до конца: {reason.ru}")
    seconds = f"{ended - time:.1f}"
    return Text(
        f"gap of {seconds} s: {reason.en}",
        f"разрыв {seconds.replace('.', ',')} с: {reason.ru}",
    )


def _line(text: Text) -> Text:
    return Text(*map(without, text))
