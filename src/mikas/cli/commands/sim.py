"""`mikas sim`: a virtual ECU on a pty or a TCP port, for other programs."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Sequence

import click

from mikas.cli.grammar import command, option
from mikas.cli.run import Run
from mikas.cli.words import say
from mikas.errors import UsageError
from mikas.language import Text
from mikas.link import WallClock
from mikas.virtual import serve
from mikas.virtual.build import MODELS, SETTINGS, build_bus
from mikas.virtual.bus import Bus
from mikas.virtual.ecu import Happening


@command(
    "sim",
    Text(
        "Serves a virtual ECU in real time until Ctrl-C. Its address is the first line on stdout: "
        "give it to --port of another command, or to any other tester.",
        "Виртуальный блок в реальном времени до Ctrl-C. Первая строка вывода — его адрес: он "
        "подходит для --port другой команды и для любого другого тестера.",
    ),
    examples=(
        "mikas sim",
        "mikas sim --scenario city --faults 13,53",
        "mikas sim --tcp 127.0.0.1:2000 --set unknown=01 --line-fault damaged=0.01",
    ),
)
@option("--tcp", metavar="HOST:PORT", text=Text("on TCP, not a pty", "по TCP вместо pty"))
@option("--model", type=click.Choice(list(MODELS)), text=Text("the unit (7.1)", "блок (7.1)"))
@option(
    "--scenario",
    metavar="NAME|FILE",
    text=Text("what the car does (warm-idle)", "что делает машина (warm-idle)"),
)
@option("--faults", metavar="LIST", text=Text("stored faults, 13,53", "ошибки, 13,53"))
@option("--no-echo", is_flag=True, text=Text("an adapter without echo", "адаптер без эха"))
@option("--baud", metavar="N", text=Text("pace of the wire (9600)", "темп линии (9600)"))
@option("--seed", metavar="N", text=Text("of its chances (0)", "для случайностей (0)"))
@option(
    "--latency-ms",
    metavar="MS",
    text=Text("the adapter's latency timer (0)", "таймер задержки адаптера (0)"),
)
@option(
    "--line-fault",
    "line_faults",
    multiple=True,
    metavar="KIND=RATE",
    text=Text(
        "damaged=0.01; also lost, late, cut, missing-byte, doubled, foreign, noise, echo",
        "damaged=0.01; ещё lost, late, cut, missing-byte, doubled, foreign, noise, echo",
    ),
)
@option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    text=Text(
        "any other setting: unknown=01, max_list=8, missing=stream+list …",
        "любая другая настройка: unknown=01, max_list=8, missing=stream+list …",
    ),
)
def sim(
    run: Run,
    tcp: str | None,
    line_faults: Sequence[str],
    settings: Sequence[str],
    *,
    no_echo: bool,
    **named: str | None,
) -> None:
    wanted = {name: value for name, value in named.items() if value is not None}
    wanted |= dict(_pair(word) for word in (*line_faults, *settings))
    if no_echo:
        wanted["echo"] = "0"
    clock = WallClock()
    bus = build_bus(wanted, start=clock.now(), watcher=_watcher(run))
    serve.run(_serve(run, bus, clock, _host_and_port(tcp) if tcp else None))


async def _serve(run: Run, bus: Bus, clock: WallClock, tcp: tuple[str, int] | None) -> None:
    if tcp is None:
        if os.name != "posix":
            raise UsageError(
                problem=Text(
                    "this system has no pseudo-terminals; use --tcp 127.0.0.1:2000",
                    "в этой системе нет псевдотерминалов; используйте --tcp 127.0.0.1:2000",
                )
            )
        port: serve.PtyPort | serve.TcpPort = serve.PtyPort(bus, clock.now)
    else:
        port = await serve.TcpPort.open(bus, clock.now, *tcp)
    try:
        if run.output.json:
            run.output.data({"url": port.url})
        else:
            run.output.line(port.url)
        run.output.note(say("Ctrl-C ends it.", "Выход: Ctrl-C."))
        await asyncio.Event().wait()
    finally:
        port.close()


def _watcher(run: Run) -> Callable[[Happening], None] | None:
    def tell(happening: Happening) -> None:
        data = happening.data.hex().upper()
        if run.output.json:
            run.output.data(
                {"time": round(happening.time, 6), "event": happening.kind, "data": data or None}
            )
        else:
            run.output.detail(f"{happening.time:.3f}", happening.kind, data)

    return tell if run.output.json or run.output.verbose else None


def _pair(word: str) -> tuple[str, str]:
    name, equals, value = word.partition("=")
    if not equals:
        raise UsageError(
            problem=Text(
                f"write NAME=VALUE, not “{word}”; names: {', '.join(SETTINGS)}",
                f"пишите ИМЯ=ЗНАЧЕНИЕ, а не «{word}»; имена: {', '.join(SETTINGS)}",
            )
        )
    return name.strip(), value.strip()


def _host_and_port(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not port.isascii() or not port.isdigit() or int(port) > 0xFFFF:
        raise UsageError(
            problem=Text(
                f"“{text}” is not HOST:PORT; write 127.0.0.1:2000",
                f"«{text}» — не HOST:PORT; пишите 127.0.0.1:2000",
            )
        )
    return host.strip("[]") or "127.0.0.1", int(port)
