"""The person at the terminal during a survey: instructions, questions, a line of progress."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final

from mikas.cli.language import localized, tr
from mikas.cli.render.output import Output, StatusLine
from mikas.cli.render.terminal import write_error
from mikas.i18n import Text
from mikas.survey.states import ENGINE_OFF

_YES: Final = ("y", "yes", "д", "да")
_SKIP: Final = ("s", "skip", "п", "пропустить")


@dataclass(slots=True)
class TerminalPrompter:
    """Asks on the terminal; without one, or with `--yes`, nothing is asked.

    `figures`: those given by options, which are not asked for. `now`: the link's clock.
    """

    output: Output
    now: Callable[[], float]
    asks: bool
    figures: Mapping[str, float] = field(default_factory=dict)
    step: str = ""
    """The step under way, as the progress shows it."""
    _done: tuple[int, int] = (0, 0)
    _status: StatusLine = field(init=False)

    def __post_init__(self) -> None:
        self._status = StatusLine(self.output, self._progress)

    def begin(self, step: Text, place: int, total: int) -> None:
        """Show which step begins."""
        self.step, self._done = f"{place + 1}/{total} {localized(step)}", (0, 0)
        if not self._status.live:
            self.output.print_note(self.step)

    def say(self, text: Text, /) -> None:
        """Show an instruction or a note."""
        self._status.print_notice(f">>> {localized(text)}")

    def progress(self, done: int, total: int, /) -> None:
        """Show how far the step under way is, once a second."""
        self._done = done, total
        self._status.draw(self.now())

    def clear(self) -> None:
        """Take the line of progress away."""
        self._status.clear()

    def ready(self, text: Text, /) -> bool:
        """Ask to do something that the unit does not show.

        With `--yes` the ignition counts as on. That the engine runs does not: an answer on a
        running engine must not come from one that stands.
        """
        if not self.asks:
            return text == ENGINE_OFF
        question = tr("[Enter: done, s: skip] ", "[Enter — готово, п — пропустить] ")
        return self._answer(f"{localized(text)} {question}").lower() not in _SKIP

    def number(self, name: str, text: Text, unit: Text, low: float, high: float, /) -> float | None:
        """Ask for a figure until it is one from `low` to `high`, or none."""
        if name in self.figures or not self.asks:
            return self.figures.get(name)
        none = tr("(Enter: there is none)", "(Enter — прибора нет)")
        while answer := self._answer(f"{localized(text)} {none} "):
            typed = answer.removesuffix(unit.en).removesuffix(unit.ru).strip()  # 12,4 В
            try:
                figure = float(typed.replace(",", "."))
            except ValueError:
                figure = -1.0
            if low <= figure <= high:
                return figure
            self.output.print_note(
                tr(
                    f"“{answer}” is no number from {low:g} to {high:g} {unit.en}. Write it like "
                    f"{(low + high) / 2:g}, or press Enter alone.",
                    f"«{answer}» — не число от {low:g} до {high:g} {unit.ru}. Напишите, например, "
                    f"{(low + high) / 2:g}, или просто нажмите Enter.",
                )
            )
        return None

    def consents(self, question: Text) -> bool:
        """Ask yes or no; everything but a yes is no."""
        choice = tr("[y/N]", "[д/Н]")
        return self._answer(f"{localized(question)} {choice} ").lower() in _YES

    def _answer(self, question: str) -> str:
        """Ask, and return the answer; the end of input is an empty one.

        A terminal that is gone stops the survey, as Ctrl-C does: it can go on at another one.
        """
        try:
            self._status.clear()
            write_error(question)
            answer = sys.stdin.readline()
            if not answer.endswith("\n"):
                write_error("\n")  # Ctrl-D leaves the cursor after the question
        except OSError as error:
            raise KeyboardInterrupt from error
        return answer.strip()

    def _progress(self) -> str:
        done, total = self._done
        return f"{self.step} {100 * done // total} %" if total else self.step
