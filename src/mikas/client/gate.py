"""The gate that every change of an ECU passes (rule 7 of the architecture), and its journal.

The gate asks for confirmation, keeps the journal, and makes one change at a time. The function that
makes a change also reads back, so that the journal's outcome has the bytes read back.
"""

from __future__ import annotations

import inspect
import json
import threading
from collections.abc import Awaitable, Callable
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
    """A planned change, with all that a person needs to say yes or no.

    `before` and `after`: all bytes in hex; None: unknown. `old` and `new`: the same as values in
    words and units (`13.5 °`, `12.5 °`); None: unknown, or bytes that have no other meaning.
    `name`: of the parameter or the memory space; empty: the change has none. `address`: the first
    one, or where to jump; None: it has none. `warning`: what to know before it is made.
    """

    what: Text
    """What will be done, in words."""
    safety: Safety
    """How bad it can end."""
    command: str
    """The protocol's name of the command."""
    before: str | None = None
    after: str | None = None
    warning: Text | None = None
    name: str = ""
    address: int | None = None
    old: Text | None = None
    new: Text | None = None

    @classmethod
    def by(
        cls,
        command: Command[Any] | type[Command[Any]],
        what: Text,
        before: bytes | None = None,
        after: bytes | None = None,
        *,
        name: str = "",
        address: int | None = None,
        old: Text | None = None,
        new: Text | None = None,
        warning: Text | None = None,
    ) -> Self:
        """Return the change that `command` makes."""
        return cls(
            what,
            command.SAFETY,
            command.SOURCE_NAME,
            journal_hex(before),
            journal_hex(after),
            warning,
            name,
            address,
            old,
            new,
        )


Confirm = Callable[[Change], bool | Awaitable[bool]]
"""Returns True for yes, False for no; every other answer is a `TypeError`, and nothing is sent.

A coroutine function for an `AsyncEcu` only, which awaits it.
"""

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
            if self._confirm is not None and not _decided(self._confirm(change)):
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


def _decided(answer: object) -> bool:
    """Return the answer. Raises `TypeError` for anything but a bool.

    A text “no” and a coroutine that has not run are true; either would write.
    """
    if isinstance(answer, bool):
        return answer
    if inspect.iscoroutine(answer):
        answer.close()  # else Python complains that it was never awaited
        raise TypeError(
            "confirm is an async function, which only AsyncEcu awaits: give Ecu a function that "
            "returns True or False. Nothing was changed."
        )
    raise TypeError(
        f"confirm returned {answer!r}; it has to return True or False. Nothing was changed."
    )


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
        failed = JournalError(file=str(file), problem=reason_of(error))
        raise failed.caused_by(error, file) from error
