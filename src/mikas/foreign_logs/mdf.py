"""ASAM MDF 4, by asammdf (`mikas[mdf]`): every channel that holds one number a sample.

Channel groups have clocks of their own: the table has a row at each of their times, and a value
only in the rows of its own group. Sizes are checked before anything is unpacked, for a small file
may claim any number of samples. asammdf does not exist in a browser.
"""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Callable
from datetime import UTC
from math import nan
from typing import Any, Final, TypeVar

from asammdf import MDF

from mikas.cancellation import check_cancelled
from mikas.errors import ForeignLogError, MikasError
from mikas.foreign_logs.choice import LogChoice, LogPreview, PreviewColumn
from mikas.foreign_logs.table import (
    MOST_CELLS,
    ForeignLog,
    ForeignMark,
    ForeignProblem,
    TableBuilder,
    unique,
)
from mikas.foreign_logs.wanted import taken_of
from mikas.i18n import Text

T = TypeVar("T")

FORMAT: Final = "mdf"
_HEADER_AT: Final = 64
_AT: Final = re.compile(r"<[\w.]+ object at 0x[0-9a-fA-F]+>")  # the bytes, as asammdf names them
_MASTERS: Final = (2, 3)  # types of a channel that is the time of its group
_MOST_MARKS: Final = 10_000


def preview(data: bytes, name: str) -> LogPreview:
    """Return what the log has. Raises `ForeignLogError`, `MissingExtra`."""
    return _guarded(data, name, lambda mdf: _preview(mdf, name))


def read(data: bytes, name: str, choice: LogChoice) -> ForeignLog:
    """Return the table. Raises `ForeignLogError`, `MissingExtra`."""
    return _guarded(data, name, lambda mdf: _read(mdf, name, choice))


def _guarded(data: bytes, name: str, work: Callable[[MDF], T]) -> T:
    """Return the result of `work` on the opened file."""
    if data[8:9] != b"4":
        raise ForeignLogError(name, _VERSION, offset=8)
    if data[_HEADER_AT : _HEADER_AT + 4] != b"##HD":
        raise ForeignLogError(name, _CUT, offset=_HEADER_AT)
    try:
        mdf = MDF(io.BytesIO(data))
        try:
            return work(mdf)
        finally:
            mdf.close()
    except MikasError:
        raise
    except Exception as error:  # asammdf raises anything at a damaged file
        why = _AT.sub(name, f"{type(error).__name__}: {error}")[:200]
        problem = Text(
            f"can't be read as MDF4 ({why}): copy it again, or save the log as CSV",
            f"не читается как MDF4 ({why}): скопируйте ещё раз или сохраните лог как CSV",
        )
        raise ForeignLogError(name, problem) from error


def _channels(mdf: MDF, name: str) -> list[tuple[str, str, int, int]]:
    """Return name, unit, group and index of each channel but the times."""
    found, cells = [], 0
    groups: list[Any] = list(mdf.groups)
    for group_at, group in enumerate(groups):
        check_cancelled()
        rows = int(group.channel_group.cycles_nr)
        cells += rows * (1 + len(group.channels))
        if cells > MOST_CELLS:
            raise ForeignLogError(name, _TOO_MANY)
        for at, channel in enumerate(group.channels):
            if channel.channel_type not in _MASTERS:
                conversion = channel.conversion
                unit = channel.unit or (conversion.unit if conversion is not None else "")
                found.append((channel.name, unit or "", group_at, at))
    return found


def _preview(mdf: MDF, name: str) -> LogPreview:
    channels = _channels(mdf, name)
    names = unique(channel[0] for channel in channels)
    columns = (
        PreviewColumn(it, unit, ()) for it, (_, unit, _, _) in zip(names, channels, strict=True)
    )
    return LogPreview(FORMAT, tuple(columns))


def _read(mdf: MDF, name: str, choice: LogChoice) -> ForeignLog:
    channels = _channels(mdf, name)
    places = dict(zip(unique(it[0] for it in channels), channels, strict=True))
    wanted = taken_of({it: unit for it, (_, unit, _, _) in places.items()}, choice.columns, name)
    problems: list[ForeignProblem] = []
    taken: list[tuple[str, str]] = []
    series: list[dict[float, float]] = []
    clocks: Counter[float] = Counter()
    for title, unit in wanted:
        check_cancelled()
        _, _, group, at = places[title]
        signal = mdf.get(group=group, index=at)
        if signal.samples.ndim != 1 or signal.samples.dtype.kind not in "biuf":
            problems.append(ForeignProblem(Text(
                f"{title}: no numbers, left out", f"{title}: не числа, пропущен"
            )))  # fmt: skip
            continue
        times, values = signal.timestamps.tolist(), signal.samples.astype(float).tolist()
        taken.append((title, unit))
        series.append(dict(zip(times, values, strict=True)))
        clocks.update(dict.fromkeys(times, 1))
        if len(clocks) * (1 + len(taken)) > MOST_CELLS:
            raise ForeignLogError(name, _TOO_MANY)
    table = TableBuilder(name, taken)
    for time in sorted(clocks):
        table.add(time, [column.get(time, nan) for column in series])
    table.check(problem=_EMPTY)
    started = mdf.start_time
    is_dated = started is not None and started.year > 1970
    return ForeignLog(
        name,
        FORMAT,
        table.times,
        table.columns(),
        started.astimezone(UTC) if is_dated else None,
        _marks(mdf),
        (*problems, *table.skipped()),
    )


def _marks(mdf: MDF) -> tuple[ForeignMark, ...]:
    events: list[Any] = list(mdf.events)[:_MOST_MARKS]
    marks = (ForeignMark(float(event.value), event.name or event.comment) for event in events)
    return tuple(sorted(marks, key=lambda mark: mark.time))


_VERSION: Final = Text(
    "an MDF file of another version than 4: save it as MDF 4 or as CSV",
    "это MDF не версии 4: сохраните лог как MDF 4 или CSV",
)
_CUT: Final = Text(
    "the header is cut or damaged: copy it again, or save the log as CSV",
    "заголовок оборван или повреждён: скопируйте ещё раз или сохраните лог как CSV",
)
_TOO_MANY: Final = Text(
    f"more than {MOST_CELLS:,} values: save a part of the log as a file of its own",
    f"больше {MOST_CELLS:,} значений: сохраните часть лога отдельным файлом",
)
_EMPTY: Final = Text(
    "no channel with numbers in it: choose others",
    "нет ни одного канала с числами: выберите другие",
)
