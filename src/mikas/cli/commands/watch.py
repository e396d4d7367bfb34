"""`mikas watch`: a live table; plain lines where there is no terminal."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from typing import Any

import click

from mikas.cli.arguments import Number, OneOf, Whole
from mikas.cli.grammar import command, option
from mikas.cli.live import LiveTable, PlainLines
from mikas.cli.run import Run
from mikas.client import METHODS, Ecu, Sample
from mikas.language import Text


def sampling_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """The options that `watch` and `log` share."""
    for add in (
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
                "how the unit is asked: auto, single, batch, list, stream, stroke0 … stroke4",
                "как спрашивать блок: auto, single, batch, list, stream, stroke0 … stroke4",
            ),
        ),
    ):
        function = add(function)
    return click.argument("names", metavar="[NAME]...", nargs=-1)(function)


@command(
    "watch",
    Text(
        "Shows each NAME again and again until Ctrl-C; with no name, all. A value that could not "
        "be read is a dash, never the last number.",
        "Показывает параметры NAME снова и снова до Ctrl-C; без имён — все. Значение, которое не "
        "прочлось, — прочерк, а не прежнее число.",
    ),
    examples=(
        "mikas watch TWAT FREQ UOZ",
        "mikas watch --method stream --duration 60",
        "mikas watch FREQ --rate 2 --json",
    ),
)
@sampling_options
def watch(
    run: Run,
    names: tuple[str, ...],
    method: str,
    rate: float | None,
    count: int | None,
    duration: float | None,
) -> None:
    with run.ecu() as ecu:
        show(run, ecu, samples(ecu, names, method, rate, count, duration), names)


def samples(
    ecu: Ecu,
    names: tuple[str, ...],
    method: Any,  # noqa: ANN401  (one of METHODS, checked by click)
    rate: float | None,
    count: int | None,
    duration: float | None,
) -> Iterator[Sample]:
    """The samples asked for, ended by count or duration, and closed however the loop is left."""
    began = ecu.tester.link.now()
    if rate is not None and duration is not None:  # lest it waits for one that comes too late
        most = int(rate * duration) + 1
        count = most if count is None else min(count, most)
    taken = ecu.watch(*names, method=method, rate=rate, count=count)
    for sample in taken:
        yield sample
        if duration is not None and ecu.tester.link.now() - began >= duration:
            return


def show(run: Run, ecu: Ecu, taken: Iterator[Sample], names: tuple[str, ...]) -> None:
    """Tells `taken` as JSON lines, as a live table on a terminal, else as plain lines."""
    wanted = [ecu.catalog.parameter(name) for name in names] or list(ecu.catalog.parameters)
    if run.output.json:
        for sample in taken:
            values = {
                p.name: sample.readings[p.name].value if p.name in sample.readings else None
                for p in wanted
            }
            run.output.data({"time": round(sample.time, 6), "values": values, "gap": sample.gap})
        return
    live = sys.stdout.isatty() and os.environ.get("TERM") not in ("dumb", "unknown")
    table = LiveTable(ecu, wanted) if live else PlainLines(run.output, wanted)
    with table:
        for sample in taken:
            table.show(sample)
