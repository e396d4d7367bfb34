"""One survey from its begin, or from where it was stopped, to the ZIP."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from copy import deepcopy
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version as installed_version
from pathlib import Path
from typing import Final

from mikas.client import Ecu
from mikas.commands.unit import version_text
from mikas.errors import EchoOnly, NoEcho, NotConfirmed, usage_error
from mikas.i18n import Text
from mikas.link import CaptureTee
from mikas.survey.answers import SurveyAnswer
from mikas.survey.archive import SurveyFile, archive
from mikas.survey.concluding import conclude
from mikas.survey.folder import SurveyFolder
from mikas.survey.person import Prompter
from mikas.survey.profile import profile
from mikas.survey.readme import readme
from mikas.survey.recording import NO_UNITS, SurveyCapture, joined_captures, port_kind
from mikas.survey.states import bring, has_left
from mikas.survey.steps.codes import known_sizes
from mikas.survey.steps.step import CarState, Measured, SurveyStep
from mikas.survey.steps.table import STANDING_AGAIN, STEPS
from mikas.survey.unit import SurveyedUnit

__all__ = ["Survey", "SurveyOptions"]

_SAVED_EVERY: Final = 5.0  # s of the link's clock, within a step
_ATTEMPTS: Final = 3  # at a step during which the car leaves its state
_OF_THE_SURVEY: Final = {"done", "seconds", "skipped", "lasted"}
"""What is known of the survey itself, not measured by a step."""
_NO_ENGINE: Final = Text(
    "the survey was made without the engine", "обследование сделано без пуска двигателя"
)
_NOT_KEPT: Final = Text(
    "the car did not stay so until it was measured",
    "машина не оставалась в этом состоянии до конца измерения",
)
_DAMAGED: Final = (ValueError, TypeError, LookupError, AttributeError)


@dataclass(frozen=True, slots=True)
class SurveyOptions:
    """What the owner consents to."""

    memory: bool = False
    """Whether memory may be read (11, 13, 15, 21, 23, 25, 31)."""
    passports: bool = False
    """Whether the texts of the passports may be kept."""
    engine: bool = True
    """Whether the engine may be started."""


class Survey:
    """A survey of the connected `ecu` for the ZIP `out`.

    `run` measures, `answers` concludes, `save` writes. A survey that was stopped goes on: its
    folder beside `out` has what was measured; the consents of its begin stay in force, but the
    engine may be left out later.
    """

    def __init__(self, ecu: Ecu, out: Path, options: SurveyOptions, person: Prompter) -> None:
        self.folder: SurveyFolder = SurveyFolder(out)
        """What is kept until the ZIP is written."""
        self._person = person
        self._unit = SurveyedUnit(ecu)
        code = version_text(ecu.version_code)
        self._kept_at = ecu.tester.link.now()
        before = self.folder.load()
        self.goes_on: bool = before is not None
        """Whether a survey that was stopped goes on."""
        try:
            self._measured = _begun(ecu, options) if before is None else before
            self._measured["engine"] &= options.engine
            self._done: list[str] = self._measured["done"]
            self._seconds: dict[str, float] = self._measured["seconds"]
            self._unit.sizes = known_sizes(self._measured)
            self._unit.use_what_is_known(self._measured)
            known, here = self._measured["version_code"], port_kind(ecu.tester.link.url)
            port = self._measured.setdefault("port", here)  # of an earlier version: not known
        except _DAMAGED as error:
            raise self.folder.damaged() from error
        if known != code:
            raise usage_error(
                f"{self.folder.path} is of another unit ({known}, this one is {code}): finish it "
                "there, remove it, or name another file",
                f"{self.folder.path}: это другой блок ({known}, а здесь {code}): закончите с тем, "
                "удалите папку или назовите другой файл",
            )
        if (port in NO_UNITS) is not (here in NO_UNITS):
            raise usage_error(
                f"{self.folder.path}: a virtual unit and a real one make no survey together: "
                "remove the folder, or name another file",
                f"{self.folder.path}: виртуальный блок и настоящий нельзя смешать в одном "
                "обследовании: удалите папку или назовите другой файл",
            )

    def run(self, on_step: Callable[[SurveyStep, int, int], None] = lambda *_: None) -> None:
        """Do the steps that are left. `on_step` gets each before it begins, its place, and all.

        Whatever ends it, what was measured is kept: Ctrl-C, a `MikasError` of the line or the disk.
        """
        unit, link = self._unit, self._unit.tester.link
        self.folder.save(self._measured)  # so that a folder that can't be written is known now
        unit.ecu.forget_list()
        capture = SurveyCapture(
            self.folder.path,
            url=link.url,
            baud=link.baud,
            began=link.now(),
            before=self._measured["lasted"],
        )
        unit.capture, self._kept_at = capture, link.now()
        unit.tester.wrap_link(lambda inner: CaptureTee(inner, capture, on_failure=_raise))
        saving = _Saving(self._person, unit, self._keep)
        with closing(capture):
            try:
                self._run(saving, on_step)
            finally:
                self._keep()

    def _run(self, person: _Saving, on_step: Callable[[SurveyStep, int, int], None]) -> None:
        steps = self.steps
        # What could not be done the last time is asked for again.
        self._measured["skipped"] = {}
        if not self._measured["engine"]:
            self._measured["skipped"][CarState.STARTING.value] = _NO_ENGINE._asdict()
        for state in CarState:
            left = [it for it in steps if it.state is state and it.name not in self._done]
            if not left or state.value in self._measured["skipped"]:
                continue
            if not self._may_begin(state, person):
                continue
            for step in left:
                begins = partial(on_step, step, steps.index(step), len(steps))
                if not self._is_done(step, person, begins):
                    break

    def _is_done(self, step: SurveyStep, person: _Saving, begins: Callable[[], None]) -> bool:
        """Do one step; False: the car did not stay in its state, and the others of it are left out.

        What was measured while the engine stalled, or the pedal was let go, is of another state:
        it is forgotten, and measured again once the car is back. So is what was measured when the
        line lost so much that the unit seemed gone.
        """
        unit, measured = self._unit, self._measured
        for attempts_left in reversed(range(_ATTEMPTS)):
            if has_left(unit, step.state) and not self._may_begin(step.state, person):
                return False
            before = {name: deepcopy(measured[name]) for name in measured.keys() - _OF_THE_SURVEY}
            begins()
            began = unit.now()
            try:
                step.measure(unit, measured, person)
            except (EchoOnly, NoEcho):
                if not attempts_left or not unit.is_back():
                    raise
                is_whole = False
            else:
                is_whole = step.keeps or not has_left(unit, step.state)
            if is_whole:
                self._seconds[step.name] = round(unit.now() - began, 2)
                self._done.append(step.name)
                unit.use_what_is_known(measured)
                self._keep()
                return True
            if not step.keeps:
                for name in measured.keys() - _OF_THE_SURVEY:
                    del measured[name]
                measured.update(before)
        if step.state is CarState.STANDING:
            raise NotConfirmed(change=_SURVEY, how=_BEGINS.filled(why=_NOT_KEPT))
        self._skip(step.state, _NOT_KEPT, person)
        return False

    def _may_begin(self, state: CarState, person: _Saving) -> bool:
        """Have the car brought into `state`. Raises `NotConfirmed` without the first one."""
        if state is CarState.STANDING:
            self._unit.find_speed()
        why = bring(self._unit, state, person)
        if why is not None and state is CarState.STANDING:
            raise NotConfirmed(change=_SURVEY, how=_BEGINS.filled(why=why))
        if why is not None:
            self._skip(state, why, person)
        return why is None

    def _skip(self, state: CarState, why: Text, person: _Saving) -> None:
        person.say(why)
        self._measured["skipped"][state.value] = why._asdict()
        if state is CarState.IDLE:  # nor does it get warm, or faster
            rest = dict.fromkeys((each.value for each in _WITH_IDLE), why._asdict())
            self._measured["skipped"] |= rest

    def _keep(self) -> None:
        now = self._unit.now()
        self._measured["lasted"] += round(now - self._kept_at, 1)
        self._kept_at = now
        self.folder.save(self._measured)

    @property
    def steps(self) -> tuple[SurveyStep, ...]:
        """All steps in their order, those that are done too."""
        return STEPS if self._measured["engine"] else (*_standing(), STANDING_AGAIN)

    @property
    def answers(self) -> tuple[SurveyAnswer, ...]:
        """The answers by what was measured so far. Raises `UsageError` for a damaged folder."""
        return concluded(self.folder, self._measured)

    @property
    def measured(self) -> Measured:
        """The figures so far."""
        return self._measured

    @property
    def is_virtual(self) -> bool:
        """Whether no real unit is known to be at the port: nothing to be sent."""
        return self._measured["port"] in NO_UNITS

    @property
    def seconds(self) -> dict[str, float]:
        """The duration of each step that was done, without waiting for the car."""
        return dict(self._seconds)

    def save(self, *, overwrite: bool = False) -> SurveyFile:
        """Write the ZIP and remove the folder; return its content.

        Raises `UsageError` if it can't be written; the folder then stays.
        """
        content = content_of(self.folder, self._measured, self._unit.catalog.version)
        self.folder.finish(archive(content, readme(content)), overwrite=overwrite)
        return content


def concluded(folder: SurveyFolder, measured: Measured) -> tuple[SurveyAnswer, ...]:
    """Return the answers by what was `measured`. Raises `UsageError` for a damaged folder."""
    try:
        return conclude(measured)
    except _DAMAGED as error:
        raise folder.damaged() from error


def content_of(folder: SurveyFolder, measured: Measured, catalog: str) -> SurveyFile:
    """Return what the ZIP of `measured` holds; `catalog`: the version of the one in use.

    Raises `UsageError` for a damaged folder.
    """
    answers = concluded(folder, measured)
    try:
        unit = profile(measured, answers)
    except _DAMAGED as error:
        raise folder.damaged() from error
    versions = {"mikas": installed_version("mikas"), "catalog": catalog}
    return SurveyFile(answers, measured, unit, versions, joined_captures(folder.path))


class _Saving:
    """The person, and a save now and then: each sign of progress may be the last."""

    def __init__(self, person: Prompter, unit: SurveyedUnit, keep: Callable[[], None]) -> None:
        self._person = person
        self._unit = unit
        self._keep = keep
        self._kept_at = unit.now()

    def say(self, text: Text) -> None:
        """As the person's."""
        self._person.say(text)

    def progress(self, done: int, total: int) -> None:
        """As the person's, and save."""
        self._person.progress(done, total)
        if (now := self._unit.now()) - self._kept_at > _SAVED_EVERY:
            self._kept_at = now
            self._keep()

    def ready(self, text: Text) -> bool:
        """As the person's."""
        return self._person.ready(text)

    def number(self, name: str, text: Text, unit: Text, low: float, high: float) -> float | None:
        """As the person's."""
        return self._person.number(name, text, unit, low, high)


def _begun(ecu: Ecu, options: SurveyOptions) -> Measured:
    """Return the figures that are known before the first step."""
    tester = ecu.tester
    return {
        "version_code": version_text(ecu.version_code),
        "echo": tester.line.echo,
        "port": port_kind(tester.link.url),
        "chip": tester.link.chip,
        "granularity": tester.link.granularity,
        "baud": tester.link.baud,
        "memory": options.memory,
        "passports_consent": options.passports,
        "engine": options.engine,
        "done": [],
        "seconds": {},
        "skipped": {},
        "lasted": 0.0,
    }


def _standing() -> tuple[SurveyStep, ...]:
    return tuple(step for step in STEPS if step.state is CarState.STANDING)


def _raise(error: Exception) -> None:
    raise error


_WITH_IDLE: Final = (CarState.WARM, CarState.RAISED, CarState.AFTER)
_SURVEY: Final = Text("survey the unit", "обследовать блок")
_BEGINS: Final = Text(
    "A survey begins with the ignition on and the engine off, and {why}.",
    "Обследование начинается при включённом зажигании и заглушенном двигателе, а {why}.",
)
