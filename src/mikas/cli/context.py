"""The context of one command: settings, connection to the ECU, confirmation of changes.

Settings come from the command line, else the environment (MIKAS_PORT), else the config file, else
the defaults. A command gets its context as its first argument.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mikas.cli import config
from mikas.cli.advice import ADVICE
from mikas.cli.language import capital, localized, tr
from mikas.cli.render.output import Output
from mikas.cli.render.terminal import cell_text, write_error
from mikas.errors import CaptureError, MikasError, NotConfirmed, NotSupported
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.catalog.own.file import OwnCatalog
    from mikas.cli.port_ahead import PortAhead
    from mikas.client import Change, Confirm, Ecu
    from mikas.client.connecting import ConnectionOptions
    from mikas.link import CaptureTee, Link
    from mikas.recording import CaptureWriter
    from mikas.recording.recording import Recording

_NO_TERMINAL = Text(
    "There is no terminal to ask on; --yes confirms in advance.",
    "Нет терминала, чтобы спросить; подтвердить заранее можно ключом --yes.",
)
_ANSWERED_NO = Text("The answer was no.", "Ответ был «нет».")
_NOT_SURE = Text(
    "Here --yes requires --i-know-what-this-does.",
    "Здесь --yes действует только вместе с --i-know-what-this-does.",
)
_NOT_RECORDED = Text(
    "A recording answers only the requests that it contains; for others the car is needed.",
    "Запись отвечает только на те запросы, которые в ней есть; для остальных нужна машина.",
)


def _note_date(writer: CaptureWriter, link: CaptureTee) -> None:
    """Note by how much the computer's date was set, if it was. Raises `CaptureError`."""
    from mikas.sampling.date_watch import LEAST, in_grains

    if abs(seconds := in_grains(link.date_set)) < LEAST:
        return
    from mikas.recording.annotations.events import note_of
    from mikas.sampling.events import ClockChanged

    date = link.date()
    writer.note(note_of(ClockChanged(link.now(), seconds, False, date - seconds, date)))


