"""Logs of other programs: a `ForeignLogError`, or a table whose columns are whole.

Input: the file. Its first bytes say what it is; all else is read as CSV and as .msl, with the
settings that the preview found and with the first column as a time of every kind. MDF4 is asammdf's
to read, and not asked for here.
"""

from __future__ import annotations

from itertools import pairwise
from math import isfinite, isinf
from typing import Final

from mikas.errors import ForeignLogError
from mikas.foreign_logs import (
    TIME_UNITS,
    LogChoice,
    LogPreview,
    TextSettings,
    preview_log,
    read_log,
)

WORDS: Final = (
    *(
        "Time (s)",
        "Time (msec)",
        "\xc2\xf0\xe5\xec\xff",
        "MARK 000 - ",
        '"Capture Date: ',
        "\t",
        ";",
        ",",
        "|",
    ),
    *("1,5", "-0.25", "NaN", "1e999", "23:59:59.9", "2026-05-09 10:00:00+03:00", "31.12.2026 "),
    *("MLVLG\0\0\1", "MLVLG\0\0\2", "\0\0", "\xef\xbb\xbf", "\xff\xfe", '"', "\r\n"),
)


def check(data: bytes) -> None:
    if data.startswith((b"MDF     ", b"UnFinMF ")):
        return
    for name in ("log.csv", "log.msl"):
        preview = _preview(data, name)
        if preview is None:
            continue
        _read(data, name, LogChoice())
        if preview.layout is None or not preview.columns:
            continue
        found = preview.layout
        settings = TextSettings(found.encoding, found.delimiter, found.decimal)
        for unit in TIME_UNITS:
            _read(data, name, LogChoice(settings, preview.columns[0].name, unit))


def _preview(data: bytes, name: str) -> LogPreview | None:
    try:
        preview = preview_log(data, name)
    except ForeignLogError as error:
        _check_error(error, data)
        return None
    names = [column.name for column in preview.columns]
    assert len(names) == len(set(names))
    return preview


def _read(data: bytes, name: str, choice: LogChoice) -> None:
    try:
        log = read_log(data, name, choice)
    except ForeignLogError as error:
        _check_error(error, data)
        return
    assert len(log) > 0
    assert all(isfinite(time) for time in log.times)
    assert all(one <= two for one, two in pairwise(log.times))
    for column in log.columns:
        assert len(column.values) == len(log)
        assert not any(map(isinf, column.values))
    for problem in log.problems:
        assert problem.text.en
        assert problem.text.ru


def _check_error(error: ForeignLogError, data: bytes) -> None:
    assert error.problem.en
    assert error.problem.ru
    assert error.line is None or 1 <= error.line <= data.count(b"\n") + data.count(b"\r") + 1
    assert error.offset is None or 0 <= error.offset <= len(data)
