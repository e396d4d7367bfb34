"""Stretches without values, each with its end and its reason, over one connection and the next.

A gap that a failure begins is told at once, and again when it has ended. One that somebody wanted
(another connection, another plan, a job that had the line) is told when values come again.
"""

from __future__ import annotations

from collections.abc import Callable

from mikas.dashboard import happenings
from mikas.dashboard.happenings import Happening
from mikas.i18n import Text

BY_HAND = Text("The connection was ended by hand.", "Соединение закрыто вручную.")
AGAIN = Text("The connection was made anew.", "Соединение установлено заново.")
ANOTHER = Text("Another connection was chosen.", "Выбрано другое соединение.")
DOCTOR = Text("The doctor had the port.", "Порт занимала проверка связи.")
PLAN = Text(
    "The plan was changed: the unit was asked for something else.",
    "План опроса изменён: блок спрашивали о другом.",
)
JOB = Text(
    "The line was used for another request.",
    "Линия была занята другим запросом.",
)
SILENT = Text(
    "Nothing has come for two seconds. If the unit does not answer soon: is the ignition on, is "
    "the adapter plugged in?",
    "Уже две секунды ничего не приходит. Если блок скоро не ответит: включено ли зажигание, "
    "воткнут ли адаптер?",
)

_LEAST = 1.0  # s of a pause that is worth a word
_SILENT = 2.0  # s without values that the state does not pass over


class Gaps:
    """`tell` passes them on; whoever calls holds the story's lock."""

    def __init__(self, tell: Callable[[Happening], None]) -> None:
        self._tell = tell
        self._last: float | None = None
        """Up to when all is told: the latest values, or the end of a gap behind them."""
        self._usual = 0.0  # s from the values before to the latest
        self._open: tuple[float, Text] | None = None
        self._why: Text | None = None  # of a pause that somebody wants
        self._apart = False  # it parts two connections

    def came(self, time: float) -> None:
        """Values of `time`."""
        if self._open is not None:
            self._close(time)
        elif not self._settle(time) and self._last is not None:
            self._usual = time - self._last
        self._why, self._apart, self._last = None, False, time

    def lost(self, time: float, reason: Text) -> None:
        """Nothing comes: `reason` is the first that is known of it."""
        if self._open is not None:
            return
        if self._apart and self._settle(time):
            self._last = time
        self._why, self._apart = None, False
        began = time if self._last is None else min(time, self._last)
        self._open = (began, reason)
        self._tell(happenings.gap(began, None, reason))

    def because(self, reason: Text) -> None:
        """That is why nothing comes, if nothing does."""
        if self._open is not None:
            self._open = (self._open[0], reason)

    def pause(self, why: Text) -> None:
        """Somebody wants something else of the line now."""
        if self._why is None:
            self._why = why

    def silent(self, now: float) -> Text | None:
        """Why nothing has come for some seconds, as far as is known by then; None: all is well."""
        if self._last is None or self._apart or now - self._last < _SILENT + 2 * self._usual:
            return None
        return self._open[1] if self._open is not None else self._why or SILENT

    def part(self, time: float, why: Text) -> None:
        """The connection has ended; what comes next is another one's."""
        if self._open is not None:
            self._close(time)
            self._last = time
        if not self._apart:
            self._why, self._apart = why, True

    def _settle(self, time: float) -> bool:
        """Whether a pause that was wanted ends at `time`, and was told."""
        last, why = self._last, self._why
        least = 0.0 if self._apart else max(_LEAST, 2 * self._usual)
        if why is None or last is None or time - last <= least:
            return False
        self._tell(happenings.gap(last, time, why))
        return True

    def _close(self, time: float) -> None:
        assert self._open is not None
        began, reason = self._open
        self._open = None
        self._tell(happenings.gap(began, max(began, time), reason))