def _connection(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of `ConnectionOptions` that are among `settings`."""
    same = ("echo", "timeout", "retries", "pause", "interpretation", "strict")
    fields = {name: settings[name] for name in same if name in settings}
    if "inter_byte" in settings:
        fields["inter_byte_timeout"] = settings["inter_byte"]
    if "checksum" in settings:
        fields["raw_checksum"] = settings["checksum"] == "raw"
    return fields


@dataclass
class CommandContext:
    """Settings of this command. `port` None: the one likely adapter.

    `connection`: the fields of `ConnectionOptions` that the user has set. `relearn`: forget the
    learnt limits of the unit. `logs`: show the log.
    """

    port: str | None = None
    capture: Path | None = None
    catalogs: tuple[Path, ...] = ()
    connection: dict[str, Any] = field(default_factory=dict)
    output: Output = field(default_factory=Output)
    relearn: bool = False
    logs: bool = False

    @classmethod
    def from_options(cls, given: Mapping[str, Any]) -> CommandContext:
        """Combine the common options, the environment and the config file."""
        stored = config.load()
        settings = {**stored, **given}
        verbosity = given.get("verbose", 0)
        environment = os.environ.get("MIKAS_PORT", "").strip()
        return cls(
            port=given.get("port", environment or stored.get("port")),
            capture=given.get("capture"),
            catalogs=tuple(map(Path, [*stored.get("catalog", ()), *given.get("catalog", ())])),
            connection=_connection(settings),
            output=Output(json=bool(given.get("json")), verbose=verbosity > 0),
            relearn=bool(given.get("relearn")),
            logs=verbosity > 1,
        )

    @cached_property
    def own_catalog(self) -> OwnCatalog:
        """The user's own catalog, below the files of `--catalog`."""
        from mikas.catalog.own.file import OwnCatalog

        return OwnCatalog(config.own_catalog(), self.catalogs)

    @cached_property
    def options(self) -> ConnectionOptions:
        """The options of the connection, with the shipped catalog overlaid by the user's files."""
        from mikas.catalog.own.file import left_out
        from mikas.client.connecting import ConnectionOptions

        loaded = self.own_catalog.load()
        if (problem := loaded.problem) is not None:
            self.say(*left_out(problem))
        return ConnectionOptions(catalog=loaded.catalog, **self.connection)

    def say(self, en: str, ru: str) -> None:
        """Print a sentence on stderr, in the current language."""
        self.output.print_note(cell_text(tr(en, ru)))

    def say_damaged(self, recording: Recording) -> None:
        """Print how many places of a recording are damaged, if any: the rest is measured."""
        if count := recording.problem_count:
            self.say(
                f"{recording.path}: {count} damaged place(s); the readable rest counts.",
                f"{recording.path}: повреждённых мест: {count}; взято всё остальное.",
            )

    def say_sent(self) -> None:
        """Print that a request without an expected response was sent."""
        self.say(
            "Sent. No response, as expected (D9).", "Отправлено. Ответа нет, как и ожидалось (D9)."
        )

    def open_ahead(self, instruments: Sequence[str] = ()) -> PortAhead:
        """Open the port, before the rest of the program is imported. Raises as `PortAhead`.

        `instruments`: those beside the unit, as NAME=URL; at their ports no unit is looked for.
        """
        from mikas.cli.port_ahead import PortAhead
        from mikas.link import choose_port, find_ports

        if self.port or not instruments:
            return PortAhead(self.port or choose_port())
        from mikas.instruments.places import likely_beside

        taken = [text.partition("=")[2].strip() for text in instruments]
        return PortAhead(likely_beside(taken, find_ports()))

    @contextmanager
    def ecu(self, confirm: Confirm | None = None) -> Iterator[Ecu]:
        """Connect to the ECU; with `--capture` everything on the wire is recorded."""
        from mikas.client.connecting import open_ecu
        from mikas.link import choose_port

        port = self.port or choose_port()
        with (
            self.capturing(port) as sink,
            open_ecu(
                port,
                replace(self.options, confirm=confirm),
                sink=sink,
                on_sink_failure=lambda _: None,  # said at the end, by `end_capture`
            ) as ecu,
        ):
            self.output.detail(
                tr("port", "порт"), port,
                tr("echo", "эхо"), tr("yes", "есть") if ecu.tester.line.echo else tr("no", "нет"),
            )  # fmt: skip
            if self.relearn:
                ecu.forget_limits()
            try:
                yield ecu
                if ecu.tester.pauses.found is not None:
                    ecu.limits()  # saves it
            except NotSupported as error:
                if port.startswith("replay:"):
                    error.advice = _NOT_RECORDED
                raise
            finally:
                self.end_capture(sink, ecu.tester.link)

    @contextmanager
    def capturing(self, port: str) -> Iterator[CaptureWriter | None]:
        """Open the capture file of `--capture`; None without it."""
        if self.capture is None:
            yield None
            return
        from mikas.recording import CaptureWriter

        with CaptureWriter(self.capture, url=port) as writer:
            try:
                yield writer
            except BaseException:
                writer.discard_if_empty()
                raise

    def end_capture(self, writer: CaptureWriter | None, link: Link) -> None:
        """Note in the capture on `link` a date that was set meanwhile; print its failure."""
        from mikas.link import CaptureTee

        if writer is None or not isinstance(link, CaptureTee):
            return
        if link.failure is None:
            try:
                _note_date(writer, link)
            except CaptureError as error:
                link.failure = error
        failure = link.failure
        if failure is not None and failure is not sys.exception():  # else it is printed anyway
            reason = (
                localized(ADVICE.text(failure)) if isinstance(failure, MikasError) else str(failure)
            )
            self.say(f"Recording stopped early: {reason}", f"Запись прервалась: {reason}")

    def confirm(
        self, *, yes: bool, meaning: Callable[[str], str] | None = None
    ) -> Callable[[Change], bool]:
        """Return a function that asks at the terminal before a change; `yes` confirms in advance.

        `meaning`: turns the hex before and after the change into a value.
        """

        def ask(change: Change) -> bool:
            self.output.print_note(_described(change, meaning))
            require_consent(change.what, yes=yes)
            return True

        return ask


def check_sure(change: Text, *, yes: bool, sure: bool) -> None:
    """Raise `NotConfirmed` if `--yes` stands without `--i-know-what-this-does`."""
    if yes and not sure:
        raise NotConfirmed(change=change, how=_NOT_SURE)


def require_consent(what: Text, *, yes: bool) -> None:
    """Ask at the terminal unless `yes`. Raises `NotConfirmed`."""
    if yes:
        return
    if not sys.stdin.isatty():
        raise NotConfirmed(change=what, how=_NO_TERMINAL)
    write_error(tr("Do it? [y/N] ", "Выполнить? [д/Н] "))
    answer = sys.stdin.readline()
    if not answer.endswith("\n"):
        write_error("\n")  # Ctrl-D leaves the cursor after the question
    if answer.strip().lower() not in ("y", "yes", "д", "да"):
        raise NotConfirmed(change=what, how=_ANSWERED_NO)


def _described(change: Change, meaning: Callable[[str], str] | None) -> str:
    lines = [capital(localized(change.what))]
    if change.warning is not None:
        lines.append(f"  {localized(change.warning)}")
    if change.before is not None:
        before = (meaning(change.before) if meaning else change.before) or "–"
        lines.append(tr(f"  before: {before}", f"  было:  {before}"))
    if change.after is not None and change.after not in change.what.en:
        after = (meaning(change.after) if meaning else change.after) or "–"
        has_before = change.before is not None
        label = tr("after: ", "будет:") if has_before else tr("bytes:", "байты:")
        lines.append(f"  {label} {after}")
    if change.safety.name == "DANGEROUS":
        lines.append(
            tr(
                "  DANGER: after this change the engine may no longer start.",
                "  ОПАСНО: после этого изменения двигатель может не завестись.",
            )
        )
    return "\n".join(lines)
