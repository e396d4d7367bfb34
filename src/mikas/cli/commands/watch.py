"""`mikas watch`: a live table; plain lines where there is no terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import partial
from typing import TYPE_CHECKING

from mikas.cli.click_extensions import command, flag
from mikas.cli.context import CommandContext
from mikas.cli.options.actions import ActionOptions, action_options
from mikas.cli.options.sampling import INSTRUMENTS, SamplingOptions, sampling_options

if TYPE_CHECKING:
    from mikas.cli.port_ahead import PortAhead
    from mikas.conditions import LoadedActions
    from mikas.sampling.events import Event


@command(
    en="Shows each NAME live until Ctrl-C; with no name, all parameters. NAME/10: every tenth "
    "cycle, so that the others are read more often. A value that could not be read is a dash, "
    "never the last number. If the adapter is unplugged or the ignition switched off, it "
    "waits and continues.",
    ru="Показывает текущие значения параметров NAME до Ctrl-C; без имён — всех. NAME/10: в "
    "каждом десятом цикле, тогда остальные читаются чаще. Непрочитанное значение — прочерк, а "
    "не прежнее число. Если отключён адаптер или выключено зажигание, ждёт и продолжает.",
    examples=(
        "mikas watch FREQ UOZ TWAT/10 FUEL_FLOW",
        "mikas watch --method stream --duration 60",
        "mikas watch FREQ --rate 2 --json",
        "mikas watch FREQ JAIR TWAT/10 --price",
        "mikas watch FREQ TWAT --actions hot.toml",
        "mikas watch FREQ INJ --instrument aem=/dev/ttyUSB1",
    ),
)
@flag(
    "--price",
    en="only show the time these names take with each method (needs no port)",
    ru="только показать, сколько времени займут эти имена при каждом способе (порт не нужен)",
)
@INSTRUMENTS
@action_options
@sampling_options
def watch(
    context: CommandContext,
    options: SamplingOptions,
    actions: ActionOptions,
    *,
    instruments: tuple[str, ...],
    price: bool,
) -> None:
    if price:
        from mikas.cli.render.line_load import show_line_load

        show_line_load(context, options.names)
        return
    loaded = None
    if actions.actions is not None:
        from mikas.cli.acting import load

        loaded, options = load(context, actions.actions, options, instruments)
    with context.open_ahead(instruments) as ahead:  # imports take as long as the handshake listens
        _watch(context, options, loaded, ahead, instruments)


def _watch(
    context: CommandContext,
    options: SamplingOptions,
    actions: LoadedActions | None,
    ahead: PortAhead,
    instruments: tuple[str, ...],
) -> None:
    from mikas.cli.acting import acting
    from mikas.cli.render.live_table import LiveTable
    from mikas.cli.render.notices import Notices
    from mikas.cli.render.values import json_line, plain_line
    from mikas.cli.sampling_run import sampling_session

    output = context.output
    log_on_screen = context.logs and sys.stderr.isatty()  # its lines would tear a live table
    drawable = sys.stdout.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")
    with ExitStack() as stack:
        run = stack.enter_context(
            sampling_session(
                context, options, ahead, context.capture, joined=False, instruments=instruments
            )
        )
        note: Callable[[str], None] = output.print_note
        show: Callable[[Event], None] = partial(
            json_line if output.json else plain_line, run, output
        )
        if drawable and not log_on_screen and not output.json:
            table = stack.enter_context(LiveTable(run, output))
            note, show = table.show_notice, table.add_event
        notices = Notices(run, note, verbose=output.verbose)
        follow = stack.enter_context(
            acting(context, run, actions, note, marks=context.capture is not None, stops=False)
        )
        for event in stack.enter_context(closing(notices.watch())):
            show(event)
            follow(event)
