"""Write a table to a file in the format of its suffix, or, in CSV, of a dialect.

Other distributions bring formats through the entry-point group `mikas.exports`: an entry's name is
the suffix without its dot, its object the `Writer`.

The file is written as `OUT.part` and renamed when it is complete and on the disk. After an error
the part is removed; only a killed program leaves it. Rows are read and written in batches, so ten
hours need no more memory than one.
"""

from __future__ import annotations

import errno
import inspect
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, cast

from mikas.distributions import entries_of, loaded, unfit
from mikas.errors import (
    ExportError,
    MikasError,
    library,
    reason_of,
    system_error,
)
from mikas.files import beside
from mikas.i18n import Language, Text
from mikas.options import with_nearest
from mikas.recording.export.dialects import PLAIN, Dialect
from mikas.recording.table.channels import Channel, Rows

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from mikas.recording.export.sheet import Sheet
    from mikas.recording.recording import Recording
    from mikas.sampling.events import Event

POSITION: Final = ("GPS_LAT", "GPS_LON", "GPS_ALT", "GPS_SPEED", "GPS_COURSE")
"""The channels of a receiver, less their labels, that a track needs or has a place for."""
TIME = "time"  # a column of every format; no channel may have this name


Writer = Callable[[Path, "Sheet"], object]
"""Writes the whole sheet to the path: of an empty file, which then becomes OUT."""


class Format(NamedTuple):
    """A format's name, its module here, and the library that the extra `mikas[extra]` installs.

    `entries`: what brings it instead, if another distribution does.
    """

    name: str
    module: str = ""
    extra: str = ""
    library: str = ""
    entries: tuple[EntryPoint, ...] = ()

    @property
    def is_track(self) -> bool:
        """Whether it is the way of the car."""
        return f".{self.module}" in TRACKS


GROUP: Final = "mikas.exports"

_FORMATS = {
    ".csv": Format("CSV", "csv"),
    ".mf4": Format("MDF4", "mdf", "mdf", "asammdf"),
    ".parquet": Format("Parquet", "parquet", "parquet", "duckdb"),
    ".msl": Format("MegaLogViewer", "megalogviewer"),
    ".mlg": Format("MegaLogViewer", "mlg"),
}
_TRACKS = {
    ".gpx": Format("GPX", "gpx"),
    ".geojson": Format("GeoJSON", "geojson"),
}

SUFFIXES = tuple(_FORMATS)
"""Those of tables."""
TRACKS = tuple(_TRACKS)
"""Those of the way of the car: they need a recorded GPS."""


def formats() -> tuple[str, ...]:
    """Return the names of all formats, `csv` first, those of other distributions last."""
    own = [suffix[1:] for suffix in (*SUFFIXES, *TRACKS)]
    return (*own, *sorted(entries_of(GROUP).keys() - set(own)))


def format_of(out: Path, name: str | None = None) -> Format:
    """Return the format `name`, or that of the suffix. Raises `ExportError` for an unknown one."""
    wanted = (out.suffix[1:] if name is None else name.removeprefix(".")).lower()
    brought = entries_of(GROUP).get(wanted, [])
    own = _FORMATS.get(f".{wanted}") or _TRACKS.get(f".{wanted}")
    if own is None and brought:
        return Format(wanted, entries=tuple(brought))
    if own is not None:
        if brought:
            raise unfit(wanted, brought, _TAKEN)
        return own
    if name is not None:
        known = ", ".join(formats())
        raise ExportError(
            str(out),
            with_nearest(
                Text(
                    f"there is no format “{name}”; there are: {known}",
                    f"формата «{name}» нет; есть: {known}",
                ),
                wanted,
                formats(),
            ),
        )
    known = " ".join(f".{each}" for each in formats())
    problem = Text(
        f"the suffix must be one of {known}: it selects the format",
        f"формат определяется расширением: {known}",
    )
    raise ExportError(str(out), problem)


def with_position(recording: Recording, names: Sequence[str]) -> list[str]:
    """Return the channels of a track: `names`, and where the car was. Without names: none, all."""
    if not names:
        return []
    place = [each for each in recording.instrument_channels if each.startswith(POSITION)]
    return list(dict.fromkeys((*names, *place)))


def require_library(wanted: Format) -> None:
    """Raise `MissingExtra` if the format's library is not installed."""
    if wanted.library:
        library(wanted.library, feature=wanted.name, extra=wanted.extra)


def _writer_of(wanted: Format) -> Writer:
    """Return what writes the format. Raises `UsageError` for another distribution's that can't."""
    if not wanted.entries:
        return cast("Writer", import_module(f"mikas.recording.export.{wanted.module}").write)
    found = loaded(wanted.name, wanted.entries)
    try:
        inspect.signature(cast("Writer", found)).bind("path", "sheet")
    except (TypeError, ValueError) as error:
        raise unfit(wanted.name, wanted.entries, _not_a_writer(error)) from error
    write = cast("Writer", found)

    def guarded(part: Path, sheet: Sheet) -> None:
        try:
            write(part, sheet)
        except (MikasError, OSError):
            raise
        except Exception as error:  # another distribution's code may raise anything
            raise unfit(wanted.name, wanted.entries, _failed(error)) from error

    return guarded


