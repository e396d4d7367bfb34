"""One run of a survey in its thread: it has the port, and asks the person by what it shows.

The thread alone changes `shown`, by a new value each time, so any thread may look at it. A question
waits for `answer`, without a limit: the person walks round the car meanwhile.
"""

from __future__ import annotations

import queue
from collections.abc import Callable, Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

from mikas.client import Ecu
from mikas.client.connecting import ConnectionOptions, open_ecu
from mikas.dashboard.errors import BadRequest, Busy
from mikas.dashboard.session.port_threads import StoppablePort, Stopped, logged
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.link import Link
from mikas.survey import Survey, SurveyOptions, SurveyVerdict
from mikas.survey.steps.step import CarState, SurveyStep

_NO_UNIT: Final = Text("", "")
_ANSWERED: Final = Text("this question is no longer asked", "этот вопрос уже не задан")
_NO_FIGURE: Final = Text(
    "the figure must be from {low:g} to {high:g} {unit.en}",
    "нужно число от {low:g} до {high:g} {unit.ru}",
)


USUAL: Final[Mapping[str, float]] = {
    "least_pause": 1.5, "unknown": 4.5, "codes": 75.0, "lists": 5.0, "blocks": 2.0,
    "stream_standing": 2.5, "cranking": 8.0, "stream_idle": 2.5, "strokes": 26.0,
    "tachometer": 5.0, "codes_again": 75.0, "factors": 5.5, "stream_raised": 2.5,
    "strokes_raised": 3.5,
}  # fmt: skip
"""The seconds that the longer steps take on a unit that answers, without waiting for the person."""
_SHORT: Final = 1.0  # s of any other step


@dataclass(frozen=True, slots=True)
class PersonAsked:
    """A question to the person: whether something is done, or a figure."""

    id: int
    """Counts the questions of a run."""
    kind: Literal["ready", "number"]
    """What the answer is."""
    text: Text
    """The question."""
    name: str = ""
    """Of the instrument whose figure is asked for: `tachometer`."""
    unit: Text = _NO_UNIT
    """The figure's unit."""
    low: float = 0.0
    """The smallest figure."""
    high: float = 0.0
    """The greatest figure."""


@dataclass(frozen=True, slots=True)
class SurveyProgress:
    """How far a run is."""

    step: SurveyStep | None = None
    """The step under way; None: the port is being opened."""
    steps: int = 0
    """All steps."""
    place: int = 0
    """The step's place among them, from 0."""
    done: int = 0
    """How far the step is."""
    of: int = 0
    """What `done` counts up to; 0: the step does not count."""
    later: float = 0.0
    """Seconds that the steps after it usually take."""
    instruction: Text | None = None
    """What the person shall do, while the car is waited for."""
    asked: PersonAsked | None = None
    """The question that waits for an answer."""
    found: int = 0
    """Questions about the unit that are answered."""
    open: int = 0
    """Questions about the unit that are not."""

    @property
    def left(self) -> float | None:
        """The seconds of measuring that are left, without the person's own; None: not known."""
        if self.step is None:
            return None
        share = 1 - self.done / self.of if self.of else 1.0
        return share * usual_seconds(self.step) + self.later


def usual_seconds(step: SurveyStep) -> float:
    """Return the seconds that a step takes on a unit that answers."""
    return USUAL.get(step.name, _SHORT)


class SurveyRun(StoppablePort):
    """Surveys the unit at `url` for the ZIP `out`; `figures`: of instruments, given before.

    Implements `mikas.survey.Prompter`; each method raises `KeyboardInterrupt` after `stop`.
    """

    def __init__(
        self,
        url: str,
        out: Path,
        options: SurveyOptions,
        figures: Mapping[str, float | None],
        *,
        open_port: Callable[[str], Link],
        connection: ConnectionOptions,
    ) -> None:
        super().__init__(open_port)
        self.url = url
        self.out = out
        self.shown: SurveyProgress = SurveyProgress()
        """How far it is; any thread may look."""
        self.options: SurveyOptions = options
        """What the owner consents to."""
        self.finished: bool = False
        """Whether all was asked."""
        self._connection, self._figures = connection, figures
        self._answers: queue.Queue[float | bool | None] = queue.Queue()
        self._questions = 0
        self._ecu: Ecu | None = None

    def run(self) -> None:
        """Survey until all is asked, or until `stop`. The port is free when this returns.

        Raises what the line, the disk or the unit raises, and `InternalError` for a bug.
        """
        try:
            with closing(open_ecu(self.open(self.url), self._connection)) as ecu:
                self._ecu = ecu
                survey = Survey(ecu, self.out, self.options, self)
                survey.run(lambda step, place, steps: self._begin(survey, step, place, steps))
                self._count(survey)
                self.finished = True
        except (Stopped, KeyboardInterrupt):
            return
        except MikasError:
            if not self.stopping.is_set():  # else it failed by the closed link
                raise
        except Exception as bug:  # any: the page shows it
            raise logged("a bug in the survey", bug, self.url) from bug
        finally:
            self.close()

    def end(self) -> None:
        """End it before its next exchange, with a running stream ended (D12); from any thread."""
        self.stopping.set()
        if (ecu := self._ecu) is not None:
            ecu.tester.end_calls()
        else:
            self.close()
        self._answers.put(None)

    def answer(self, question: int, value: float | bool | None) -> None:
        """Answer the question that waits. Raises `Busy` for another one, `BadRequest`."""
        asked = self.shown.asked
        if asked is None or asked.id != question:
            raise Busy(problem=_ANSWERED)
        if asked.kind == "number" and value is not None and not asked.low <= value <= asked.high:
            limits = {"low": asked.low, "high": asked.high, "unit": asked.unit}
            raise BadRequest(problem=Text(*(each.format(**limits) for each in _NO_FIGURE)))
        self.shown = replace(self.shown, asked=None)
        self._answers.put(value)

    def say(self, text: Text, /) -> None:
        """Show what to do, until the next step begins."""
        self._check()
        self.shown = replace(self.shown, instruction=text)

    def progress(self, done: int, total: int, /) -> None:
        """Show how far the step is."""
        self._check()
        self.shown = replace(self.shown, done=done, of=total)

    def ready(self, text: Text, /) -> bool:
        """Ask to do something that the unit does not show."""
        return self._ask(PersonAsked(self._questions, "ready", text)) is True

    def number(self, name: str, text: Text, unit: Text, low: float, high: float, /) -> float | None:
        """Ask for a figure, unless it was given, or refused, before."""
        if name in self._figures:
            return self._figures[name]
        return self._ask(PersonAsked(self._questions, "number", text, name, unit, low, high))

    def _ask(self, asked: PersonAsked) -> float | bool | None:
        self._questions += 1
        self._check()
        self.shown = replace(self.shown, asked=asked)
        answer = self._answers.get()
        self._check()
        self.shown = replace(self.shown, asked=None)
        return answer

    def _begin(self, survey: Survey, step: SurveyStep, place: int, steps: int) -> None:
        self._check()
        later = sum(usual_seconds(each) for each in survey.steps[place + 1 :])
        # The starter is looked at from the moment that the person is asked to turn it.
        todo = self.shown.instruction if step.state is CarState.STARTING else None
        self.shown = SurveyProgress(step, steps, place, later=later, instruction=todo)
        self._count(survey)

    def _count(self, survey: Survey) -> None:
        answers = survey.answers
        found = sum(each.verdict is SurveyVerdict.FOUND for each in answers)
        self.shown = replace(self.shown, found=found, open=len(answers) - found)

    def _check(self) -> None:
        if self.stopping.is_set():
            raise KeyboardInterrupt
