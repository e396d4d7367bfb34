"""The gate that every change of an ECU passes (rule 7 of the architecture), and its journal.

The gate asks for confirmation, keeps the journal, and makes one change at a time. The function that
makes a change also reads back, so that the journal's outcome has the bytes read back.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self, TypeVar

from mikas import unkept
from mikas.commands import Command, Safety
from mikas.errors import JournalError, LinkLost, MikasError, NotConfirmed, reason_of
from mikas.i18n import Text
from mikas.saving import append_line
from mikas.tester import Tester

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Change:
    """A planned change. `before` and `after`: all bytes in hex; None: unknown.

    `warning`: what to know before it is made; shown where it is confirmed.
    """

    what: Text
    safety: Safety
    command: str
    before: str | None = None
    after: str | None = None
    warning: Text | None = None

    @classmethod
    def by(
        cls,
        command: Command[Any] | type[Command[Any]],
        what: Text,
        before: bytes | None = None,
        after: bytes | None = None,
    ) -> Self:
        """Return the change that `command` makes."""
        texts = journal_hex(before), journal_hex(after)
        return cls(what, command.SAFETY, command.SOURCE_NAME, *texts)


Confirm = Callable[[Change], bool]

_NO_CONFIRM = Text(
    "This can leave the unit unable to run. Give connect() a confirm function that says yes.",
    "После этого блок может перестать работать. Передайте connect() функцию confirm, которая "
    "возвращает True.",
)
_DECLINED = Text("The answer to the question was no.", "На вопрос ответили «нет».")
_UNSETTLED = Text(
    f"{LinkLost.advice.en} Whether the change was made is unknown: with the adapter back, read "
    "what the unit holds.",
    f"{LinkLost.advice.ru} Сделано ли изменение, неизвестно: когда адаптер вернётся, прочитайте, "
    "что теперь в блоке.",
)
_NO_OUTCOME = Text(
    "The change was made; the journal has its beginning, but not its outcome.",
    "Изменение сделано; в журнале есть его начало, но нет исхода.",
)
_END_UNKEPT = Text(
    "The journal {place} can't be written ({why}): it has the beginning of a change, but not how "
    "it failed.",
    "Журнал {place} не записывается ({why}): в нём есть начало изменения, но нет того, чем оно "
    "закончилось.",
)


@dataclass(slots=True, eq=False)
class Gate:
    """Confirms, makes and journals changes.

    Without `confirm` all but dangerous changes pass: a program that calls `write` has decided
    already. `whose` returns the journal's description of the unit.
    """

    _tester: Tester
    _whose: Callable[[], dict[str, object]]
    _confirm: Confirm | None
    _journal: Path | None
    _one_at_a_time: threading.RLock = field(init=False, default_factory=threading.RLock)

    def make(
        self,
        change: Change,
        act: Callable[[], T],
        read_back: Callable[[T], bytes | None],
        commands: Callable[[], str] | None = None,
        *,
        approved: bool = False,
    ) -> T:
        """Confirm, journal, act, and journal the outcome with the bytes of `read_back`.

        `approved`: the change is a part of one that `ask` has confirmed.
        `commands`: returns the commands that `act` has used, if they may not be `change.command`.
        Raises `NotConfirmed` or `JournalError` before the change, the errors of `act`, or a
        `JournalError` after the change, which says so.
        """
        # First: another thread's change may wait for the end of a stream of this thread.
        self._tester.check_free()
        with self._one_at_a_time:
            if not approved:
                self.ask(change)
            self._note(change, "started", None)

            def used() -> Change:
                names = commands() if commands else ""
                return replace(change, command=names) if names else change

            try:
                outcome = act()
            except MikasError as error:
                self._note_end(used(), "failed", str(error))
                if isinstance(error, LinkLost) and error.advice == LinkLost.advice:
                    error.advice = _UNSETTLED
                raise
            except BaseException as error:
                self._note_end(used(), "interrupted", type(error).__name__)
                raise
            try:
                self._note(used(), "done", journal_hex(read_back(outcome)))
            except JournalError as error:
                error.advice = _NO_OUTCOME
                raise
            return outcome

    @property
    def asks(self) -> bool:
        """Whether changes are confirmed."""
        return self._confirm is not None

    def ask(self, change: Change) -> None:
        """Confirm a change, which may be made in parts, each `approved`. Raises `NotConfirmed`."""
        self._tester.check_free()
        with self._one_at_a_time:
            self.refuse_unasked(change.what, change.safety)
            if self._confirm is not None and not self._confirm(change):
                raise NotConfirmed(change=change.what, how=_DECLINED)

    def refuse_unasked(self, what: Text, safety: Safety) -> None:
        """Raise `NotConfirmed` for a dangerous change without `confirm`, as `make` does.

        For callers that first have to read for a long time.
        """
        if self._confirm is None and safety >= Safety.DANGEROUS:
            raise NotConfirmed(change=what, how=_NO_CONFIRM)

    def _note_end(self, change: Change, state: str, outcome: str) -> None:
        """Journal the error that ends a change, which matters more than one of the journal."""
        if self._journal is not None:
            with unkept.saying_once(_END_UNKEPT, self._journal):
                self._note(change, state, outcome)

    def _note(self, change: Change, state: str, outcome: str | None) -> None:
        if self._journal is None:
            return
        entry = {
            "time": self._tester.link.date(),
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
        add_to_journal(self._journal, entry)


def journal_hex(data: bytes | None) -> str | None:
    """Return all of `data` in hex, for undoing a change from the journal."""
    return None if data is None else data.hex(" ").upper()


def add_to_journal(file: Path, entry: dict[str, Any]) -> None:
    """Append `entry` to the journal, one line of JSON. Raises `JournalError`.

    A change is on the disk before it is made, and again with its outcome. So the file also has
    changes with an unknown outcome (cable unplugged, process killed, power failed). A change
    without an entry is not made.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        # A port's name may contain bytes that are no Unicode; JSON has \udc80 for them.
        append_line(file, json.dumps(entry, ensure_ascii=False))
    except OSError as error:
        raise JournalError(file=str(file), problem=reason_of(error)) from error
