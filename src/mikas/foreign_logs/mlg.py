"""MegaLogViewer's binary log, versions 1 and 2 (EFI Analytics, “MLG Binary Log Format”).

Numbers are big-endian. A value is scale × (raw + transform). Scales and 32-bit floats are taken as
the shortest decimal number that they stand for: a scale of 0.001 is 0.001, and 13.7 stays 13.7.

    header   4D 4C 56 4C 47 00, version, UNIX time, where the info is (16 or 32 bits), where the
             data begins, bytes in a record, number of fields
    field    type, name (34), unit (10), style, then scale, transform, digits (bit fields: style,
             place of the names, bits, 3 unused); version 2: category (34)
    block    00, counter, 16 bits of a 10 µs clock, the fields, the sum of their bytes
    marker   01, the same counter and clock, its words (50), no sum
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, isnan, nan
from typing import Final

from mikas.cancellation import check_cancelled
from mikas.errors import ForeignLogError
from mikas.foreign_logs.choice import LogChoice, LogPreview, PreviewColumn
from mikas.foreign_logs.table import (
    ForeignLog,
    ForeignMark,
    ForeignProblem,
    TableBuilder,
    date_of,
    unique,
)
from mikas.foreign_logs.times import UNITS, unit_spelt
from mikas.foreign_logs.wanted import taken_of
from mikas.i18n import Text

MAGIC: Final = b"MLVLG\0"
MLG: Final = "mlg"
_HEADERS: Final = {1: struct.Struct(">6sHIHIHH"), 2: struct.Struct(">6sHIIIHH")}
_FIELD: Final = struct.Struct(">B34s10sB9s")
_SCALAR: Final = struct.Struct(">ffb")
_CATEGORY: Final = 34
_CODES: Final = {
    0: "B", 1: "b", 2: "H", 3: "h", 4: "I", 5: "i", 6: "q", 7: "f", 10: "B", 11: "H", 12: "I",
}  # fmt: skip
"""The code of `struct` for each type; from 10 on bits, whose number is the value."""
_SINGLE: Final = 7
_BITS: Final = 10
_BLOCK: Final = struct.Struct(">BBH")
_WORDS: Final = 50
_TICKS: Final = 100_000  # of the blocks' clock in a second
_EACH: Final = 4096
_MOST_KEPT: Final = 1 << 16
_MOST_MARKS: Final = 10_000


@dataclass(frozen=True, slots=True)
class MlgField:
    """One field of each record."""

    name: str
    unit: str
    code: str
    single: bool
    scale: float
    transform: float


@dataclass(frozen=True, slots=True)
class MlgHead:
    """What the header says. `begins`: the first block's offset; `record`: bytes of the fields."""

    fields: tuple[MlgField, ...]
    begins: int
    record: int
    started: int


def preview(data: bytes, name: str) -> LogPreview:
    """Return what the log has. Raises `ForeignLogError`."""
    head = _head_of(data, name)
    time = _time_at(head)
    columns = tuple(
        PreviewColumn(it.name, it.unit, ()) for at, it in enumerate(head.fields) if at != time
    )
    return LogPreview(MLG, columns)


def read(data: bytes, name: str, choice: LogChoice) -> ForeignLog:
    """Return the table. Raises `ForeignLogError`."""
    head = _head_of(data, name)
    time = _time_at(head)
    named = {it.name: (at, it.unit) for at, it in enumerate(head.fields) if at != time}
    taken = taken_of({title: unit for title, (_, unit) in named.items()}, choice.columns, name)
    places = [named[title][0] for title, _ in taken]
    table = TableBuilder(name, taken)
    time_of = _clock() if time is None else _counted(head.fields[time], time)
    values = [_value_of(field) for field in head.fields]
    record = struct.Struct(">" + "".join(field.code for field in head.fields))
    blocks = _Blocks(data, head)
    marks: list[ForeignMark] = []
    while (block := blocks.next()) is not None:
        at, kind, clock = block
        if kind == 1:
            if len(marks) < _MOST_MARKS:
                words = _text(data[at : at + _WORDS])
                marks.append(ForeignMark(table.times[-1] if table.times else nan, words))
            continue
        raw = record.unpack_from(data, at)
        table.add(time_of(raw, clock), [values[place](raw[place]) for place in places])
    problems = blocks.problems()
    table.check(problem=problems[0].text if problems else _NO_RECORDS)
    first = table.times[0]
    return ForeignLog(
        name,
        MLG,
        table.times,
        table.columns(),
        date_of(head.started) if head.started else None,
        tuple(ForeignMark(first if isnan(it.time) else it.time, it.text) for it in marks),
        (*problems, *table.skipped()),
    )


