"""`mikas doctor`: the connection, step by step, and what to fix."""

from __future__ import annotations

from contextlib import ExitStack

from mikas.cli.grammar import command
from mikas.cli.main import NO_CONNECTION
from mikas.cli.run import Run
from mikas.cli.words import localized, tr
from mikas.client.doctor import STEPS, Step, examine
from mikas.i18n import Text
from mikas.link import CaptureTee, Link, choose_port, open_link


@command(
    "doctor",
    Text(
        "Examines the connection step by step: port, echo, baud by echo timing, latency, errors "
        "on the line, ECU, supported commands; says what to fix. Nothing is changed.",
        "Проверяет связь по шагам: порт, эхо, скорость по эху, задержка, ошибки на линии, блок, "
        "команды; говорит, что исправить. Ничего не меняет.",
    ),
    examples=("mikas doctor", "mikas doctor --port /dev/ttyUSB0"),
)
def doctor(run: Run) -> int:
    steps = []
    with ExitStack() as stack:
        for step in examine(lambda: _open(run, stack), run.options.create_tester, run.catalog()):
            steps.append(step)
            if not run.output.json:
                run.output.line(_line(step))
    if run.output.json:
        listed = [{"name": s.name, "ok": s.ok, "detail": localized(s.detail)} for s in steps]
        run.output.data({"steps": listed})
    failed = any(step.ok is False for step in steps)
    if not failed and not run.output.json:
        run.output.line(_end(all(step.ok for step in steps)))
    return NO_CONNECTION if failed else 0


def _end(well: bool) -> str:
    if well:
        return tr("All is well. Next: mikas read", "Всё в порядке. Дальше: mikas read")
    return tr(
        "It works; see • above. Next: mikas read", "Связь есть; см. • выше. Дальше: mikas read"
    )


def _open(run: Run, stack: ExitStack) -> Link:
    port = run.port or choose_port()
    sink = stack.enter_context(run.capturing(port))
    link = open_link(port)
    if sink is None:
        return link
    tee = CaptureTee(link, sink)
    stack.callback(run.check_capture, tee)
    return tee


def _line(step: Step) -> str:
    mark = {True: "✓", False: "✗", None: "•"}[step.ok]
    names = dict(
        zip(
            STEPS,
            (
                tr("port", "порт"),
                tr("echo", "эхо"),
                tr("baud", "скорость"),
                tr("latency", "задержка"),
                tr("line", "линия"),
                tr("ECU", "блок"),
                tr("commands", "команды"),
            ),
            strict=True,
        )
    )
    return f"{mark} {names[step.name]}: {localized(step.detail)}"
