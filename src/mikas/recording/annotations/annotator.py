"""A session's events as notes, and the first notes of a recording that begins in mid-session.

    events ──► SessionAnnotator.notes_of ──► notes  unit, catalog, plan, state, gap, alarm, learnt
                   └── head()                       the first four repeated, for a new file

A gap is one note, however many cycles failed in it (`sampling/gaps.py`), written when the gap ends.
A recording that ends first gets the note with an open end; in one that begins in a gap, the gap
begins with the recording.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import inf

from mikas.i18n import Text
from mikas.recording.annotations.events import catalog_note, note_of
from mikas.recording.capture.notes import Note
from mikas.sampling import events


class SessionAnnotator:
    """Follows one session. `interpretation`: of values, for the plan's note. `car`: gives the note
    on the car of a unit that was found, None without one.
    """

    def __init__(
        self,
        interpretation: str = "corrected",
        car: Callable[[events.UnitFound], Note | None] | None = None,
    ) -> None:
        self._interpretation = interpretation
        self._unit: Sequence[Note] = ()  # with the catalog's note
        self._car_of = car or (lambda _: None)
        self._car: Note | None = None
        self._plan: Note | None = None
        self._state: Note | None = None
        self._faults: tuple[int, ...] | None = None  # as noted last in this recording
        self._began = -inf  # of this recording
        self._values: float | None = None  # the latest in it
        self._gap: events.Gap | None = None  # the present one
        self.samples: int = 0
        self.gaps: int = 0

    def head(self, time: float) -> Iterator[Note]:
        """Yield the first notes of a new recording, as of `time`; restart counting."""
        self._began, self._values = time, None
        self.samples, self.gaps = 0, int(self._gap is not None)
        self._faults = None
        for note in (*self._unit, self._car, self._plan, self._state):
            if note is not None:
                yield replace(note, time=time)

    def describe(self, car: Note) -> Iterator[Note]:
        """Yield the note on the car, which replaces the one before."""
        self._car = car
        yield car

    def last_notes(self, ended: float | None = None) -> Iterator[Note]:
        """Yield the note of the gap in which a recording ends."""
        if self._gap is not None:
            yield self._noted(replace(self._gap, ended=ended))

    def notes_of(self, event: events.Event) -> Iterator[Note]:
        """Yield the notes of `event`. Exhaust the iterator: it updates the annotator's state."""
        match event:
            case events.Sampled():
                self.samples += 1
                self._values = event.time
            case events.CycleFailed():
                pass
            case events.Gap():
                yield from self._gap_changed(event)
            case events.UnitFound():
                yield from self._found(event)
            case events.PlanChanged():
                yield from self._decoded_by(event)
                self._plan = note_of(event, self._interpretation)
                yield self._plan
            case events.StateChanged():
                self._state = note_of(event)
                yield self._state
            case events.FaultReading(codes=codes, routine=True) if codes == self._faults:
                pass
            case events.FaultReading(codes=codes):
                self._faults = codes
                yield note_of(event)
            case _:
                yield note_of(event)

    def interrupt(self, time: float, reason: Text) -> None:
        """Begin a gap: the connection is left for a while, for `reason`."""
        if self._gap is None:
            began = time if self._values is None else self._values
            self._gap = events.Gap(time, began, None, reason)
            self.gaps += 1

    def _gap_changed(self, gap: events.Gap) -> Iterator[Note]:
        if self._gap is None and gap.began < self._began and gap.ended is not None:
            return  # a pause from before this recording
        self.gaps += self._gap is None
        self._gap = gap if gap.ended is None else None
        if gap.ended is not None:
            yield self._noted(gap)

    def _noted(self, gap: events.Gap) -> Note:
        return note_of(replace(gap, began=max(gap.began, self._began)))

    def _decoded_by(self, event: events.PlanChanged) -> Iterator[Note]:
        """Yield the note of another catalog: the user changed it in mid-session."""
        note = catalog_note(event.time, event.catalog)
        if self._unit and event.catalog and note.data != self._unit[-1].data:
            self._unit = [*self._unit[:-1], note]
            yield note

    def _found(self, event: events.UnitFound) -> Iterator[Note]:
        if event.another:
            self._plan = None
        catalog = catalog_note(event.time, event.catalog)
        head = [note_of(replace(event, another=False)), catalog]  # a recording's first unit
        if event.another or [note.data for note in head] != [note.data for note in self._unit]:
            self._unit = head
            yield from (note_of(event), catalog)
            if event.another or self._car is None:
                self._car = self._car_of(event)
                if self._car is not None:
                    yield self._car