def _head_of(data: bytes, name: str) -> MlgHead:
    if not data.startswith(MAGIC) or len(data) < 8:
        raise ForeignLogError(name, _NO_MLG, offset=0)
    version = int.from_bytes(data[6:8], "big")
    header = _HEADERS.get(version)
    if header is None:
        problem = Text(
            f"version {version} of the format is unknown; 1 and 2 are known: save it as .msl",
            f"версия формата {version} неизвестна, известны 1 и 2: сохраните лог как .msl",
        )
        raise ForeignLogError(name, problem, offset=6)
    if len(data) < header.size:
        raise ForeignLogError(name, _CUT, offset=len(data))
    _, _, started, _, begins, record, count = header.unpack_from(data)
    size = _FIELD.size + (_CATEGORY if version == 2 else 0)
    if header.size + count * size > min(begins, len(data)):
        raise ForeignLogError(name, _CUT, offset=min(len(data), header.size))
    read = [_field(data, header.size + at * size, name) for at in range(count)]
    names = unique(field.name for field in read)
    fields = tuple(
        MlgField(title, it.unit, it.code, it.single, it.scale, it.transform)
        for title, it in zip(names, read, strict=True)
    )
    if (least := sum(struct.calcsize(field.code) for field in fields)) != record:
        problem = Text(
            f"a record has {record} bytes, its fields {least}: the file is damaged",
            f"в записи {record} байт, а в её полях {least}: файл повреждён",
        )
        raise ForeignLogError(name, problem, offset=header.size - 4)
    if not fields:
        raise ForeignLogError(name, _CUT, offset=header.size - 2)
    return MlgHead(fields, begins, record, started)


def _field(data: bytes, at: int, name: str) -> MlgField:
    kind, title, unit, _, rest = _FIELD.unpack_from(data, at)
    code = _CODES.get(kind)
    if code is None:
        problem = Text(
            f"a field of the unknown type {kind}: the file is damaged",
            f"поле неизвестного типа {kind}: файл повреждён",
        )
        raise ForeignLogError(name, problem, offset=at)
    scale, transform = 1.0, 0.0
    if kind < _BITS:
        scale, transform, _ = _SCALAR.unpack(rest)
        scale, transform = shortest(scale), shortest(transform)
    return MlgField(_text(title), _text(unit), code, kind == _SINGLE, scale, transform)


def _text(data: bytes) -> str:
    """Return the words before the first zero, in UTF-8, else in Windows-1251."""
    words = data.split(b"\0", 1)[0]
    try:
        text = words.decode("utf-8")
    except UnicodeDecodeError:
        text = words.decode("windows-1251", "replace")
    return " ".join("".join(each if each.isprintable() else " " for each in text).split())


def shortest(single: float) -> float:
    """Return the shortest decimal number that rounds to this 32-bit float."""
    if not isfinite(single):
        return nan
    for digits in range(6, 9):
        number = float(f"{single:.{digits}g}")
        if struct.pack(">f", number) == struct.pack(">f", single):
            return number
    return float(f"{single:.9g}")


