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
from mikas.cli.notices import Notices
from mikas.cli.parameter_types import Number, OneOf, Whole
from mikas.cli.render.lines import JsonLines, PlainLines, Shown
from mikas.cli.render.live_table import LiveTable
from mikas.cli.sampling_run import SamplingOptions, SamplingRun, session
from mikas.client import METHODS
from mikas.i18n import Text


def sampling_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options that `watch`, `log` and `demo` share; they come as one `SamplingOptions`."""

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
            "forget which method is the fastest on this unit, and measure anew",
            "забыть, какой способ на этом блоке быстрее, и измерить заново",
        ),
    ),
    option(
        "--duration",
        type=Number(above=0),
        metavar="S",
        text=Text("stop after so many seconds", "остановиться через столько секунд"),
    ),
    option(
        "--count",
        type=Whole(1),
        metavar="N",
        text=Text("stop after so many samples", "остановиться после стольких отсчётов"),
    ),
    option(
        "--rate",
        type=Number(above=0),
        metavar="HZ",
        text=Text("samples a second at most", "не больше отсчётов в секунду"),
    ),
    option(
        "--method",
        type=OneOf(METHODS),
        metavar="METHOD",
        default="auto",
        text=Text(
            "how the unit is asked: auto (the fastest that works), single, batch, list, stream, "
            "stroke0 … stroke4",
            "как спрашивать блок: auto (самый быстрый из работающих), single, batch, list, stream, "
            "stroke0 … stroke4",
        ),
    ),
)


@command(
    "watch",
    Text(
        "Shows each NAME again and again until Ctrl-C; with no name, all parameters. NAME/10: "
        "every tenth cycle, so that the others come faster. A value that could not be read is a "
        "dash, never the last number. If the adapter or the ignition goes away, it waits and goes "
        "on.",
        "Показывает параметры NAME снова и снова до Ctrl-C; без имён — все. NAME/10: в каждом "
        "десятом цикле, тогда остальные приходят чаще. Значение, которое не прочлось, — прочерк, "
        "а не прежнее число. Если пропал адаптер или зажигание, ждёт и продолжает.",
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
        "only tell what these names cost by each method (needs no port)",
        "только показать, сколько эти имена стоят при каждом способе (порт не нужен)",
    ),
)
@sampling_options
def watch(context: CommandContext, asked: SamplingOptions, *, price: bool) -> None:
    if price:
        from mikas.cli.render.prices import tell_prices

        tell_prices(context, asked)
        return
    with session(context, asked, context.capture, joined=False) as current:
        show(context, current, asked)


def show(context: CommandContext, current: SamplingRun, asked: SamplingOptions) -> None:
    """Tells a session as JSON lines, as a live table on a terminal, else as plain lines."""
    with shown_on(context, current) as screen:
        notices = Notices(current, screen.tell, verbose=context.output.verbose)
        for event in current.events(asked):
            notices.take(event)  # first: who sees a value has been told that it is back
            screen.take(event)
        notices.end()


def shown_on(context: CommandContext, current: SamplingRun) -> Shown:
    """What fits where the output goes."""
    if context.output.json:
        return JsonLines(current, context.output)
    log_on_screen = context.logs and sys.stderr.isatty()  # its lines would tear the table
    drawable = sys.stdout.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")
    if drawable and not log_on_screen:
        return LiveTable(current, context.output)
    return PlainLines(current, context.output)
