"""`mikas demo`: the live table with a virtual car. No adapter, no cable, no car."""

from __future__ import annotations

from urllib.parse import urlencode

from mikas.cli.commands.watch import samples, sampling_options, show
from mikas.cli.grammar import command, option
from mikas.cli.run import Run
from mikas.cli.words import say
from mikas.language import Text


@command(
    "demo",
    Text(
        "Opens the live table against a virtual ECU in this process: a cold start and warm-up.",
        "Открывает живую таблицу с виртуальным блоком в этом же процессе: холодный пуск и прогрев.",
    ),
    examples=("mikas demo", "mikas demo --scenario city --lang ru"),
)
@option(
    "--scenario",
    default="cold-start",
    metavar="NAME|FILE",
    text=Text("what the car does (cold-start)", "что делает машина (cold-start)"),
)
@option(
    "--seed",
    default="1",
    metavar="N",
    text=Text("another number, other chances (1)", "другое число — другие случайности (1)"),
)
@option(
    "--no-browser",
    is_flag=True,
    text=Text("the table in this terminal", "таблица в этом терминале"),
)
@sampling_options
def demo(
    run: Run,
    names: tuple[str, ...],
    scenario: str,
    seed: str,
    method: str,
    rate: float | None,
    count: int | None,
    duration: float | None,
    *,
    no_browser: bool,  # noqa: ARG001  (the contract has it; there is no browser to open yet)
) -> None:
    run.port = f"sim:?{urlencode({'scenario': scenario, 'seed': seed})}"
    with run.ecu() as ecu:
        run.output.note(
            say(
                f"A virtual car ({scenario}). Ctrl-C ends it. With a real one: mikas doctor",
                f"Виртуальная машина ({scenario}). Выход: Ctrl-C. С настоящей: mikas doctor",
            )
        )
        if run.output.json:
            run.output.data({"url": run.port})
        show(run, ecu, samples(ecu, names, method, rate, count, duration), names)
