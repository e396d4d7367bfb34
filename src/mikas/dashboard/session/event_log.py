"""The events that the page gets and the history keeps: sampling's, and the dashboard's own two."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from heapq import merge
from typing import Any, Final, Self

from mikas.dashboard.errors import ADVICE, api_hex
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.sampling.events import Event, Gap, Marker, MethodChosen, StateChanged
from mikas.tester import Failure

_MAX_EVENTS: Final = 5000  # of errors, and of all others


@dataclass(frozen=True, slots=True)
class ExchangeFailed(Event):
    """An exchange failed; it may have been repeated with success."""

    kind = "error"
    code: str
    text: Text
    sent: str | None
    received: str | None

    @classmethod
    def of(cls, time: float, cause: MikasError | Failure) -> Self:
        """Return the event of the error that ended a cycle, or of a failure that was counted."""
        if isinstance(cause, Failure):
            code, text = cause.code, cause.reason
        else:
            code, text = type(cause).__name__, ADVICE.text(cause)
        return cls(time, code, text, api_hex(cause.request), api_hex(cause.received))


@dataclass(frozen=True, slots=True)
class RecordingChanged(Event):
    """A recording to `file` began (`on`), ended, or broke off with a `failure`."""

    kind = "recording"
    file: str
    on: bool
    failure: Text | None = None


class EventLog:
    """The latest events. Errors have a queue of their own: a bad line has thousands, which must not
    displace markers, gaps and units.
    """

    def __init__(self) -> None:
        self._count = 0
        self._errors: deque[tuple[int, Event]] = deque(maxlen=_MAX_EVENTS)
        self._others: deque[tuple[int, Event]] = deque(maxlen=_MAX_EVENTS)

    def add(self, event: Event) -> None:
        """Keep `event`; a marker at the time of a kept one is that marker, renamed or removed."""
        if isinstance(event, Marker):
            for place, (count, before) in enumerate(self._others):
                if isinstance(before, Marker) and before.time == event.time:
                    self._others[place] = count, event
                    return
        kept = self._errors if isinstance(event, ExchangeFailed) else self._others
        kept.append((self._count, event))
        self._count += 1

    @property
    def all(self) -> list[Event]:
        """All kept events, in their order."""
        return [event for _, event in merge(self._errors, self._others, key=lambda it: it[0])]


def reason_of(event: StateChanged | Gap) -> Text | None:
    """Return the reason with advice, if it is an error's."""
    return ADVICE.text(event.error) if event.error else event.reason


def page_json(event: Event) -> dict[str, Any]:
    """Return `event` for the page: with advice, a state's class of error, and rounded rates."""
    shown = event.as_json()
    if isinstance(event, StateChanged | Gap) and (reason := reason_of(event)):
        shown["reason"] = reason._asdict()
    if isinstance(event, StateChanged):
        shown["code"] = type(event.error).__name__ if event.error else None
    elif isinstance(event, MethodChosen):
        shown["rates"] = {name: round(rate, 2) for name, rate in event.rates.items()}
    elif isinstance(event, Marker) and event.removed:
        shown["removed"] = True
    return shown
