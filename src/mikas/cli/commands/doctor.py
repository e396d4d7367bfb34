"""`mikas doctor`: the connection, step by step, and what to fix."""

from __future__ import annotations

from mikas.cli.grammar import command
from mikas.cli.main import NO_CONNECTION
from mikas.cli.run import Run
from mikas.cli.words import say, shown
from mikas.client.doctor import STEPS, Step, examine
from mikas.language import Text
from mikas.link import Link, choose_port, open_link
from mikas.tester import Echo, Tester, Timing


@command(
    "doctor",
    Text(
        "Examines the connection step by step: port, echo, baud by echo timing, latency, ECU, "
        "supported commands; says what to fix. Nothing is changed.",
        "Проверяет связь по шагам: порт, эхо, скорость по эху, задержка, блок, команды; говорит, "
        "что исправить. Ничего не меняет.",
    ),
    examples=("mikas doctor", "mikas doctor --port /dev/ttyUSB0"),
)
def doctor(run: Run) -> int:
    steps = []
    for step in examine(lambda: _open(run), lambda link: _tester(run, link), run.catalog()):
        steps.append(step)
        if not run.output.json:
            run.output.line(_line(step))
    if run.output.json:
        listed = [{"name": s.name, "ok": s.ok, "detail": shown(s.detail)} for s in steps]
        run.output.data({"steps": listed})
    failed = any(step.ok is False for step in steps)
    if not failed and not run.output.json:
        run.output.line(say("All is well. Next: mikas read", "Всё в порядке. Дальше: mikas read"))
    return NO_CONNECTION if failed else 0


def _open(run: Run) -> Link:
    return open_link(run.port or choose_port())


def _tester(run: Run, link: Link) -> Tester:
    return Tester(
        link, timing=Timing(first_byte=run.timeout), echo=Echo(run.echo), retries=run.retries
    )


def _line(step: Step) -> str:
    mark = {True: "✓", False: "✗", None: "•"}[step.ok]
    names = dict(
        zip(
            STEPS,
            (
                say("port", "порт"),
                say("echo", "эхо"),
                say("baud", "скорость"),
                say("latency", "задержка"),
                say("ECU", "блок"),
                say("commands", "команды"),
            ),
            strict=True,
        )
    )
    return f"{mark} {names[step.name]}: {shown(step.detail)}"
