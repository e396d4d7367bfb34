"""The one gate that every change of an ECU goes through (rule 7 of the house).

It knows how dangerous a change is, asks whoever was put in charge, keeps the journal, and lets
changes through one at a time. Reading back is done by whoever makes the change, inside the gate:
what was read back is part of the outcome that the journal keeps.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeVar

from mikas.client.journal import Journal
from mikas.commands import Safety
from mikas.errors import JournalError, MikasError, NotConfirmed
from mikas.i18n import Text

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Change:
    """What is about to be done. `before` and `after` in hex, complete; None: not known."""

    what: Text
    safety: Safety
    command: str
    before: str | None = None
    after: str | None = None


Confirm = Callable[[Change], bool]

_NOBODY_ASKED = Text(
    "This can leave the unit unable to run. Give connect() a confirm function that says yes.",
    "После этого блок может перестать работать. Передайте connect() функцию confirm, "
    "которая скажет да.",
)
_SAID_NO = Text("The answer to the question was no.", "На вопрос ответили «нет».")
_NO_OUTCOME = Text(
    "The change was made; the journal has its beginning, but not its outcome.",
    "Изменение сделано; в журнале есть его начало, но нет исхода.",
)


class Gate:
    """Lets changes through.

    `confirm` is asked for each one; without it everything but the dangerous passes, for a program
    that calls `write` has decided already. `ready` raises if this is no time for a change: before
    waiting for another thread's, which may be waiting for this one to end a stream.
    """

    def __init__(
        self,
        *,
        confirm: Confirm | None,
        journal: Journal | None,
        clock: Callable[[], float],
        whose: Callable[[], dict[str, object]],
        ready: Callable[[], None] = lambda: None,
    ) -> None:
        self._confirm = confirm
        self._journal = journal
        self._clock = clock
        self._whose = whose
        self._ready = ready
        self._one_at_a_time = threading.RLock()

    def make(self, change: Change, act: Callable[[], T], told: Callable[[T], str | None]) -> T:
        """Asks, journals, acts, journals the outcome. `told` gives what was read back, in hex.

        Raises `NotConfirmed` or `JournalError` before anything was changed, or what `act` raises; a
        `JournalError` after it says that the change was made.
        """
        self._ready()
        with self._one_at_a_time:
            self._ask(change)
            self._note(change, "started", None)
            try:
                outcome = act()
            except MikasError as error:
                with suppress(JournalError):  # what went wrong on the wire is what is told
                    self._note(change, "failed", str(error))
                raise
            except BaseException as error:
                with suppress(JournalError):
                    self._note(change, "interrupted", type(error).__name__)
                raise
            try:
                self._note(change, "done", told(outcome))
            except JournalError as error:
                error.advice = _NO_OUTCOME
                raise
            return outcome

    def refuse_unasked(self, what: Text, safety: Safety) -> None:
        """Raises `NotConfirmed` for a dangerous change if there is nobody to ask.

        `make` does so too; this is for those who first read at length what is there.
        """
        if self._confirm is None and safety >= Safety.DANGEROUS:
            raise NotConfirmed(change=what, how=_NOBODY_ASKED)

    def _ask(self, change: Change) -> None:
        self.refuse_unasked(change.what, change.safety)
        if self._confirm is not None and not self._confirm(change):
            raise NotConfirmed(change=change.what, how=_SAID_NO)

    def _note(self, change: Change, state: str, outcome: str | None) -> None:
        if self._journal is None:
            return
        self._journal.write(
            {
                "time": self._clock(),
                **self._whose(),
                "change": change.what.en,
                "change_ru": change.what.ru,
                "command": change.command,
                "safety": change.safety.name.lower(),
                "before": change.before,
                "after": change.after,
                "state": state,
                "outcome": outcome,
            }
        )


def hex_or_none(data: bytes | None) -> str | None:
    """All of `data`: what the journal keeps is what a change can be undone with."""
    return None if data is None else data.hex(" ").upper()