@dataclass(frozen=True, slots=True)
class Result:
    """What an export has written."""

    rows: int
    """The number of rows."""
    channels: tuple[str, ...]
    """The names of the columns."""
    out: Path
    """The file."""


def export(
    out: Path,
    channels: Sequence[Channel],
    rows: Iterable[Rows],
    *,
    events: Iterable[Event] = (),
    about: Mapping[str, str] | None = None,
    language: Language = "en",
    dialect: Dialect = PLAIN,
    overwrite: bool = False,
    format_name: str | None = None,
) -> Result:
    """Write `rows` to `out`, in the format of its suffix or in that of `format_name`.

    Times count from the first row; its date is known if the link's clock counts from 1970.
    `about`: facts of the recording (unit, passport, catalog), by title.
    `events`: of the recording; all formats but CSV keep markers, notes, gaps and alarms.
    `language`: of a CSV's header line and of the marks in MegaLogViewer's formats; everything else
    is in both languages.
    `dialect`: of a CSV.
    A channel that a stretch lacks is missing in its rows.

    Raises `ExportError` (unknown format, OUT exists, can't be written), `MissingExtra`, or
    `UsageError` for a format of another distribution that does not work.
    """
    wanted = format_of(out, format_name)
    _check(out, channels, overwrite=overwrite)
    require_library(wanted)
    write = _writer_of(wanted)
    from mikas.recording.export.sheet import Sheet

    sheet = Sheet(channels, rows, events, about or {}, language=language, dialect=dialect)
    write_whole(out, lambda part: write(part, sheet), overwrite=overwrite)
    return Result(sheet.rows, tuple(channel.name for channel in channels), out)


def _check(out: Path, channels: Sequence[Channel], *, overwrite: bool) -> None:
    check_free(out, overwrite=overwrite)
    if not channels:
        raise ExportError(str(out), _NO_CHANNELS)
    names = [TIME]
    for channel in channels:
        if (name := channel.name.casefold()) in names:
            problem = Text("two columns would be called {name}", "два столбца с именем {name}")
            raise ExportError(str(out), problem.filled(name=channel.name))
        names.append(name)


def check_free(out: Path, *, overwrite: bool) -> None:
    """Raise `ExportError` if the file exists and may not be overwritten."""
    if not overwrite and os.path.lexists(out):
        problem = Text(
            "the file is there already; give another name or allow overwriting (--overwrite)",
            "файл уже есть; дайте другое имя или разрешите перезаписать (--overwrite)",
        )
        raise ExportError(str(out), problem).caused_by(system_error(errno.EEXIST), out)


def write_whole(out: Path, write: Callable[[Path], object], *, overwrite: bool) -> None:
    """Let `write` write `OUT.part`, then rename that to `out`. Raises `ExportError`."""
    part = beside(out, ".part")
    try:
        try:
            part.unlink(missing_ok=True)  # of a killed program
            part.open("xb").close()  # the writers open it by name: it is no link to another file
            write(part)
            with part.open("rb+") as file:
                os.fsync(file.fileno())
            check_free(out, overwrite=overwrite)  # another program may have created it meanwhile
            part.replace(out)
        finally:
            with suppress(OSError):  # an error here would hide the first one
                part.unlink(missing_ok=True)
    except MikasError:  # some are OSErrors as well: errors of the recording itself
        raise
    except OSError as error:
        problem = Text("can't be written: {why}", "не удаётся записать: {why}")
        failed = ExportError(str(out), problem.filled(why=reason_of(error)))
        raise failed.caused_by(error, out) from error


_TAKEN: Final = Text(
    "has the name of a format that mikas writes itself",
    "называется так же, как формат самой программы",
)


def _not_a_writer(error: Exception) -> Text:
    return Text(
        f"is not a function of a path and a sheet ({error})",
        f"не функция с аргументами path и sheet ({error})",
    )


def _failed(error: Exception) -> Text:
    why = f"{type(error).__name__}: {error}"
    return Text(f"could not write the file ({why})", f"не записал файл ({why})")


_NO_CHANNELS = Text(
    "there are no channels to write: no parameter was read in this recording, or the requests are "
    "lost; `mikas decode FILE` shows its contents, and `mikas log -o FILE.pcapng` (or key R on the "
    "Live screen) makes a recording with values",
    "нет каналов для записи: параметры в этой записи не читались, или запросы к ним потеряны; "
    "`mikas decode ФАЙЛ` покажет, что в ней есть, а запись со значениями делает "
    "`mikas log -o ФАЙЛ.pcapng` (или клавиша R на экране «Приборы»)",
)
