"""Surveys of real units for the project: one at a time, kept beside the recordings.

A survey that was stopped, or whose cable or program was lost, goes on by its folder. It is saved
as one ZIP once the person has seen its content.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from io import BytesIO
from itertools import count
from pathlib import Path
from typing import Final, NamedTuple
from zipfile import ZipFile

from mikas.dashboard.errors import Busy, NotFound
from mikas.dashboard.session.connection import SURVEY, SURVEYING, Connection
from mikas.dashboard.session.survey_run import SurveyRun
from mikas.dashboard.settings import Settings, ensure_folder
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.survey import SurveyAnswer, SurveyOptions, SurveyVerdict
from mikas.survey.archive import archive
from mikas.survey.folder import SurveyFolder
from mikas.survey.readme import readme
from mikas.survey.survey import concluded, content_of

_NAMES: Final = {
    False: ("mikas-survey.zip", "mikas-survey-{number}.zip"),
    True: ("virtual-survey.zip", "virtual-survey-{number}.zip"),
}
"""By whether the car is a virtual one: its survey never goes on with a real unit."""
_END: Final = 3.0  # s for the end of a stream and of the handshake; then the link is closed
_NOTHING: Final = Text("no survey is under way", "нет начатого обследования")


class SurveyUnderWay(NamedTuple):
    """A survey that is neither running nor saved."""

    passports: bool
    """Whether the texts of the passports may be kept."""
    memory: bool
    """Whether memory may be read."""
    engine: bool
    """Whether the engine may be started."""
    found: int
    """Questions about the unit that are answered."""
    open: int
    """Questions about the unit that are not."""
    finished: bool
    """Whether all was asked."""


class SurveyMember(NamedTuple):
    """A file in the ZIP of a survey."""

    name: str
    """Its name."""
    bytes: int
    """Its length."""
    text: str | None
    """Its text; None: it is no text."""


class SurveyContent(NamedTuple):
    """All that the ZIP of a survey will hold."""

    answers: tuple[SurveyAnswer, ...]
    """The answers."""
    members: tuple[SurveyMember, ...]
    """The files in it."""


class Surveys:
    """The surveys in the folder of `settings`; `latest`: the run since the program's start."""

    def __init__(self, connection: Connection, settings: Callable[[], Settings]) -> None:
        self._connection, self._settings = connection, settings
        self.latest: SurveyRun | None = None
        """The run under way, or the last one."""
        self.error: MikasError | None = None
        """Why the last run ended before its end."""
        self._task: asyncio.Task[None] | None = None
        self._last_virtual: bool | None = None

    @property
    def virtual(self) -> bool:
        """Whether the survey is of a virtual car: the one under way, or else the last one."""
        if self._last_virtual is not None:
            return self._last_virtual
        of_virtual, of_real = (SurveyFolder(self._out(virtual=it)).path for it in (True, False))
        return of_virtual.exists() and not of_real.exists()

    @property
    def runs(self) -> bool:
        """Whether a survey has the port."""
        return self._task is not None

    def start(self, port: str, options: SurveyOptions, figures: Mapping[str, float | None]) -> None:
        """Start a survey, or go on with the one that was stopped; its consents stay in force.

        Raises `Busy`, `UsageError` for a folder that can't be made.
        """
        self._connection.check_unchanged()
        if self.runs:
            raise Busy(problem=SURVEYING)
        settings, chosen = self._settings(), self._connection.settings_of(port)
        ensure_folder(settings.surveys)
        self.error = None
        self._last_virtual = port.startswith("sim:")
        out = self._out()
        if SurveyFolder(out).path.exists():  # what was given to the run before is asked for again
            figures = {name: figure for name, figure in figures.items() if figure is not None}
        self.latest = run = SurveyRun(
            port,
            out,
            options,
            figures,
            open_port=settings.open_port,
            connection=replace(
                chosen.applied(settings.connection),
                journal=settings.journal,
                state=settings.units,
            ),
        )
        self._task = asyncio.create_task(self._run(run))

    async def _run(self, run: SurveyRun) -> None:
        try:
            async with self._connection.lent(SURVEY, SURVEYING):
                await asyncio.to_thread(run.run)
        except MikasError as error:
            self.error = error
        finally:
            self._task = None

    async def stop(self) -> None:
        """Stop the survey, if one runs, and wait until the port is given back."""
        run, task = self.latest, self._task
        if run is None or task is None:
            return
        run.end()
        done, _ = await asyncio.wait({task}, timeout=_END)
        if not done:
            await asyncio.to_thread(run.stop)
            await asyncio.wait({task})

    def under_way(self) -> SurveyUnderWay | None:
        """Return the survey that was stopped, or is not saved yet; None: there is none.

        Raises `UsageError` for a damaged folder.
        """
        folder = SurveyFolder(self._out())
        measured = folder.load()
        if measured is None:
            return None
        answers = concluded(folder, measured)
        found = sum(each.verdict is SurveyVerdict.FOUND for each in answers)
        return SurveyUnderWay(
            bool(measured["passports_consent"]),
            bool(measured["memory"]),
            bool(measured["engine"]),
            found,
            len(answers) - found,
            self.latest is not None and self.latest.finished,
        )

    def content(self) -> SurveyContent:
        """Return what the ZIP would hold now. Raises `NotFound`, `Busy`, `UsageError`."""
        packed, answers = self._packed()
        with ZipFile(BytesIO(packed)) as file:
            members = [(it.filename, file.read(it)) for it in file.infolist()]
        return SurveyContent(
            answers,
            tuple(
                SurveyMember(name, len(data), None if name.endswith(".pcapng") else data.decode())
                for name, data in members
            ),
        )

    def save(self) -> Path:
        """Write the ZIP, and return it. Raises `NotFound`, `Busy`, `UsageError`."""
        packed, _ = self._packed()
        self._last_virtual = self.virtual  # its folder says so, which ends here
        folder = SurveyFolder(self._out())
        folder.finish(packed)
        self.error = None  # of the run whose answers are saved now
        return folder.out

    def forget(self) -> None:
        """Remove what was measured and not saved. Raises `Busy`."""
        self._check_stopped()
        SurveyFolder(self._out()).forget()
        self.latest = self.error = self._last_virtual = None

    def saved(self) -> Path | None:
        """Return the ZIP that was saved last."""
        last = None
        for file in self._files(virtual=self.virtual):
            if not file.exists():
                return last
            last = file
        return last

    def _packed(self) -> tuple[bytes, tuple[SurveyAnswer, ...]]:
        self._check_stopped()
        folder = SurveyFolder(self._out())
        measured = folder.load()
        if measured is None:
            raise NotFound(name=folder.out.name, advice=_NOTHING)
        content = content_of(folder, measured, self._settings().connection.catalog.version)
        return archive(content, readme(content)), content.answers

    def _check_stopped(self) -> None:
        if self.runs:
            raise Busy(problem=SURVEYING)

    def _out(self, *, virtual: bool | None = None) -> Path:
        """Return the ZIP of the survey under way, or of the next one: the first free name."""
        kind = self.virtual if virtual is None else virtual
        return next(file for file in self._files(virtual=kind) if not file.exists())

    def _files(self, *, virtual: bool) -> Iterator[Path]:
        folder, (first, more) = self._settings().surveys, _NAMES[virtual]
        yield folder / first
        for number in count(2):
            yield folder / more.format(number=number)
