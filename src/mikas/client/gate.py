"""The gate that every change of an ECU passes (rule 7 of the architecture), and its journal.

The gate knows how dangerous a change is, asks for confirmation, keeps the journal, and makes one
change at a time. The function that makes a change also reads back, inside the gate: what was read
back is part of the outcome in the journal.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from mikas.commands import Safety
from mikas.errors import JournalError, MikasError, NotConfirmed, reason_of
from mikas.i18n import Text

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Change:
    """A change before it is made. `before` and `after` in hex, complete; None: not known."""

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
    """Confirms, makes and journals changes.

    `confirm` is asked for each one; without it everything but the dangerous passes, for a program
    that calls `write` has decided already. `ready` raises if this thread can make no change now: it
    is called before the wait for another thread's change, which may itself wait for this thread to
    end a stream.
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

    def make(self, change: Change, act: Callable[[], T], read_back: Callable[[T], str | None]) -> T:
        """Ask, journal, act, and journal the outcome. `read_back` gives what was read, in hex.

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
                with suppress(JournalError):  # the error on the wire is the one to raise
                    self._note(change, "failed", str(error))
                raise
            except BaseException as error:
                with suppress(JournalError):
                    self._note(change, "interrupted", type(error).__name__)
                raise
            try:
                self._note(change, "done", read_back(outcome))
            except JournalError as error:
                error.advice = _NO_OUTCOME
                raise
            return outcome

    def refuse_unasked(self, what: Text, safety: Safety) -> None:
        """Raise `NotConfirmed` for a dangerous change if there is no `confirm`.

        `make` does so too; this is for callers that first read for long what is there.
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
    """All of `data` in hex: a change is undone with what the journal has."""
    return None if data is None else data.hex(" ").upper()


class Journal:
    """A file of changes, a line of JSON each, appended and never rewritten.

    Each change is written twice: before it is made, and afterwards with its outcome. So a change
    without a known outcome (the cable pulled out, the process killed) is in the file too.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def write(self, entry: dict[str, Any]) -> None:
        """Append `entry`. Raises `JournalError`; before a change that means: it is not made."""
        line = json.dumps(entry, ensure_ascii=False) + "\n"
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            # A port's name may hold what is no Unicode; \udc80 is how JSON writes that.
            with self.path.open("a", encoding="utf-8", errors="backslashreplace") as file:
                file.write(line)
        except OSError as error:
            raise JournalError(file=str(self.path), problem=reason_of(error)) from error


def default_journal() -> Path:
    """The journal in the user's state folder."""
    from platformdirs import user_state_path

    return user_state_path("mikas", appauthor=False) / "journal.jsonl"
