"""`mikas sim`: a virtual ECU on a pty or a TCP port, for other programs."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cli.click_extensions import command, flag, option
from mikas.cli.completion.values import (
    RECORDING,
    UNIT,
    cars,
    fault_codes,
    files,
    line_faults,
    scenarios,
    unit_settings,
    words,
)
from mikas.cli.context import CommandContext
from mikas.cli.language import tr
from mikas.cli.options.parameter_types import any_file
from mikas.errors import usage_error
from mikas.link.clocks import AwakeClock
from mikas.virtual import serve
from mikas.virtual.build import CAR_SETTINGS, MODELS, SETTINGS, build_bus
from mikas.virtual.bus import Bus
from mikas.virtual.cars import EngineCar
from mikas.virtual.ecu import EcuEvent
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.instruments import BAUDS, VirtualInstrument

if TYPE_CHECKING:
    from mikas.replay import ReplayCar

_LINE_FAULTS = ", ".join(it.value for it in LineFault if it is not LineFault.DAMAGED)


@command(
    en="Serves a virtual ECU in real time until Ctrl-C. Its address is the first line on stdout, "
    "for --port of another command or for any other tester.",
    ru="Виртуальный блок в реальном времени до Ctrl-C. Первая строка вывода — его адрес: он "
    "подходит для --port другой команды и для любого другого тестера.",
    examples=(
        "mikas sim",
        "mikas sim --scenario city --faults 13,53",
        "mikas sim --scenario city --car leak:8,battery",
        "mikas sim --scenario mixed --car blind:4711",
        "mikas sim --answer blind:4711",
        "mikas sim --tcp 127.0.0.1:2000 --set unknown=01 --line-fault damaged=0.01",
        "mikas sim --replay drive.pcapng --set seek=600",
        "mikas sim --unit survey.zip --scenario city",
        "mikas sim --scenario city --instrument aem --instrument nmea",
    ),
)
@option(
    "--replay",
    type=any_file,
    shell_complete=files(*RECORDING),
    en="a recorded unit that answers as it did; options: --set seek=600, speed=2, loop=1",
    ru="записанный блок: отвечает, как в записи; ещё --set seek=600, speed=2, loop=1",
)
@option(
    "--unit",
    metavar="FILE",
    shell_complete=files(*UNIT),
    en="answers as the unit of a survey does (FILE.zip, or its unit.json)",
    ru="отвечает, как блок из обследования (ФАЙЛ.zip или unit.json из него)",
)
@option(
    "--tcp",
    metavar="HOST:PORT",
    shell_complete=words("127.0.0.1:", "0.0.0.0:"),
    en="on TCP instead of a pty (port 0: any)",
    ru="по TCP вместо pty (порт 0: любой)",
)
@option(
    "--model",
    words=MODELS,
    en="model of the unit (7.1)",
    ru="модель блока (7.1)",
)
@option(
    "--scenario",
    metavar="NAME|FILE",
    shell_complete=scenarios,
    en="driving scenario (warm-idle)",
    ru="сценарий поездки (warm-idle)",
)
@option(
    "--car",
    metavar="LIST",
    shell_complete=cars,
    en="healthy, defects with amounts (leak:8,battery), or one to find out: blind:4711",
    ru="healthy (исправная), неисправности (leak:8,battery) или загадка: blind:4711",
)
@option(
    "--answer",
    metavar="CAR",
    shell_complete=words("blind:"),
    en="only names the defects of the car: blind:4711",
    ru="только отвечает, что с машиной: blind:4711",
)
@option(
    "--faults",
    metavar="LIST",
    shell_complete=fault_codes,
    en="stored faults: 13,53",
    ru="ошибки в памяти: 13,53",
)
@flag("--no-echo", en="an adapter without echo", ru="адаптер без эха")
@option(
    "--baud",
    metavar="N",
    en="baud rate on the line (9600)",
    ru="скорость на линии, бит/с (9600)",
)
@option(
    "--seed",
    metavar="N",
    en="seed of the random numbers (0)",
    ru="начальное число случайной последовательности (0)",
)
@option(
    "--latency-ms",
    metavar="MS",
    en="the adapter's latency timer (0)",
    ru="таймер задержки адаптера (0)",
)
@option(
    "--line-fault",
    "line_faults",
    multiple=True,
    metavar="KIND=RATE",
    shell_complete=line_faults,
    en=f"damaged=0.01; also {_LINE_FAULTS}",
    ru=f"damaged=0.01; ещё {_LINE_FAULTS}",
)
@option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    shell_complete=unit_settings,
    en="any other setting, as unknown=01, max_list=8, missing=stream+list, supplied=0",
    ru="любая другая настройка: unknown=01, max_list=8, missing=stream+list, supplied=0",
)
@option(
    "--instrument",
    "instruments",
    multiple=True,
    words=tuple(BAUDS),
    en="also a λ meter or GPS in this car, on a pty of its own",
    ru="ещё лямбда-прибор или GPS в этой машине, на своём pty",
)
def sim(
    context: CommandContext,
    replay: Path | None,
    tcp: str | None,
    answer: str | None,
    line_faults: Sequence[str],
    settings: Sequence[str],
    instruments: Sequence[str],
    *,
    no_echo: bool,
    **named: str | None,
) -> None:
    if answer is not None:
        _say_answer(context, answer)
        return
    wanted = {name: value for name, value in named.items() if value is not None}
    wanted |= dict(_pair(word) for word in (*line_faults, *settings))
    if no_echo:
        wanted["echo"] = "0"
    clock = AwakeClock()
    if replay is None:
        bus = build_bus(wanted, start=clock.now(), watcher=_watcher(context))
    else:
        bus = _recorded(context, replay, wanted)
    serve.run(_serve(context, bus, clock, _host_and_port(tcp) if tcp else None, instruments))


def _say_answer(context: CommandContext, car: str) -> None:
    """Print the defects of the car that `car` names."""
    from mikas.virtual.defects.choosing import answer

    found = answer(car)
    sound = tr("Nothing: this car is sound.", "Ничего: машина исправна.")
    context.output.result(
        {
            "car": car,
            "defects": [
                {"key": each.key, "amount": each.amount, "text": each.text._asdict()}
                for each in found
            ],
        },
        "\n".join(f"{tr(*each.text)} ({each.key}:{each.amount:g})" for each in found) or sound,
    )


def _recorded(context: CommandContext, path: Path, wanted: Mapping[str, str]) -> Bus:
    """Return the recorded unit; the recording starts with the first request."""
    from mikas.replay import car_on, replay_bus

    for name in CAR_SETTINGS:
        if name in wanted:
            raise usage_error(
                f"--{name} can't be used with --replay: the car is the recorded one",
                f"--{name} нельзя указать вместе с --replay: машина взята из записи",
            )
    bus = replay_bus(path, wanted, catalog=context.options.catalog)
    car = car_on(bus)
    bus.ecu.watcher = _reporting_the_end(context, path, car)
    if car is not None and car.recorded.problems:
        count = car.recorded.problems
        context.say(
            f"{path}: damaged places skipped: {count}; mikas decode shows them",
            f"{path}: пропущено повреждённых мест: {count}; их покажет mikas decode",
        )
    return bus


def _reporting_the_end(
    context: CommandContext, path: Path, car: ReplayCar | None
) -> Callable[[EcuEvent], None]:
    """Return a watcher that also reports, once, the end of the recording."""
    watcher, is_reported = _watcher(context), False

    def watch(event: EcuEvent) -> None:
        nonlocal is_reported
        if watcher is not None:
            watcher(event)
        if is_reported or event.kind != "power-off" or car is None or not car.is_over(event.time):
            return
        is_reported = True
        if context.output.json and watcher is not None:
            watcher(EcuEvent(event.time, "recording-over"))
        context.say(
            f"The recording {path} is over: the unit is now silent, as with the ignition off. "
            "Run the same command to play it again; --set loop=1 repeats it.",
            f"Запись {path} закончилась: теперь блок молчит, как при выключенном зажигании. "
            "Повторить — той же командой; --set loop=1 повторяет запись по кругу.",
        )

    return watch


async def _serve(
    context: CommandContext,
    bus: Bus,
    clock: AwakeClock,
    tcp: tuple[str, int] | None,
    instruments: Sequence[str],
) -> None:
    beside = _instruments(bus, clock, instruments)
    if tcp is None:
        if os.name != "posix":
            raise usage_error(
                "This system has no pseudo-terminals; use --tcp 127.0.0.1:2000",
                "В этой системе нет псевдотерминалов; используйте --tcp 127.0.0.1:2000",
            )
        port: serve.PtyPort | serve.TcpPort = serve.PtyPort(bus, clock.now)
    else:
        port = await serve.TcpPort.open(bus, clock.now, *tcp)
    try:
        context.output.result({"url": port.url}, port.url)
        for each in beside:
            shown = f"{each.name}={each.url}"
            context.output.result({"instrument": each.name, "url": each.url}, shown)
        context.say("Ctrl-C ends it.", "Выход: Ctrl-C.")
        await asyncio.Event().wait()
    finally:
        for each in beside:
            each.close()
        port.close()


def _instruments(bus: Bus, clock: AwakeClock, names: Sequence[str]) -> list[serve.InstrumentPty]:
    """Return the instruments in the car, each on a pty."""
    car = bus.ecu.responder.car
    if names and not isinstance(car, EngineCar):
        raise usage_error(
            "--instrument can't be used with --replay: a recording has its own instruments",
            "--instrument нельзя указать вместе с --replay: у записи свои приборы",
        )
    if names and os.name != "posix":
        raise usage_error(
            "This system has no pseudo-terminals, which --instrument needs",
            "В этой системе нет псевдотерминалов, а они нужны для --instrument",
        )
    return [
        serve.InstrumentPty(VirtualInstrument(name, car, clock.now()), clock.now)
        for name in names
        if isinstance(car, EngineCar)
    ]


def _watcher(context: CommandContext) -> Callable[[EcuEvent], None] | None:
    def watch(event: EcuEvent) -> None:
        data = event.data.hex().upper()
        if context.output.json:
            context.output.data(
                {"time": round(event.time, 6), "event": event.kind, "data": data or None}
            )
        else:
            context.output.detail(f"{event.time:.3f}", event.kind, data)

    return watch if context.output.json or context.output.verbose else None


def _pair(word: str) -> tuple[str, str]:
    name, equals, value = word.partition("=")
    if not equals:
        raise usage_error(
            f"Write NAME=VALUE, not “{word}”; names: {', '.join(SETTINGS)}",
            f"Пишите NAME=VALUE, а не «{word}»; имена: {', '.join(SETTINGS)}",
        )
    return name.strip(), value.strip()


def _host_and_port(text: str) -> tuple[str, int]:
    host, _, port = text.rpartition(":")
    if not port.isascii() or not port.isdigit() or int(port) > 0xFFFF:
        raise usage_error(
            f"“{text}” is not HOST:PORT; write 127.0.0.1:2000",
            f"«{text}» — не HOST:PORT; пишите 127.0.0.1:2000",
        )
    return host.strip("[]") or "127.0.0.1", int(port)
