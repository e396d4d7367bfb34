"""The one gate that every change of an ECU goes through (rule 7 of the house).

It knows how dangerous a change is, asks whoever was put in charge, keeps the journal, and lets
changes through one at a time. Reading back is done by whoever makes the change, inside the gate:
what was read back is part of the outcome that the journal keeps.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from mikas.client.journal import Journal
from mikas.commands import Safety
from mikas.errors import MikasError, NotConfirmed, in_hex
from mikas.language import Text

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Change:
    """What is about to be done. `before` and `after` in hex; None: not known."""

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
_SAID_NO = Text("Nothing was sent.", "Ничего не послано.")


class Gate:
    """Lets changes through.

    `confirm` is asked for each one; without it everything but the dangerous passes, for a program
    that calls `write` has decided already.
    """

    def __init__(
        self,
        *,
        confirm: Confirm | None,
        journal: Journal | None,
        clock: Callable[[], float],
        whose: Callable[[], dict[str, object]],
    ) -> None:
        self._confirm = confirm
        self._journal = journal
        self._clock = clock
        self._whose = whose
        self._one_at_a_time = threading.RLock()

    def make(self, change: Change, act: Callable[[], T], told: Callable[[T], str | None]) -> T:
        """Asks, journals, acts, journals the outcome. `told` gives what was read back, in hex.

        Raises `NotConfirmed` or `JournalError` before anything was sent, or what `act` raises.
        """
        with self._one_at_a_time:
            self._ask(change)
            self._note(change, "started", None)
            try:
                outcome = act()
            except MikasError as error:
                self._note(change, "failed", str(error))
                raise
            except BaseException as error:
                self._note(change, "interrupted", type(error).__name__)
                raise
            self._note(change, "done", told(outcome))
            return outcome

    def _ask(self, change: Change) -> None:
        if self._confirm is None:
            if change.safety >= Safety.DANGEROUS:
                raise NotConfirmed(change=change.what, how=_NOBODY_ASKED)
        elif not self._confirm(change):
            raise NotConfirmed(change=change.what, how=_SAID_NO)

    def _note(self, change: Change, state: str, outcome: str | None) -> None:
        if self._journal is None:
            return
        self._journal.write(
            {
                "time": self._clock(),
                **self._whose(),
                "change": change.what.en,
                "command": change.command,
                "safety": change.safety.name.lower(),
                "before": change.before,
                "after": change.after,
                "state": state,
                "outcome": outcome,
            }
        )


def hexed(data: bytes | None) -> str | None:
    """Bytes as the journal and a question show them."""
    return None if data is None else in_hex(data)
