"""One door to every format: what to write is taken from OUT's suffix.

A file is written beside its place, as `OUT.part`, and renamed when it is whole and on the disk:
what is called OUT is complete. Whatever goes wrong, the part is removed; only a killed program
leaves it. Rows come in stretches and go out in stretches: ten hours need no more memory than one.
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

TIME = "time"  # the column that every format has; no channel may be called so


class _Format(NamedTuple):
    name: str
    module: str
    extra: str
    library: str


_FORMATS = {
    ".csv": _Format("CSV", "comma_separated", "numpy", "numpy"),
    ".mf4": _Format("MDF4", "mdf", "mdf", "asammdf"),
    ".parquet": _Format("Parquet", "parquet", "parquet", "duckdb"),
    ".msl": _Format("MegaLogViewer", "msl", "numpy", "numpy"),
    ".mlg": _Format("MegaLogViewer", "mlg", "numpy", "numpy"),
}

SUFFIXES = tuple(_FORMATS)


@dataclass(frozen=True, slots=True)
class Result:
    """What was written: how many rows, which channels, where."""

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

    `start`: the link's time that is zero in the file; unless given, the first row's.
    `started`: what a calendar said then, with its time zone; unless given, it is taken from `start`
    where that plainly counts from 1970, and else left unknown.
    `about`: what a reader should know of the recording (unit, passport, catalog), by its title.
    `events`: a recording's; its markers, notes, gaps and alarms stand in every format but CSV.
    `language`: of the texts in a CSV's one header line and of the marks in MegaLogViewer's formats;
    all else holds both.
    `dialect`: how a CSV is spelled.
    A channel that a stretch lacks is missing in its rows.

    Raises `ExportError` (unknown suffix, OUT is there already, can't be written) or `MissingExtra`.
    """
    form = _format(out)
    _check(out, channels, overwrite=overwrite)
    _need("numpy", "numpy", form.name)
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
            if not overwrite and os.path.lexists(out):  # it came while we were writing
                raise _already_there(out)
            part.replace(out)
        finally:
            # Gone after the rename. Should it not go away, the error that led here matters more.
            _remove(part)
    except MikasError:  # some are OSErrors as well: the recording's own troubles, told already
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
