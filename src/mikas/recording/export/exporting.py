"""Writing a table to a file in the format of its suffix.

A file is written as `OUT.part` and renamed when it is whole and on the disk: a file called OUT is
complete. After an error the part is removed; only a killed program leaves it. Rows are read and
written in stretches: ten hours need no more memory than one.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from mikas.errors import ExportError, MikasError, MissingExtra, reason_of
from mikas.i18n import Language, Text
from mikas.recording.export.dialect import PLAIN, Dialect
from mikas.recording.table.channels import Channel, Rows

if TYPE_CHECKING:
    from mikas.recording.export.sheet import Sheet
    from mikas.sampling.events import Event

TIME = "time"  # the column of every format; no channel may have this name


class _Format(NamedTuple):
    name: str
    module: str
    extra: str = ""
    library: str = ""  # of the extra


_FORMATS = {
    ".csv": _Format("CSV", "csv"),
    ".mf4": _Format("MDF4", "mdf", "mdf", "asammdf"),
    ".parquet": _Format("Parquet", "parquet", "parquet", "duckdb"),
    ".msl": _Format("MegaLogViewer", "msl"),
    ".mlg": _Format("MegaLogViewer", "mlg"),
}

SUFFIXES = tuple(_FORMATS)


@dataclass(frozen=True, slots=True)
class Result:
    """The number of rows that were written, their channels, the file."""

    rows: int
    channels: tuple[str, ...]
    out: Path


def export(
    out: Path,
    channels: Sequence[Channel],
    rows: Iterable[Rows],
    *,
    events: Iterable[Event] = (),
    start: float | None = None,
    started: datetime | None = None,
    about: Mapping[str, str] | None = None,
    language: Language = "en",
    dialect: Dialect = PLAIN,
    overwrite: bool = False,
) -> Result:
    """Write `rows` to `out`, in the format of its suffix.

    `start`: the link's time that is zero in the file; by default the first row's.
    `started`: the date and time of `start`, with its time zone; by default taken from `start`, if
    that plainly counts from 1970, and else unknown.
    `about`: facts of the recording (unit, passport, catalog), by title.
    `events`: of the recording; markers, notes, gaps and alarms are in every format but CSV.
    `language`: of the texts in a CSV's header line and of the marks in MegaLogViewer's formats; all
    else has both.
    `dialect`: of a CSV.
    A channel that a stretch lacks is missing in its rows.

    Raises `ExportError` (unknown suffix, OUT exists already, can't be written) or `MissingExtra`.
    """
    form = _format(out)
    _check(out, channels, overwrite=overwrite)
    if form.library:
        _need(form.library, form.extra, form.name)
    from mikas.recording.export.sheet import sheet_of

    sheet = sheet_of(
        channels,
        rows,
        events,
        start=start,
        started=started,
        about=about or {},
        language=language,
        dialect=dialect,
    )
    _write(out, import_module(f"mikas.recording.export.{form.module}").write, sheet, overwrite)
    return Result(sheet.stretches.rows, tuple(channel.name for channel in channels), out)


def _format(out: Path) -> _Format:
    if form := _FORMATS.get(out.suffix.lower()):
        return form
    known = " ".join(SUFFIXES)
    raise ExportError(
        str(out),
        Text(
            f"the format is taken from the suffix, which must be one of {known}",
            f"формат определяется расширением: {known}",
        ),
    )


def _check(out: Path, channels: Sequence[Channel], *, overwrite: bool) -> None:
    if not overwrite and os.path.lexists(out):
        raise _already_there(out)
    if not channels:
        raise ExportError(str(out), _NO_CHANNELS)
    names = [TIME]
    for channel in channels:
        if (name := channel.name.casefold()) in names:
            problem = Text("two columns would be called {name}", "два столбца с именем {name}")
            raise ExportError(str(out), problem.filled(name=channel.name))
        names.append(name)


def _already_there(out: Path) -> ExportError:
    return ExportError(
        str(out),
        Text(
            "the file is there already; give another name, or say that it may be overwritten",
            "файл уже есть; дайте другое имя или разрешите перезаписать",
        ),
    )


def _need(library: str, extra: str, feature: str) -> None:
    try:
        import_module(library)
    except ImportError as error:
        raise MissingExtra(feature=feature, extra=extra) from error


def _write(out: Path, write: Callable[[Path, Sheet], None], sheet: Sheet, overwrite: bool) -> None:
    part = out.with_name(out.name + ".part")
    try:
        try:
            write(part, sheet)
            with part.open("rb+") as file:
                os.fsync(file.fileno())
            if not overwrite and os.path.lexists(out):  # made by another program meanwhile
                raise _already_there(out)
            part.replace(out)
        finally:
            # After the rename there is none. An error here would hide the one that led here.
            _remove(part)
    except MikasError:  # some are OSErrors as well: errors of the recording itself
        raise
    except OSError as error:
        problem = Text("can't be written: {why}", "не записать: {why}")
        raise ExportError(str(out), problem.filled(why=reason_of(error))) from error


def _remove(part: Path) -> None:
    try:
        part.unlink(missing_ok=True)
    except OSError:
        return


_NO_CHANNELS = Text(
    "there are no channels to write: no parameter was read in this recording, or what was asked "
    "is lost; `mikas decode FILE` shows what it holds, and `mikas log -o FILE.pcapng` (or key R on "
    "the Live screen) makes one with values",
    "нет каналов для записи: параметры в этой записи не читались, или запросы к ним потеряны; "
    "`mikas decode ФАЙЛ` покажет, что в ней есть, а запись со значениями делает "
    "`mikas log -o ФАЙЛ.pcapng` (или клавиша R на экране «Приборы»)",
)
