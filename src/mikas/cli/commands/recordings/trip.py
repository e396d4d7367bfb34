"""`mikas trip`: the drives of recordings, with fuel, distance and idling. It needs no port."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.click_extensions import argument, command, option
from mikas.cli.completion.values import RECORDING, files
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language, decimal, tr
from mikas.cli.options.parameter_types import existing_file
from mikas.errors import usage_error

if TYPE_CHECKING:
    from mikas.drives import Trip
    from mikas.recording.recording import Recording

_WORTH_SAYING = 1.0  # s


@command(
    en="Shows the drives of recordings (.pcapng): from when the engine runs until it stops, with "
    "litres (of JQT, else by injection), idle time, and with a GPS beside the unit distance, speed "
    "and litres on 100 km. What a gap leaves out is no part of a sum, and is said.",
    ru="Показывает поездки в записях (.pcapng): от запуска двигателя до остановки — литры (по "
    "JQT, а без него по впрыску), время на холостом ходу, а с GPS рядом с блоком путь, скорость и "
    "литры на 100 км. Что пришлось на разрыв, в суммы не входит, и об этом сказано.",
    examples=(
        "mikas trip drive.pcapng",
        "mikas trip drive.pcapng --since 'filled up'",
        "mikas trip monday.pcapng tuesday.pcapng --json",
    ),
)
@argument("files", "FILE...", nargs=-1, type=existing_file, shell_complete=files(*RECORDING))
@option(
    "--since",
    metavar="MARK",
    en="from this mark on: its name, or its number from 1 on; files before its own are left out",
    ru="начиная с этой отметки: её имя или номер, считая с 1; файлы до её файла не учитываются",
)
def trip(context: CommandContext, *, files: tuple[Path, ...], since: str | None) -> None:
    from mikas.drives import joined_trips, since_mark, trips
    from mikas.recording.recording import Recording

    if not files:
        raise usage_error("Name a recording: mikas trip FILE", "Назовите запись: mikas trip FILE")
    recordings = [Recording(file, context.options.catalog) for file in files]
    first, mark = (0, None) if since is None else since_mark(recordings, since)
    found: list[tuple[Recording, Trip]] = []
    for number, recording in enumerate(recordings[first:]):
        context.say_damaged(recording)
        marked = None if number else mark
        found += [(recording, each) for each in trips(recording, marked)]
    total = joined_trips(each for _, each in found)
    if context.output.json:
        drives = [{"file": str(recording.path), **each.as_json()} for recording, each in found]
        context.output.data(
            {
                "trips": drives,
                "total": None if total is None else total.as_json(),
                "since": None
                if mark is None
                else {"file": str(files[first]), "label": mark.label, "time": mark.time},
            }
        )
        return
    if total is None:
        context.say("The engine did not run.", "Двигатель не работал.")
        return
    _print_table(context, found, total)
    _say_what_is_missing(context, total)


def _print_table(context: CommandContext, found: list[tuple[Recording, Trip]], total: Trip) -> None:
    """Print a row a drive, and the total below several."""
    rows: list[tuple[str, Trip]] = [(_begin(recording, each), each) for recording, each in found]
    if len(rows) > 1:
        rows.append((tr("total", "всего"), total))
    columns: dict[str, Callable[[tuple[str, Trip]], str]] = {
        tr("begin", "начало"): lambda row: row[0],
        tr("length", "длится"): lambda row: _length(row[1].seconds),
        tr("idle", "стоит"): lambda row: _length(row[1].idle_seconds),
        tr("litres", "литров"): lambda row: _shown(row[1].litres, 2),
        tr("km", "км"): lambda row: _shown(row[1].kilometres, 1),
        tr("l/100 km", "л/100 км"): lambda row: _shown(row[1].litres_per_100_km, 1),
        tr("km/h", "км/ч"): lambda row: _both(row[1].mean_speed, row[1].highest_speed),
        tr("rpm", "об/мин"): lambda row: _both(row[1].mean_rpm, row[1].highest_rpm),
        tr("gaps", "разрывы"): lambda row: _length(row[1].gap_seconds),
    }
    context.output.listing(rows, columns, right="12345678")


def _begin(recording: Recording, trip: Trip) -> str:
    """Return the date and time, or the seconds from the begin of a recording without a date."""
    from mikas.recording.table.channels import calendar

    if (at := calendar(trip.begin)) is not None:
        return f"{at.astimezone():%d.%m.%Y %H:%M:%S}"
    first = min((begin for begin, _ in recording.raw.spans.values()), default=trip.begin)
    return decimal(f"{trip.begin - first:.1f}") + tr(" s", " с")


def _length(seconds: float | None) -> str:
    """Return `1:02:03`, or `2:03`."""
    if seconds is None:
        return "–"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


def _shown(value: float | None, decimals: int) -> str:
    return "–" if value is None else decimal(f"{value:.{decimals}f}")


def _both(mean: float | None, most: float | None) -> str:
    """Return the mean and the highest value, `47 (92)`."""
    return "–" if mean is None or most is None else f"{mean:.0f} ({most:.0f})"


def _say_what_is_missing(context: CommandContext, total: Trip) -> None:
    """Name what the sums leave out, on stderr."""
    from mikas.drives.wording import NO_SPEED, left_out

    for sentence in left_out(total, _WORTH_SAYING):
        context.output.print_note(sentence.to(current_language()))
        if sentence == NO_SPEED:
            context.say(
                "A GPS beside the unit gives it: mikas log --instrument nmea=PORT.",
                "Её даёт GPS рядом с блоком: mikas log --instrument nmea=ПОРТ.",
            )
