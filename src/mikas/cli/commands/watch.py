"""`mikas watch`: a live table; plain lines where there is no terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import wraps
from typing import Any

import click

from mikas.cli.click_extensions import command, option
from mikas.cli.context import CommandContext
from mikas.cli.parameter_types import Number, OneOf, Whole
from mikas.cli.render.lines import Display, JsonLines, PlainLines
from mikas.cli.render.live_table import LiveTable
from mikas.cli.render.notices import Notices
from mikas.cli.sampling_run import SamplingOptions, SamplingRun, session
from mikas.client import METHODS
from mikas.i18n import Text


def sampling_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that `watch` and `log` share; the command gets one `SamplingOptions`."""

    @wraps(function)
    def gathered(
        context: CommandContext,
        *args: Any,
        names: tuple[str, ...],
        method: str,
        rate: float | None,
        count: int | None,
        duration: float | None,
        relearn: bool,
        **rest: Any,
    ) -> Any:  # noqa: ANN401  (as the command)
        asked = SamplingOptions(names, method, rate, count, duration, relearn)
        return function(context, asked, *args, **rest)

    gathered_with: Callable[..., Any] = gathered
    for add in _OPTIONS:
        gathered_with = add(gathered_with)
    return click.argument("names", metavar="[NAME[/N]]...", nargs=-1)(gathered_with)


_OPTIONS = (
    option(
        "--relearn",
        is_flag=True,
        text=Text(
            "forget the fastest method of this unit and measure again",
            "забыть самый быстрый способ для этого блока и измерить заново",
        ),
    ),
    option(
        "--duration",
        type=Number(above=0),
        metavar="S",
        text=Text("stop after this many seconds", "остановиться через столько секунд"),
    ),
    option(
        "--count",
        type=Whole(1),
        metavar="N",
        text=Text("stop after this many samples", "остановиться после стольких отсчётов"),
    ),
    option(
        "--rate",
        type=Number(above=0),
        metavar="HZ",
        text=Text("at most this many readings/s", "опросов в секунду, не больше"),
    ),
    option(
        "--method",
        type=OneOf(METHODS),
        metavar="METHOD",
        default="auto",
        text=Text(
            "sampling method: auto (the fastest that works), single, batch, list, stream, stroke0 "
            "… stroke4",
            "способ опроса: auto (самый быстрый из работающих), single, batch, list, stream, "
            "stroke0 … stroke4",
        ),
    ),
)


@command(
    "watch",
    Text(
        "Shows each NAME live until Ctrl-C; with no name, all parameters. NAME/10: every tenth "
        "cycle, so that the others are read more often. A value that could not be read is a dash, "
        "never the last number. If the adapter is unplugged or the ignition switched off, it "
        "waits and continues.",
        "Показывает текущие значения параметров NAME до Ctrl-C; без имён — всех. NAME/10: в "
        "каждом десятом цикле, тогда остальные читаются чаще. Непрочитанное значение — прочерк, а "
        "не прежнее число. Если отключён адаптер или выключено зажигание, ждёт и продолжает.",
    ),
    examples=(
        "mikas watch FREQ UOZ TWAT/10 FUEL_FLOW",
        "mikas watch --method stream --duration 60",
        "mikas watch FREQ --rate 2 --json",
        "mikas watch FREQ JAIR TWAT/10 --price",
    ),
)
@option(
    "--price",
    is_flag=True,
    text=Text(
        "only show the time these names take with each method (needs no port)",
        "только показать, сколько времени займут эти имена при каждом способе (порт не нужен)",
    ),
)
@sampling_options
def watch(context: CommandContext, asked: SamplingOptions, *, price: bool) -> None:
    if price:
        from mikas.cli.render.prices import show_prices

        show_prices(context, asked)
        return
    with session(context, asked, context.capture, joined=False) as current:
        show(context, current, asked)


def show(context: CommandContext, current: SamplingRun, asked: SamplingOptions) -> None:
    """Show the events as JSON lines, as a live table on a terminal, else as plain lines."""
    with display_for(context, current) as display:
        notices = Notices(current, display.tell, verbose=context.output.verbose)
        for event in current.events(asked):
            notices.take(event)  # first: the notice that values are back comes before them
            display.take(event)
        notices.end()


def display_for(context: CommandContext, current: SamplingRun) -> Display:
    """Return the display that suits the output."""
    if context.output.json:
        return JsonLines(current, context.output)
    log_on_screen = context.logs and sys.stderr.isatty()  # its lines would tear the table
    drawable = sys.stdout.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")
    if drawable and not log_on_screen:
        return LiveTable(current, context.output)
    return PlainLines(current, context.output)
