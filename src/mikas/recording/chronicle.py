"""What the sampler tells, as notes; and what a recording that begins in mid-session has to know.

    events ──► Chronicle.take ──► notes       unit, catalog, plan, state, gap, alarm, learnt
                   └── Chronicle.head()       the first four once more, for a new file

A gap is one note, however many cycles were lost in it: from the last sample before it to the first
one behind, with the reason that says most. It is written when it ends; a recording that ends first
gets it with an open end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.recording.notes import (
    Note,
    alarm_note,
    catalog_note,
    gap_note,
    learnt_note,
    plan_note,
    state_note,
    unit_note,
)
from mikas.sampling.alarms import AlarmChanged
from mikas.sampling.events import (
    CycleFailed,
    Event,
    LineState,
    MethodChosen,
    ParameterDropped,
    PlanChanged,
    Sampled,
    StateChanged,
    UnitFound,
)

if TYPE_CHECKING:
    from mikas.client import Ecu, Limits

_BROKEN = (LineState.NO_PORT, LineState.NO_ECHO, LineState.ECHO_ONLY)


@dataclass(slots=True)
class _Hole:
    """A gap that has not ended."""

    began: float
    reason: Text
    state: LineState | None  # the one that the reason is from; None: a cycle that failed


class Chronicle:
    """Follows one session. `ecu`: the unit of now, if there is one, to be asked what it is."""

    def __init__(self, ecu: Callable[[], Ecu | None], interpretation: str = "corrected") -> None:
        self._ecu = ecu
        self._interpretation = interpretation
        self._unit: Sequence[Note] = ()  # and the catalog's
        self._plan: Note | None = None
        self._state: Note | None = None
        self._sampling = False
        self._hole: _Hole | None = None
        self._sampled: float | None = None  # when the last sample came
        self.samples = 0
        self.gaps = 0

    def head(self, time: float) -> Iterator[Note]:
        """What a new recording begins with, as of `time`; counting begins anew."""
        self.samples = self.gaps = 0
        self._sampled = None
        if self._hole is not None:
            self._hole.began = time
            self.gaps = 1
        for note in (*self._unit, self._plan, self._state):
            if note is not None:
                yield replace(note, time=time)

    def end(self, ended: float | None = None) -> Iterator[Note]:
        """What is still to be said when a recording ends: a gap."""
        if self._hole is not None:
            yield gap_note(self._hole.began, ended, self._hole.reason)

    def take(self, event: Event) -> Iterator[Note]:
        """The notes that `event` makes; none for most."""
        match event:
            case Sampled():
                yield from self._came(event)
            case CycleFailed():
                self._lost(event.time, event.error.reason)
            case StateChanged():
                yield self._changed(event)
            case UnitFound():
                yield from self._found(event)
            case PlanChanged():
                self._plan = plan_note(event.time, event.plan, self._interpretation)
                yield self._plan
            case AlarmChanged():
                yield alarm_note(event)
            case MethodChosen():
                yield learnt_note(
                    event.time, self._limits(), method=event.method, rates=event.rates
                )
            case ParameterDropped():
                yield learnt_note(event.time, self._limits(), dropped=event.name)

    def _came(self, event: Sampled) -> Iterator[Note]:
        yield from self.end(event.time)
        self._hole = None
        self._sampled = event.time
        self.samples += 1

    def _lost(self, time: float, reason: Text, state: LineState | None = None) -> None:
        if self._hole is None:
            began = time if self._sampled is None else min(time, self._sampled)
            self._hole = _Hole(began, reason, state)
            self.gaps += 1
        elif state not in (None, self._hole.state):  # it tells more than a request that failed
            self._hole.reason, self._hole.state = reason, state

    def _changed(self, event: StateChanged) -> Note:
        reason = event.error.reason if event.error else None
        self._state = state_note(event.time, event.state, reason)
        if event.state in _BROKEN and (self._sampling or self._hole):
            self._lost(event.time, reason or event.state.text, event.state)
        self._sampling = event.state is LineState.SAMPLING
        return self._state

    def _limits(self) -> Limits | None:
        ecu = self._ecu()
        with suppress(MikasError):  # of a unit that is going away just now
            return ecu.limits() if ecu else None
        return None

    def _found(self, event: UnitFound) -> Iterator[Note]:
        if event.another:
            self._plan = None
        ecu = self._ecu()
        link = ecu.tester.link if ecu else None
        passport = event.passport
        unit = unit_note(
            event.time,
            version_code=event.version_code,
            passports=(*passport.program, *passport.data),
            adapter=link.description if link else "",
            baud=link.baud if link else 9600,
            echo=ecu.tester.echoes if ecu else None,
        )
        notes = [unit]
        if ecu is not None:
            notes.append(catalog_note(event.time, ecu.catalog.version))
        if [note.data for note in notes] != [note.data for note in self._unit]:
            self._unit = notes
            yield from notes