def _time_at(head: MlgHead) -> int | None:
    """Return the field of the time; None: only the blocks' clock counts."""
    for at, field in enumerate(head.fields):
        if field.name.casefold() == "time" and (not field.unit or unit_spelt(field.unit)):
            return at
    return None


def _value_of(field: MlgField) -> Callable[[float], float]:
    scale, transform = field.scale, field.transform
    divisor = round(1 / scale) if 0 < abs(scale) < 1 else 0
    if divisor and 1 / divisor == scale:  # 0.001: a division has no error of its own

        def divided(raw: float) -> float:
            return (raw + transform) / divisor

        return divided
    if not field.single:
        return lambda raw: (raw + transform) * scale
    known: dict[float, float] = {}

    def of_single(raw: float) -> float:
        value = known.get(raw)
        if value is None:
            if len(known) >= _MOST_KEPT:
                known.clear()
            value = known[raw] = (shortest(raw) + transform) * scale
        return value

    return of_single


def _counted(field: MlgField, at: int) -> Callable[[tuple[float, ...], int], float]:
    value, factor = _value_of(field), UNITS[unit_spelt(field.unit) or "s"]
    return lambda raw, _: value(raw[at]) * factor


def _clock() -> Callable[[tuple[float, ...], int], float]:
    """Return what goes on with the blocks' clock, whose 16 bits begin again after 0.66 s."""
    total, last = 0, -1

    def time(_: tuple[float, ...], clock: int) -> float:
        nonlocal total, last
        total += 0 if last < 0 else (clock - last) % 65536
        last = clock
        return total / _TICKS

    return time


class _Blocks:
    """The blocks of a file, until its end or the first that is none."""

    def __init__(self, data: bytes, head: MlgHead) -> None:
        self._data, self._record = data, head.record
        self._at = head.begins
        self._count, self._wrong = 0, 0
        self._wrong_at = self._ended_at = -1

    def next(self) -> tuple[int, int, int] | None:
        """Return (offset of its content, kind, clock) of the next sound block; None: the end."""
        data = self._data
        while self._at < len(data):
            self._count += 1
            if self._count % _EACH == 0:
                check_cancelled()
            at = self._at + _BLOCK.size
            if at > len(data) or data[self._at] > 1:
                break
            kind, _, clock = _BLOCK.unpack_from(data, self._at)
            end = at + (_WORDS if kind else self._record + 1)
            if end > len(data):
                break
            begin, self._at = self._at, end
            if not kind and sum(data[at : end - 1]) & 0xFF != data[end - 1]:
                self._wrong += 1
                self._wrong_at = begin if self._wrong_at < 0 else self._wrong_at
                continue
            return at, kind, clock
        else:
            return None
        self._ended_at = self._at
        return None

    def problems(self) -> list[ForeignProblem]:
        """Return what was left out."""
        found = []
        if self._wrong:
            found.append(ForeignProblem(Text(
                f"records with a wrong checksum, left out: {self._wrong}, the first at byte "
                f"{self._wrong_at}",
                f"записи с неверной контрольной суммой, пропущены: {self._wrong}, первая — байт "
                f"{self._wrong_at}",
            )))  # fmt: skip
        if self._ended_at >= 0:
            found.append(ForeignProblem(Text(
                f"the file is cut or damaged at byte {self._ended_at}: the rest was left out",
                f"файл оборван или повреждён на байте {self._ended_at}: остаток пропущен",
            )))  # fmt: skip
        return found


_NO_MLG: Final = Text(
    "not a MegaLogViewer log (.mlg): it does not begin with MLVLG",
    "это не лог MegaLogViewer (.mlg): он не начинается с MLVLG",
)
_NO_RECORDS: Final = Text(
    "there are no records in it: nothing was logged", "в нём нет записей: ничего не записано"
)
_CUT: Final = Text(
    "the header is cut or damaged: copy the file again, or save the log as .msl or .csv",
    "заголовок оборван или повреждён: скопируйте файл ещё раз или сохраните лог как .msl или .csv",
)
