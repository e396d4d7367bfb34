"""`mikas watch`: a live table; plain lines where there is no terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from mikas.cli.click_extensions import command, grouped, option
from mikas.cli.common_options import RELEARN
from mikas.cli.context import CommandContext
from mikas.cli.language import decimal, tr
from mikas.cli.parameter_types import number, one_of, whole
from mikas.cli.render.live_table import LiveTable
from mikas.cli.render.notices import Notices
from mikas.cli.render.values import json_line, plain_line
from mikas.cli.sampling_run import SamplingOptions, sampling_session
from mikas.client import METHODS
from mikas.i18n import Text
from mikas.sampling.plan import Plan, PlannedParameter, select

if TYPE_CHECKING:
    from mikas.catalog import Catalog, Parameter
    from mikas.client.polling import FixedMethod
    from mikas.sampling.events import Event

_FIXED_METHODS: tuple[FixedMethod, ...] = ("single", "batch", "list", "stream")


sampling_options = grouped(
    SamplingOptions,
    click.argument("names", metavar="[NAME[/N]]...", nargs=-1),
    option(
        "--method",
        type=one_of(METHODS),
        metavar="METHOD",
        default="auto",
        text=Text(
            "sampling method: auto (the fastest that works), single, batch, list, stream, stroke0 "
            "… stroke4",
            "способ опроса: auto (самый быстрый из работающих), single, batch, list, stream, "
            "stroke0 … stroke4",
        ),
    ),
    option(
        "--rate",
        type=number(above=0),
        metavar="HZ",
        text=Text("at most this many readings/s", "опросов в секунду, не больше"),
    ),
    option(
        "--count",
        type=whole(1),
        metavar="N",
        text=Text("stop after this many samples", "остановиться после стольких отсчётов"),
    ),
    option(
        "--duration",
        type=number(above=0),
        metavar="S",
        text=Text("stop after this many seconds", "остановиться через столько секунд"),
    ),
    RELEARN,
)
"""The options that `watch` and `log` share."""


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
def watch(context: CommandContext, options: SamplingOptions, *, price: bool) -> None:
    if price:
        _show_line_load(context, options.names)
        return
    output = context.output
    log_on_screen = context.logs and sys.stderr.isatty()  # its lines would tear a live table
    drawable = sys.stdout.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")
    with ExitStack() as stack:
        run = stack.enter_context(sampling_session(context, options, context.capture, joined=False))
        note: Callable[[str], None] = output.note
        show: Callable[[Event], None] = partial(
            json_line if output.json else plain_line, run, output
        )
        if drawable and not log_on_screen and not output.json:
            table = stack.enter_context(LiveTable(run, output))
            note, show = table.note, table.take
        for event in Notices(run, note, verbose=output.verbose).watch():
            show(event)


def _show_line_load(context: CommandContext, names: Sequence[str]) -> None:
    """Print the line load of each method, and of one more parameter of one byte.

    Computed from §5's figures: 960 bytes a second, 2 ms from a request to its response. The rates
    of the unit and the adapter in use are measured when `auto` chooses, and shown with `-v`.
    """
    catalog = context.options.catalog
    plan = Plan(select(catalog, names).parameters)
    more = _another(catalog, plan)
    prices = [_price(plan.with_method(method), more) for method in _FIXED_METHODS]
    if context.output.json:
        context.output.data(
            {"names": [it.parameter.name for it in plan.parameters], "prices": prices}
        )
        return
    headers = [
        tr("method", "способ"), tr("bytes/cycle", "байт/цикл"),
        tr("requests/cycle", "запросов/цикл"), tr("ms/cycle", "мс/цикл"),
        tr("readings/s at most", "опр/с, не больше"), tr("one more: ms", "ещё один: мс"),
        tr("one more: readings/s", "ещё один: опр/с"),
    ]  # fmt: skip
    context.output.table(headers, [_row(price) for price in prices], right="123456")


def _price(plan: Plan, more: Parameter | None) -> dict[str, Any]:
    price = plan.price()
    price_json: dict[str, Any] = {
        "method": plan.method,
        "bytes": round(price.bytes, 1),
        "requests": round(price.requests, 2),
        "ms": round(price.seconds * 1000, 1),
        "sets_per_second": round(price.rate, 1),
        "one_more": None,
    }
    if more is not None:
        then = plan.with_parameter(PlannedParameter(more)).price()
        price_json["one_more"] = {
            "ms": round((then.seconds - price.seconds) * 1000, 1),
            "sets_per_second": round(then.rate, 1),
        }
    return price_json


def _row(price: dict[str, Any]) -> list[str]:
    more = price["one_more"] or {"ms": "–", "sets_per_second": "–"}
    cells = [price["bytes"], price["requests"], price["ms"], price["sets_per_second"]]
    return [
        price["method"],
        *(decimal(str(cell)) for cell in [*cells, more["ms"], more["sets_per_second"]]),
    ]


def _another(catalog: Catalog, plan: Plan) -> Parameter | None:
    """Return a parameter of one byte that is not in the plan."""
    planned = {wanted.parameter.code for wanted in plan.parameters}
    left = (p for p in catalog.parameters if p.code not in planned and p.size == 1)
    return next(left, None)
