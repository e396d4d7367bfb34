"""What happened, as the JSON that the page gets and the history keeps."""

from __future__ import annotations

from collections import deque
from heapq import merge
from typing import Any

from mikas.dashboard.advice import ADVICE
from mikas.dashboard.api.errors import body_of, in_hex
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.sampling.alarms import AlarmChanged
from mikas.sampling.events import MethodChosen, ParameterDropped, StateChanged, UnitFound
from mikas.tester.statistics import Failure

Happening = dict[str, Any]

_MOST = 5000  # kept for those who come later; as many errors besides


class Kept:
    """The latest happenings. Errors have a place of their own: a bad line has thousands, which
    must not push out markers, gaps and units.
    """

    def __init__(self) -> None:
        self._count = 0
        self._errors: deque[tuple[int, Happening]] = deque(maxlen=_MOST)
        self._others: deque[tuple[int, Happening]] = deque(maxlen=_MOST)

    def add(self, it: Happening) -> None:
        """One more."""
        kept = self._errors if it["kind"] == "error" else self._others
        kept.append((self._count, it))
        self._count += 1

    @property
    def all(self) -> list[Happening]:
        """In the order in which they came."""
        return [it for _, it in merge(self._errors, self._others)]


def both(text: Text | None) -> dict[str, str] | None:
    """`text` for JSON; an empty one is none."""
    return None if text is None or not text.en else {"en": text.en, "ru": text.ru}


def state(event: StateChanged) -> Happening:
    """The line's state is another one."""
    return {
        "kind": "state",
        "time": event.time,
        "state": event.state.value,
        "text": both(event.state.text),
        "reason": both(ADVICE.text(event.error)) if event.error else None,
        "code": type(event.error).__name__ if event.error else None,
    }


def gap(began: float, ended: float | None, reason: Text) -> Happening:
    """Nothing came; told when it begins (`ended` null), and once more when it has ended."""
    return {
        "kind": "gap",
        "time": began if ended is None else ended,
        "began": began,
        "ended": ended,
        "reason": both(reason),
    }


def error(time: float, it: MikasError) -> Happening:
    """An exchange was spoilt."""
    told = body_of(it)
    return {
        "kind": "error",
        "time": time,
        "code": told["code"],
        "text": {"en": told["en"], "ru": told["ru"]},
        "sent": told["sent"],
        "received": told["received"],
    }


def failure(it: Failure, now: float) -> Happening:
    """An exchange was spoilt, and maybe repeated with success."""
    return {
        "kind": "error",
        "time": now if it.time is None else it.time,
        "code": it.code,
        "text": both(it.reason),
        "sent": in_hex(it.request),
        "received": in_hex(it.received),
    }


def alarm(event: AlarmChanged) -> Happening:
    """A limit was crossed, either way."""
    return {
        "kind": "alarm",
        "time": event.time,
        "name": event.channel.name,
        "level": event.level.value,
        "before": event.before.value,
        "side": event.side.value,
        "value": event.value,
        "limit": event.limit,
        "text": both(event.text),
    }


def method(event: MethodChosen) -> Happening:
    """Another method is in use."""
    rates = {name: round(rate, 2) for name, rate in event.rates.items()}
    return {"kind": "method", "time": event.time, "method": event.method, "rates": rates}


def dropped(event: ParameterDropped) -> Happening:
    """A parameter that the unit refuses."""
    return {"kind": "dropped", "time": event.time, "name": event.name}


def unit(event: UnitFound, model: Text) -> Happening:
    """A unit answers."""
    return {
        "kind": "unit",
        "time": event.time,
        "model": both(model),
        "version_code": event.version_code,
        "passport": passport(event),
        "another": event.another,
    }


def passport(event: UnitFound) -> list[str | None]:
    """The three of the program and the five of the data."""
    return [*event.passport.program, *event.passport.data]


def marker(time: float, label: str) -> Happening:
    """A moment that somebody marked."""
    return {"kind": "marker", "time": time, "label": label}


def recording(time: float, file: str, *, on: bool, failure: MikasError | None = None) -> Happening:
    """A recording began, ended or broke off."""
    return {
        "kind": "recording",
        "time": time,
        "file": file,
        "on": on,
        "failure": both(ADVICE.text(failure)) if failure else None,
    }
