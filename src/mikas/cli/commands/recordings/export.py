"""`mikas export`: a table for other programs; `mikas decode`: the frames. Neither needs a port."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.click_extensions import OVERWRITE, argument, command, option, output_option
from mikas.cli.completion.values import EXPORTED, RECORDING, channel_names, files, listed
from mikas.cli.context import CommandContext
from mikas.cli.language import current_language, localized, tr
from mikas.cli.options.parameter_types import existing_file
from mikas.errors import usage_error
from mikas.i18n import plural
from mikas.recording.export import DIALECTS, formats

if TYPE_CHECKING:
    from mikas.recording.recording import Recording
    from mikas.recording.table.channels import Rows


from mikas.recording import CaptureReader
from mikas.recording.capture.reader import Packet, Problem
from mikas.recording.inspect import Describer, Item, to_json, to_text
from mikas.recording.inspect import decode as decode_frames
from mikas.recording.instrument_lines import (
    InstrumentLines,
    InstrumentMessage,
    message_json,
    message_text,
)

MOST_PROBLEMS = 20


@command(
    en="Exports a recording (.pcapng) as a table for other programs. OUT's suffix sets the "
    "format: .csv, .mf4, .parquet, .msl or .mlg; .gpx or .geojson is the way of the car, of a "
    "recording with a GPS. With no NAME it has every recorded parameter and every channel that can "
    "be derived from them.",
    ru="Экспортирует запись (.pcapng) в таблицу для других программ. Формат определяет "
    "расширение файла OUT: .csv, .mf4, .parquet, .msl или .mlg; .gpx и .geojson — путь машины, "
    "если в записи есть GPS. Без NAME в таблице все записанные параметры и все каналы, которые из "
    "них рассчитываются.",
    examples=(
        "mikas export drive.pcapng -o drive.csv",
        "mikas export drive.pcapng -o drive.parquet FREQ JAIR FUEL_FLOW",
        "mikas export drive.pcapng -o drive.csv --dialect excel --lang ru",
        "mikas export drive.pcapng -o drive.gpx",
    ),
)
@argument("file", "FILE", type=existing_file, shell_complete=files(*RECORDING))
@argument("names", "[NAME]...", nargs=-1, shell_complete=channel_names)
@output_option(endings=EXPORTED)
@option(
    "--dialect",
    words=DIALECTS,
    en="form of a .csv: commas (plain), or for an Excel with a decimal comma (excel)",
    ru="вид файла .csv: через запятую (plain) или для таблиц с десятичной запятой (excel)",
)
@option(
    "--format",
    "format_name",
    metavar="NAME",
    shell_complete=listed(formats),
    listed=formats,  # reads the metadata of all distributions
    en="the format, whatever OUT's suffix: {listed}",
    ru="формат, каким бы ни было расширение OUT; есть: {listed}",
)
@option(
    "--instrument",
    "instruments",
    multiple=True,
    metavar="FILE.toml",
    shell_complete=files("toml"),
    en="a definition that decodes the recorded instrument of this name again, in place of the one "
    "in the recording",
    ru="описание прибора, по которому его запись разобрать заново, вместо того, что в записи",
)
@OVERWRITE
def export(
    context: CommandContext,
    file: Path,
    names: tuple[str, ...],
    out: Path,
    dialect: str | None,
    format_name: str | None,
    instruments: tuple[str, ...],
    overwrite: bool,
) -> None:
    from mikas.recording.export import PLAIN, with_position
    from mikas.recording.export import export as write
    from mikas.recording.export.exporting import format_of
    from mikas.recording.recording import Recording

    _check(file, out, dialect, format_name)
    recording = Recording(
        file,
        context.options.catalog,
        context.options.interpretation,
        names,
        instruments=instruments,
    )
    if names and format_of(out, format_name).is_track:
        wanted = with_position(recording, names)
        recording = recording.interpreted(context.options.interpretation, wanted)
    _tell_problems(context, recording)
    for unread in recording.instruments_unread:
        context.say(
            f"An instrument is not exported: {unread.en}",
            f"Прибор не экспортирован: {unread.ru}",
        )
    if recording.absent:
        absent = ", ".join(recording.absent)
        context.say(f"Not in this recording: {absent}.", f"В этой записи нет: {absent}.")
    result = write(
        out,
        recording.channels,
        _watched(context, recording.rows()),
        events=recording.events,
        about=recording.about,
        language=current_language(),
        dialect=DIALECTS[dialect] if dialect else PLAIN,
        overwrite=overwrite,
        format_name=format_name,
    )
    count = len(result.channels)
    if context.output.json:
        context.output.data({"rows": result.rows, "channels": count, "out": str(result.out)})
    else:
        context.say(
            f"{out}: {plural(result.rows, 'row', 'rows')}, {plural(count, 'channel', 'channels')}",
            f"{out}: строк: {result.rows}, каналов: {count}",
        )


def _check(file: Path, out: Path, dialect: str | None, format_name: str | None) -> None:
    """Raise for errors that can be found before reading ten hours."""
    from mikas.recording.export.exporting import format_of

    same = False
    with suppress(OSError):  # OUT is absent or not readable: reported when it is written
        same = out.samefile(file)
    if same:
        raise usage_error(
            f"“{out}” is the recording itself; give the table another name",
            f"«{out}» — это сама запись; дайте таблице другое имя",
        )
    if dialect and format_of(out, format_name).module != "csv":
        raise usage_error(
            f"--dialect is for .csv files only; {out} is not one",
            f"Ключ --dialect действует только для .csv, а {out} — другой файл",
        )


def _tell_problems(context: CommandContext, recording: Recording) -> None:
    """Print the first problems with their offsets, and their number."""
    if not recording.problem_count:
        return
    for problem in recording.problems[:MOST_PROBLEMS]:
        context.say(
            f"{recording.path}, offset {problem.offset}: {localized(problem.text)}",
            f"{recording.path}, смещение {problem.offset}: {localized(problem.text)}",
        )
    count = recording.problem_count
    context.say(
        f"{recording.path}: {count} damaged place(s); the readable rest is exported.",
        f"{recording.path}: повреждённых мест: {count}; всё остальное экспортируется.",
    )


def _watched(context: CommandContext, stretches: Iterable[Rows]) -> Iterator[Rows]:
    """Pass the rows on; at the end print how often their times ran back."""
    last, count = float("-inf"), 0
    for rows in stretches:
        if len(rows.times):
            count += rows.times[0] < last
            last = float(rows.times[-1])
        yield rows
    if count:
        context.say(
            f"Times run back in this table (times: {count}): the recording has several "
            "sessions or ports, one after another.",
            f"Время в этой таблице идёт назад (раз: {count}): в записи несколько сеансов или "
            "портов, они следуют друг за другом.",
        )


@command(
    en="Shows a capture (.pcapng) frame by frame: time, direction, bytes, meaning; damage with "
    "its reason and offset; messages of instruments beside the unit with their values. Of a "
    "truncated file the readable part is shown.",
    ru="Показывает запись (.pcapng) по кадрам: время, направление, байты, значение; повреждения "
    "с причиной и смещением; сообщения приборов рядом с блоком и их значения. Обрезанный файл "
    "показывается до места обрыва.",
    examples=("mikas decode drive.pcapng", "mikas decode drive.pcapng --json"),
)
@argument("file", "FILE", type=existing_file, shell_complete=files(*RECORDING))
def decode(context: CommandContext, file: Path) -> None:
    catalog = context.options.catalog
    describer = partial(Describer, catalog, context.options.interpretation)
    lines = InstrumentLines(catalog)
    zero: float | None = None
    number = 0
    for item in _with_messages(
        decode_frames(
            CaptureReader(file).with_other_protocols(instruments=True), describer, catalog.size_of
        ),
        lines,
    ):
        if context.output.json:
            line = message_json(item) if isinstance(item, InstrumentMessage) else to_json(item)
            line.pop("schema", None)
            context.output.data(line)
            continue
        if zero is None:
            zero = getattr(item, "time", getattr(item, "begin", None))
        if not isinstance(item, Problem) and item.source.recording != number:
            number = item.source.recording
            port = "" if item.source.instrument else item.source.url
            shown = tr(f"recording {number + 1}: ", f"запись {number + 1}: ") + port
            context.output.line(shown.rstrip())
        context.output.line(_shown(item, zero or 0.0))


def _shown(item: Item | InstrumentMessage, zero: float) -> str:
    if isinstance(item, InstrumentMessage):
        return message_text(item, current_language(), zero=zero)
    return to_text(item, current_language(), zero=zero)


def _with_messages(
    items: Iterable[Item], lines: InstrumentLines
) -> Iterator[Item | InstrumentMessage]:
    """Yield the items, the messages of instruments in the place of their packets."""
    for item in items:
        if isinstance(item, Packet) and item.source.instrument:
            yield from lines.feed(item)
        else:
            yield item
