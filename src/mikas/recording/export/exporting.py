"""Write a table to a file in the format of its suffix.

The file is written as `OUT.part` and renamed when it is complete and on the disk. After an error
the part is removed; only a killed program leaves it. Rows are read and written in stretches, so ten
hours need no more memory than one.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.errors import ExportError, MikasError, reason_of
from mikas.i18n import Language, Text
from mikas.recording.export.formats import PLAIN, Dialect, format_of, require_library
from mikas.recording.table.channels import Channel, Rows

if TYPE_CHECKING:
    from mikas.recording.export.sheet import Sheet
    from mikas.sampling.events import Event

TIME = "time"  # a column of every format; no channel may have this name


@dataclass(frozen=True, slots=True)
class Result:
    """The number of rows written, their channels, the file."""

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
    `started`: the date and time of `start`, with a time zone; by default `start` itself if that
    counts from 1970, otherwise unknown.
    `about`: facts of the recording (unit, passport, catalog), by title.
    `events`: of the recording; all formats but CSV keep markers, notes, gaps and alarms.
    `language`: of a CSV's header line and of the marks in MegaLogViewer's formats; everything else
    is in both languages.
    `dialect`: of a CSV.
    A channel that a stretch lacks is missing in its rows.

    Raises `ExportError` (unknown suffix, OUT exists, can't be written) or `MissingExtra`.
    """
    wanted = format_of(out)
    _check(out, channels, overwrite=overwrite)
    require_library(wanted)
    from mikas.recording.export.sheet import Sheet

    sheet = Sheet(
        channels,
        rows,
        events,
        start=start,
        started=started,
        about=about or {},
        language=language,
        dialect=dialect,
    )
    _write(out, import_module(f"mikas.recording.export.{wanted.module}").write, sheet, overwrite)
    return Result(sheet.stretches.rows, tuple(channel.name for channel in channels), out)


def _check(out: Path, channels: Sequence[Channel], *, overwrite: bool) -> None:
    if not overwrite and os.path.lexists(out):
        raise ExportError(str(out), _EXISTS)
    if not channels:
        raise ExportError(str(out), _NO_CHANNELS)
    names = [TIME]
    for channel in channels:
        if (name := channel.name.casefold()) in names:
            problem = Text("two columns would be called {name}", "два столбца с именем {name}")
            raise ExportError(str(out), problem.filled(name=channel.name))
        names.append(name)


def _write(out: Path, write: Callable[[Path, Sheet], None], sheet: Sheet, overwrite: bool) -> None:
    part = out.with_name(out.name + ".part")
    try:
        try:
            write(part, sheet)
            with part.open("rb+") as file:
                os.fsync(file.fileno())
            if not overwrite and os.path.lexists(out):  # another program created it meanwhile
                raise ExportError(str(out), _EXISTS)
            part.replace(out)
        finally:
            with suppress(OSError):  # an error here would hide the first one
                part.unlink(missing_ok=True)
    except MikasError:  # some are OSErrors as well: errors of the recording itself
        raise
    except OSError as error:
        problem = Text("can't be written: {why}", "не удаётся записать: {why}")
        raise ExportError(str(out), problem.filled(why=reason_of(error))) from error


_EXISTS = Text(
    "the file is there already; give another name or allow overwriting",
    "файл уже есть; дайте другое имя или разрешите перезаписать",
)
_NO_CHANNELS = Text(
    "there are no channels to write: no parameter was read in this recording, or the requests are "
    "lost; `mikas decode FILE` shows its contents, and `mikas log -o FILE.pcapng` (or key R on the "
    "Live screen) makes a recording with values",
    "нет каналов для записи: параметры в этой записи не читались, или запросы к ним потеряны; "
    "`mikas decode ФАЙЛ` покажет, что в ней есть, а запись со значениями делает "
    "`mikas log -o ФАЙЛ.pcapng` (или клавиша R на экране «Приборы»)",
)
