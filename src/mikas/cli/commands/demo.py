"""`mikas demo`: the dashboard with a virtual car. No adapter, no cable, no car."""

from __future__ import annotations

from urllib.parse import urlencode

from mikas.cli.click_extensions import command, option
from mikas.cli.commands.dash import DashboardOptions, dashboard_options, show_dashboard
from mikas.cli.context import CommandContext
from mikas.cli.language import tr
from mikas.cli.parameter_types import Whole
from mikas.i18n import Text

_FAULTS = "17"  # the air's temperature: something to find and to erase, and the engine runs well


@command(
    "demo",
    Text(
        "Opens the dashboard with a virtual car in this process: a cold start and warm-up, with "
        "one stored fault. The same in a terminal: mikas watch --port sim:",
        "Открывает панель с виртуальным автомобилем в этом же процессе: холодный пуск и прогрев, "
        "одна ошибка в памяти. То же в терминале: mikas watch --port sim:",
    ),
    examples=("mikas demo", "mikas demo --scenario city --lang ru", "mikas demo --no-browser"),
)
@option(
    "--scenario",
    default="cold-start",
    metavar="NAME|FILE",
    text=Text("what the car does (cold-start)", "что делает машина (cold-start)"),
)
@option(
    "--seed",
    type=Whole(0),
    default=1,
    metavar="N",
    text=Text("another number, other chances (1)", "другое число — другие случайности (1)"),
)
@option(
    "--faults",
    default=_FAULTS,
    metavar="LIST",
    text=Text(f"stored faults, as 13,53 ({_FAULTS})", f"ошибки в памяти, как 13,53 ({_FAULTS})"),
)
@dashboard_options
def demo(
    context: CommandContext, options: DashboardOptions, *, scenario: str, seed: int, faults: str
) -> None:
    context.port = f"sim:?{urlencode({'scenario': scenario, 'seed': seed, 'faults': faults})}"
    context.output.detail(tr("virtual car:", "виртуальный автомобиль:"), context.port)
    show_dashboard(context, options)
