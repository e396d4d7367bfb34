"""`mikas find`: the moments of a recording at which a condition holds. It needs no port."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.click_extensions import argument, command
from mikas.cli.completion.values import RECORDING, channel_names, files
from mikas.cli.context import CommandContext
from mikas.cli.language import decimal, tr
from mikas.cli.options.parameter_types import existing_file
from mikas.i18n import counted
from mikas.json_values import picked

if TYPE_CHECKING:
    from mikas.recording.search import Hit, SearchCondition


@command(
    en="Finds the moments of a recording (.pcapng) at which EXPRESSION holds: a formula of "
    "parameters, derived channels and recorded instruments, as in a catalog file. A moment ends "
    "where the formula is false or has no value for two seconds. PEAK is the extreme of what the "
    "first comparison compares: the lowest value of a <, else the highest.",
    ru="Находит в записи (.pcapng) моменты, когда выполняется EXPRESSION: формула из параметров, "
    "производных каналов и записанных приборов, как в файле каталога. Момент кончается там, где "
    "формула неверна или две секунды не имеет значения. PEAK — крайнее значение того, что "
    "сравнивается первым: при < наименьшее, иначе наибольшее.",
    examples=(
        "mikas find drive.pcapng 'FREQ > 3000 and DET'",
        "mikas find drive.pcapng 'TWAT > 100' --json",
        "mikas find drive.pcapng 'LAMBDA > 1.1 and FREQ > 2000'",
    ),
)
@argument("file", "FILE", type=existing_file, shell_complete=files(*RECORDING))
@argument("expression", "EXPRESSION", shell_complete=channel_names)
def find(context: CommandContext, file: Path, expression: str) -> None:
    from mikas.recording.recording import Recording
    from mikas.recording.search import SearchCondition, search

    options = context.options
    recording = Recording(file, options.catalog)
    condition = SearchCondition(recording.formula_catalog, expression)
    found = search(recording, condition)
    if found.damaged:
        context.say(
            f"{file}: {found.damaged} damaged place(s); the readable rest is searched.",
            f"{file}: повреждённых мест: {found.damaged}; поиск идёт по всему остальному.",
        )
    if context.output.json:
        context.output.data(
            {
                "hits": [
                    {"from": hit.begin, "to": hit.end, **picked(hit, "peak", "peak_time", "rows")}
                    for hit in found.hits
                ],
                "peak_of": condition.peak_of or None,
                "from": found.begin,
                "to": found.end,
            }
        )
        return
    if found.begin is not None and found.hits:
        _print_table(context, found.hits, condition, found.begin)
    context.output.print_note(_summary(found.hits, condition))


def _print_table(
    context: CommandContext, hits: list[Hit], condition: SearchCondition, start: float
) -> None:
    """Print a row a hit: seconds from the start, time of day if it is known, length, peak."""
    from mikas.recording.table.channels import calendar

    columns: dict[str, Callable[[Hit], str]] = {
        tr("from, s", "начало, с"): lambda hit: decimal(f"{hit.begin - start:.1f}"),
        tr("length, s", "длится, с"): lambda hit: decimal(f"{hit.end - hit.begin:.1f}"),
    }
    if condition.peak_of:
        columns[condition.peak_of] = lambda hit: (
            "—" if hit.peak is None else decimal(f"{hit.peak:.6g}")
        )
    if calendar(start) is not None:
        columns[tr("time of day", "время")] = lambda hit: (
            f"{at.astimezone():%d.%m.%Y %H:%M:%S}" if (at := calendar(hit.begin)) else ""
        )
    context.output.listing(hits, columns, right="012" if condition.peak_of else "01")


def _summary(hits: list[Hit], condition: SearchCondition) -> str:
    if not hits:
        return tr(
            f"{condition.expression}: at no moment of this recording.",
            f"{condition.expression}: ни в один момент этой записи.",
        )
    seconds = decimal(f"{sum(hit.end - hit.begin for hit in hits):.1f}")
    moments = counted(len(hits), ("moment", "moments"), ("момент", "момента", "моментов"))
    return tr(
        f"{condition.expression}: {moments.en}, {seconds} s in all.",
        f"{condition.expression}: {moments.ru}, всего {seconds} с.",
    )
