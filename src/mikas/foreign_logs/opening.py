"""Open another program's log: by its content, then by its suffix.

    log = mikas.open_log("innovate.csv", time="Time", time_unit="s")
    log["AFR"].values, log["AFR"].unit
    frame = log.to_pandas()

`preview_log` and `read_log` do the same with bytes, for a dialog of columns.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path

from mikas.errors import ForeignLogError, UnfitFile, library, naming_file
from mikas.files import read_regular
from mikas.foreign_logs import delimited, mlg
from mikas.foreign_logs.choice import LogChoice, LogPreview
from mikas.foreign_logs.layout import TextSettings
from mikas.foreign_logs.table import MOST_BYTES, TOO_LARGE, ForeignLog, check_size
from mikas.i18n import Text

_MDF = (b"MDF     ", b"UnFinMF ")
_OURS = (b"\n\r\r\n",)  # pcapng
_PACKED = (b"PK\x03\x04", b"\x1f\x8b", b"BZh", b"\xfd7zXZ", b"\x28\xb5\x2f\xfd")


def open_log(
    path: str | os.PathLike[str],
    *,
    time: str | None = None,
    time_unit: str | None = None,
    columns: Mapping[str, str | None] | Iterable[str] | None = None,
    encoding: str | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
    names_line: int | None = None,
    units_line: int | None = None,
) -> ForeignLog:
    """Read another program's log: CSV, MegaLogViewer's .msl and .mlg, or MDF4 (`mikas[mdf]`).

    Columns keep their own names and units; nothing becomes a channel of ours. Of a CSV whose file
    leaves it open, say the column of the `time` and its unit: s, ms, us, min, h, d, clock, date
    (2026-05-09 or 09.05.2026), date-dmy or date-mdy (with slashes). `columns`: those to take, all
    by default; a mapping gives units as well. `encoding` (utf-8, windows-1251, utf-16,
    windows-1252), `delimiter`, `decimal`, `names_line` and `units_line` (from 1; 0: none) are
    recognised if they are not given.

    Raises `ForeignLogError`, which has the line or the byte, `UsageError` for a file that the
    system refuses, `MissingExtra`.
    """
    path = Path(path)
    with naming_file(path):
        try:
            data = read_regular(path, MOST_BYTES, follow=True)
        except UnfitFile as error:
            if path.is_file() and path.stat().st_size > MOST_BYTES:
                raise ForeignLogError(path.name, TOO_LARGE) from error
            raise
    if columns is not None and not isinstance(columns, Mapping):
        columns = dict.fromkeys([columns] if isinstance(columns, str) else columns)
    text = TextSettings(encoding, delimiter, decimal, names_line, units_line)
    return read_log(data, path.name, LogChoice(text, time, time_unit, columns))


def preview_log(data: bytes, name: str, settings: TextSettings | None = None) -> LogPreview:
    """Return what a log has: its columns, and how a log of text is laid out.

    Raises `ForeignLogError`, `MissingExtra`.
    """
    kind = format_of(data, name)
    if kind == mlg.MLG:
        return mlg.preview(data, name)
    if kind == "mdf":
        library("asammdf", feature="MDF4", extra="mdf")
        from mikas.foreign_logs import mdf  # not in a browser

        return mdf.preview(data, name)
    return delimited.preview(data, name, kind, settings or TextSettings())


def read_log(data: bytes, name: str, choice: LogChoice | None = None) -> ForeignLog:
    """Return a log as a table, `name` is the file's. Raises `ForeignLogError`, `MissingExtra`."""
    choice = choice or LogChoice()
    kind = format_of(data, name)
    if kind == mlg.MLG:
        return mlg.read(data, name, choice)
    if kind == "mdf":
        library("asammdf", feature="MDF4", extra="mdf")
        from mikas.foreign_logs import mdf  # not in a browser

        return mdf.read(data, name, choice)
    return delimited.read(data, name, kind, choice)


def format_of(data: bytes, name: str) -> str:
    """Return csv, msl, mlg or mdf. Raises `ForeignLogError` for any other format."""
    check_size(name, data)
    if data.startswith(mlg.MAGIC):
        return mlg.MLG
    if data.startswith(_MDF):
        return "mdf"
    if data.startswith(_OURS):
        raise ForeignLogError(
            name,
            Text(
                "a recording of mikas itself (.pcapng): open it as one",
                "это запись самой программы (.pcapng): откройте её как запись",
            ),
        )
    if data.startswith(_PACKED):
        raise ForeignLogError(
            name, Text("a packed file: unpack it first", "файл сжат: сначала распакуйте его")
        )
    suffix = name.lower().rpartition(".")[2]
    if suffix in ("mlg", "mf4"):
        raise ForeignLogError(
            name,
            Text(
                f"not a .{suffix}, by its first bytes: copy the file again",
                f"по первым байтам это не .{suffix}: скопируйте файл ещё раз",
            ),
            offset=0,
        )
    return delimited.MSL if suffix == "msl" else delimited.CSV
