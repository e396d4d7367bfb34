"""`mikas doctor`: the connection, checked step by step."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import replace

from mikas.cli.advice import DOCTOR_ADVICE
from mikas.cli.click_extensions import command, flag
from mikas.cli.context import CommandContext
from mikas.cli.failures import NO_CONNECTION
from mikas.cli.language import localized, tr
from mikas.client.doctor import Step, examine
from mikas.errors import EchoOnly
from mikas.i18n import Text
from mikas.link import CaptureTee, Link, choose_port, open_link


@command(
    en="Checks the connection step by step: port, echo, baud rate by echo timing, latency, line "
    "errors, ECU, supported commands; says what to fix. Nothing is changed but the unit's list "
    "(64): one that another program has set is lost.",
    ru="Проверяет связь по шагам: порт, эхо, скорость по эху, задержка, ошибки на линии, блок, "
    "команды; подсказывает, что исправить. Меняет только список блока (64): заданный другой "
    "программой будет потерян.",
    examples=(
        "mikas doctor",
        "mikas doctor --port /dev/ttyUSB0",
        "mikas doctor --port socket://192.168.1.5:2000 --inter-byte 0.5",
        "mikas doctor --checksum raw --strict",
        "mikas doctor --other-units",
    ),
)
@flag(
    "--other-units",
    en="where no Mikas answers, look for another kind of unit: bytes that come unasked, `01` at "
    "other baud rates, one fast and one slow wake-up of KWP2000 at 10400 baud; changes nothing "
    "in a unit, 15 s",
    ru="если Микас не отвечает, искать блок другого рода: байты без запроса, `01` на других "
    "скоростях, одно быстрое и одно медленное пробуждение KWP2000 на 10400 бод; в блоке ничего не "
    "меняется, 15 с",
)
def doctor(context: CommandContext, *, other_units: bool) -> int:
    steps = []
    others: Callable[[Link], Iterator[Step]] | None = None
    if other_units:
        from mikas.client.other_units import other_units as looking

        others = looking
    with (
        ExitStack() as stack,
        closing(
            examine(lambda: _open(context, stack), context.options.create_ecu, others=others)
        ) as found,
    ):
        for each in found:
            is_advised = other_units and isinstance(each.error, EchoOnly)  # to do what is done
            step = replace(each, error=None) if is_advised else each
            steps.append(step)
            if not context.output.json:
                context.output.line(_line(step))
    if context.output.json:
        listed = [{"name": s.name, "ok": s.ok, "detail": localized(_detail(s))} for s in steps]
        context.output.data({"steps": listed})
    if other_units and any(step.name == "ecu" and step.ok for step in steps):
        context.say(
            "A Mikas answers, so no other kind of unit was looked for.",
            "Микас отвечает, поэтому блок другого рода не искали.",
        )
    failed = any(step.ok is False for step in steps)
    if not failed and not context.output.json:
        context.output.line(_end(all(step.ok for step in steps)))
    return NO_CONNECTION if failed else 0


def _detail(step: Step) -> Text:
    return step.detail if step.error is None else DOCTOR_ADVICE.text(step.error)


def _end(well: bool) -> str:
    if well:
        return tr("Everything works. Next: mikas read", "Всё в порядке. Дальше: mikas read")
    return tr(
        "The connection works; see • above. Next: mikas read",
        "Связь есть; см. • выше. Дальше: mikas read",
    )


def _open(context: CommandContext, stack: ExitStack) -> Link:
    port = context.port or choose_port()
    sink = stack.enter_context(context.capturing(port))
    link = open_link(port)
    if sink is None:
        return link
    tee = CaptureTee(link, sink)
    stack.callback(context.end_capture, sink, tee)
    return tee


def _line(step: Step) -> str:
    mark = {True: "✓", False: "✗", None: "•"}[step.ok]
    names = {
        "port": tr("port", "порт"),
        "echo": tr("echo", "эхо"),
        "baud": tr("baud", "скорость"),
        "latency": tr("latency", "задержка"),
        "line": tr("line", "линия"),
        "ecu": tr("ECU", "блок"),
        "commands": tr("commands", "команды"),
        "unasked": tr("bytes unasked", "байты без запроса"),
        "other-baud": tr("`01` at other baud rates", "`01` на других скоростях"),
        "kwp2000-fast": tr("KWP2000, fast wake-up", "KWP2000, быстрое пробуждение"),
        "kwp2000-slow": tr("KWP2000, slow wake-up", "KWP2000, медленное пробуждение"),
    }
    return f"{mark} {names[step.name]}: {localized(_detail(step))}"
