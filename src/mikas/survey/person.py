"""The person beside the car: what a survey asks of them, independent of terminal or screen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from mikas.i18n import Text

__all__ = ["Prompter", "Unattended"]


class Prompter(Protocol):
    """Shows instructions and asks. Every method may raise `KeyboardInterrupt`: the survey stops."""

    def say(self, text: Text, /) -> None:
        """Show an instruction or a note; return at once."""

    def progress(self, done: int, total: int, /) -> None:
        """Show how far the step under way is."""

    def ready(self, text: Text, /) -> bool:
        """Ask to do something that the unit does not show; False: it can't be done."""

    def number(self, name: str, text: Text, unit: Text, low: float, high: float, /) -> float | None:
        """Ask for a figure from `low` to `high`; None: the person has none.

        `name`: `voltmeter`, `tachometer`, `starter` (timed by hand).
        """


@dataclass(frozen=True, slots=True)
class Unattended:
    """A prompter without a person: it shows nothing, and what the unit does not show is not done.

    The car may still be started and stopped: the unit shows that itself.
    """

    figures: Mapping[str, float] = field(default_factory=dict)
    """The figures known before: `voltmeter` in V, `tachometer` in rpm, `starter` in puffs/s."""

    def say(self, *_: object) -> None:
        """Show nothing."""

    def progress(self, *_: object) -> None:
        """Show nothing."""

    def ready(self, *_: object) -> bool:
        """Return False: there is no person to do it."""
        return False

    def number(self, name: str, *_: object) -> float | None:
        """Return the figure that was given before."""
        return self.figures.get(name)
