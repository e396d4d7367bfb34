"""The writers' input: channels, their rows in stretches of one size with times from zero, moments.

A live log brings rows one by one, a recording brings them by the ten thousand. Writers get
`STRETCH` rows at a time (and the rest at the end), so a file does not depend on how its rows
arrived, and memory is bounded by `STRETCH` and the longest piece that was brought.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mikas.i18n import Language, Text
from mikas.recording.export.dialect import Dialect
from mikas.recording.table.channels import Channel, Rows, calendar
from mikas.recording.table.gaps import with_gaps
from mikas.sampling.events import AlarmChanged, Event, Gap, Marker, TextNote

STRETCH = 32_768  # × 24 columns × 8 bytes: 6 MB

Column = NDArray[np.float64]


class Stretches:
    """The rows, to be run through once, at most `longest` at a time. `rows`: how many were yielded;
    `zero`: subtracted from every time.
    """

    def __init__(self, channels: Sequence[Channel], source: Iterable[Rows]) -> None:
        self.longest = STRETCH
        self.rows = 0
        self.zero = 0.0
        self._names = [channel.name for channel in channels]
        self._pieces = (self._columns(rows) for rows in source if len(rows.times))
        self._held: list[list[Column]] = []  # each: times, then the channels in their order

    def first_time(self) -> float | None:
        """Return the first row's time, None without rows; to be called before the rows are read."""
        if not self._held and (piece := next(self._pieces, None)) is not None:
            self._held.append(piece)
        return float(self._held[0][0][0]) if self._held else None

    def __iter__(self) -> Iterator[tuple[Column, list[Column]]]:
        """Yield (times from zero, the channels' values in their order); never empty."""
        for columns in self._gathered():
            self.rows += len(columns[0])
            yield columns[0] - self.zero, columns[1:]

    def _gathered(self) -> Iterator[list[Column]]:
        size = self.longest
        held, self._held = self._held, []
        count = sum(len(piece[0]) for piece in held)
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
            whole = _joined(held)
            for at in range(0, count, size):
                yield [column[at : at + size] for column in whole]

    def _columns(self, rows: Rows) -> list[Column]:
        times = np.asarray(rows.times, np.float64)
        columns = [times]
        for name in self._names:
            values = rows.values.get(name)
            if values is None:
                values = np.full(len(times), np.nan)
            elif len(values) != len(times):
                raise ValueError(f"{name}: {len(values)} values for {len(times)} times")
            columns.append(np.asarray(values, np.float64))
        return columns


@dataclass(frozen=True, slots=True)
class Sheet:
    """All input of a writer. `about`: of the recording, by title; no line breaks.

    `moments`: in the order of their times.
    """

    channels: tuple[Channel, ...]
    stretches: Stretches
    moments: tuple[Moment, ...]
    started: datetime | None
    about: Mapping[str, str]
    language: Language
    dialect: Dialect


def sheet_of(
    channels: Sequence[Channel],
    rows: Iterable[Rows],
    events: Iterable[Event],
    *,
    start: float | None,
    started: datetime | None,
    about: Mapping[str, str],
    language: Language,
    dialect: Dialect,
) -> Sheet:
    """Read the first rows for the time of the beginning; the rest is read by the writer."""
    noted = list(events)
    stretches = Stretches(channels, with_gaps(rows, noted))
    first = stretches.first_time()
    zero = start if start is not None else first
    if zero is None and noted:  # no rows, but events
        zero = min(map(began, noted))
    if zero is not None:
        stretches.zero = zero
        if started is None:
            started = calendar(zero)
    if started is not None and started.tzinfo is None:
        raise ValueError("`started` needs its time zone")
    return Sheet(
        channels=tuple(channels),
        stretches=stretches,
        moments=moments_of(noted, stretches.zero),
        started=started,
        about={_on_one_line(title): _on_one_line(text) for title, text in about.items()},
        language=language,
        dialect=dialect,
    )


def _joined(pieces: list[list[Column]]) -> list[Column]:
    if len(pieces) == 1:
        return pieces[0]
    return [np.concatenate(columns) for columns in zip(*pieces, strict=True)]


# Moments: events beside the values, for the formats that have a place for them

_MARKER = Text("marker", "отметка")
_NO_REASON = Text("nothing came", "ничего не пришло")


@dataclass(frozen=True, slots=True)
class Moment:
    """`kind`: marker, note, gap or alarm. `ended`: of a gap, None if it lasted to the end.

    `facts`: what an alarm was about, by name, for a reader that is a program.
    """

    kind: str
    time: float
    text: Text
    ended: float | None = None
    facts: dict[str, Any] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Return the moment as in a file's metadata."""
        told: dict[str, Any] = {"kind": self.kind, "time": round(self.time, 6)}
        if self.kind == Gap.kind:
            told["ended"] = None if self.ended is None else round(self.ended, 6)
        return told | self.facts | {"en": self.text.en, "ru": self.text.ru}


def moments_of(events: Iterable[Event], zero: float) -> tuple[Moment, ...]:
    """Return those of `events` that exports have, in the order of their times."""
    return tuple(sorted(_moments(events, zero), key=lambda moment: moment.time))


def began(event: Event) -> float:
    """Return when `event` began, on the link's clock; a gap is noted when it ends."""
    return event.began if isinstance(event, Gap) else event.time


def _moments(events: Iterable[Event], zero: float) -> Iterator[Moment]:
    for event in events:
        time = began(event) - zero
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
                yield Moment(event.kind, time, _line(text), facts=facts)


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
    return Text(*map(_on_one_line, text))


def _on_one_line(text: str) -> str:
    return " ".join(text.split())


# Text


def program() -> str:
    """Return the program's name with its version."""
    return f"mikas {version('mikas')}"


def spelled(
    channel: Channel, values: NDArray[np.float64], *, missing: str, decimal: str = "."
) -> list[str]:
    """Return `values` with the channel's decimals, never “-0”; `missing` for NaN and infinity.

    A parameter of one byte has 256 different values, so each different value is formatted once and
    the column is put together from these: about 2 µs a row of 24 columns, not 12 µs.
    """
    different, places = np.unique(values, return_inverse=True)
    decimals = max(channel.decimals, 0)
    texts = np.empty(len(different), object)
    texts[:] = [
        f"{value:z.{decimals}f}".replace(".", decimal) if finite else missing
        for value, finite in zip(different.tolist(), np.isfinite(different).tolist(), strict=True)
    ]
    column: list[str] = texts[places].tolist()
    return column


def lines(columns: Sequence[Sequence[str]], separator: str) -> bytes:
    """Return rows of `columns`, each ended by a line feed."""
    rows = map(separator.join, zip(*columns, strict=True))
    return ("\n".join(rows) + "\n").encode()


def without(text: str, *unwanted: str) -> str:
    """Return `text` for a header without quotes: what would need them becomes a space."""
    for piece in unwanted:
        text = text.replace(piece, " ")
    return " ".join(text.split())
