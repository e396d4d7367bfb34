"""One run of the program: its settings, its way to the ECU, its way of asking.

Settings come from the command line, else the environment (MIKAS_PORT), else the config file, else
the defaults; everything that a command needs beyond its own arguments it gets from here.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mikas.cli import config
from mikas.cli.output import Output
from mikas.cli.words import say, shown
from mikas.errors import NotConfirmed
from mikas.language import Text

if TYPE_CHECKING:
    from mikas.catalog import Catalog
    from mikas.client import Change, Confirm, Ecu

_HOW = Text(
    "There is no terminal to ask at; --yes says yes beforehand.",
    "Спросить не у кого (нет терминала); заранее согласиться: --yes.",
)
_NO = Text("Nothing was sent.", "Ничего не послано.")


@dataclass(slots=True)
class Run:
    """Settings of this run. `port` None: the one likely adapter."""

    port: str | None = None
    echo: str = "auto"
    timeout: float = 0.5
    retries: int = 2
    capture: Path | None = None
    reading: str = "corrected"
    catalogs: tuple[Path, ...] = ()
    verbose: bool = False
    output: Output = field(default_factory=Output)

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Run:
        """From the command line's common options, the environment and the config file."""
        stored = config.load()
        settings = {**stored, **_environment(), **given}
        run = cls(output=Output(json=bool(given.get("json"))), verbose=bool(given.get("verbose")))
        run.port = settings.get("port")
        run.echo = settings.get("echo", run.echo)
        run.timeout = settings.get("timeout", run.timeout)
        run.retries = settings.get("retries", run.retries)
        run.reading = settings.get("reading", run.reading)
        run.catalogs = tuple(map(Path, [*stored.get("catalog", ()), *given.get("catalog", ())]))
        run.capture = Path(given["capture"]) if given.get("capture") else None
        return run

    def catalog(self) -> Catalog:
        """The shipped definitions with the user's over them."""
        from mikas.catalog import load

        return load(*self.catalogs)

    @contextmanager
    def ecu(self, confirm: Confirm | None = None) -> Iterator[Ecu]:
        """A connected ECU, captured if that was asked for."""
        from mikas.client import connect
        from mikas.link import choose_port

        port = self.port or choose_port()
        with (
            self._capturing(port) as sink,
            connect(
                port,
                echo=self.echo,
                timeout=self.timeout,
                retries=self.retries,
                reading=self.reading,
                catalogs=self.catalogs,
                confirm=confirm,
                sink=sink,
            ) as ecu,
        ):
            self.output.detail(
                say("port", "порт"), ecu.tester.link.description,
                say("echo", "эхо"), say("yes", "есть") if ecu.tester.echoes else say("no",
                "нет"),
            )  # fmt: skip
            yield ecu
            self._check_capture(ecu)

    @contextmanager
    def _capturing(self, port: str) -> Iterator[Any]:
        if self.capture is None:
            yield None
            return
        from mikas.recording import CaptureWriter

        with CaptureWriter(self.capture, url=port) as writer:
            yield writer

    def _check_capture(self, ecu: Ecu) -> None:
        failure = getattr(ecu.tester.link, "failure", None)
        if failure is not None:
            self.output.note(
                say(f"The capture stopped early: {failure}", f"Запись оборвалась: {failure}")
            )

    def confirm(self, *, yes: bool) -> Callable[[Change], bool]:
        """Asks at the terminal before a change; `yes` answers beforehand."""

        def ask(change: Change) -> bool:
            self.output.note(_described(change))
            if yes:
                return True
            if not sys.stdin.isatty():
                raise NotConfirmed(change=change.what, how=_HOW)
            import click

            if not click.confirm(say("Do it?", "Выполнить?"), default=False, err=True):
                raise NotConfirmed(change=change.what, how=_NO)
            return True

        return ask


def _described(change: Change) -> str:
    lines = [shown(change.what)]
    if change.before is not None:
        lines.append(f"  {say('before', 'было')}: {change.before or '–'}")
    if change.after is not None:
        lines.append(f"  {say('after', 'будет')}:  {change.after or '–'}")
    if change.safety.name == "DANGEROUS":
        lines.append(
            say(
                "  DANGER: this can leave the unit unable to run the engine.",
                "  ОПАСНО: после этого блок может не завести двигатель.",
            )
        )
    return "\n".join(lines)


def _environment() -> dict[str, Any]:
    port = os.environ.get("MIKAS_PORT")
    return {"port": port} if port else {}
