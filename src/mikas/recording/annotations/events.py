"""Events as notes of a recording, and notes as events, with the recorded unit.

Notes are read from a file, so anything may be in them: a field that is missing or of another type
is None, and a note without its kind's necessary fields makes no event.

A comment on a whole recording is a note of its own kind at the end of the file; the last one
counts. A copy of the file has the comment, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import islice
from typing import Any, Final

from mikas.catalog import Catalog
from mikas.client.cars import CarDetails, car_details
from mikas.client.identity import UnitIdentity
from mikas.commands.unit import version_of
from mikas.i18n import Text
from mikas.json_values import picked
from mikas.recording.annotations.fields import (
    LONGEST_COMMENT,
    LONGEST_LINE,
    LONGEST_TEXT,
    baud_of,
    both_of,
    codes_of,
    line_of,
    number_of,
    passport_of,
    text_of,
    time_of,
)
from mikas.recording.capture.notes import Kind, Note
from mikas.sampling.events import (
    AdapterMoved,
    AlarmChanged,
    ClockChanged,
    Event,
    FaultReading,
    Gap,
    Marker,
    MethodChosen,
    ParameterDropped,
    ParameterReturned,
    PlanChanged,
    StateChanged,
    TextNote,
    UnitFound,
)

_NO_TEXT: Final = Text("", "")
_COMMENT: Final = "about"
_MOST_NAMES: Final = 300  # of a plan, or with a measured rate: a unit has 256 codes

# Events to notes


def note_of(event: Event, interpretation: str = "corrected") -> Note:
    """Return `event` as a note. `interpretation`: of values, which a plan's note keeps.

    Raises `ValueError` for an event that no recording keeps.
    """
    kind, time, data = event.kind, event.time, event.as_json()
    del data["kind"], data["time"]
    match event:
        case TextNote() | StateChanged() | AdapterMoved():
            pass
        case ClockChanged():
            data = picked(event, "seconds", "slept", "before", "after")
        case Gap():
            time = event.began
        case Marker():
            data |= {it: True for it in ("renamed", "removed") if getattr(event, it)}
        case UnitFound():
            data = {
                "version_code": data["version_code"],
                "passports": data["passport"],
                **picked(event, "adapter", "baud", "echo", "another"),
            }
        case PlanChanged(plan=plan):
            data = {
                "method": plan.method,
                "names": [wanted.parameter.name for wanted in plan.parameters],
                "every": [wanted.divisor for wanted in plan.parameters],
                "max_list": plan.max_list,
                "reading": interpretation,
            }
        case AlarmChanged():
            data |= {"channel": event.name, "better": event.better}
            keys = ("channel", "level", "before", "better", "side", "value", "limit", "text")
            data = {key: data[key] for key in keys}
        case FaultReading():
            kind, data = Kind.FAULTS_READ, {"codes": list(event.codes), "erased": event.erased}
        case MethodChosen() | ParameterDropped() | ParameterReturned():
            if not isinstance(event, MethodChosen):
                data = {kind: event.name}
            limits = {} if event.limits is None else asdict(event.limits)
            kind, data = Kind.LEARNT, limits | data
        case _:
            raise ValueError(kind)
    return Note(Kind(kind), time, data)


def catalog_note(time: float, version: str) -> Note:
    """Return the note of the catalog in use."""
    return Note(Kind.CATALOG, time, {"version": version})


def faults_note(time: float, readings: Iterable[FaultReading]) -> Note:
    """Return the note of the faults that were read before this recording, the latest last."""
    data = [{"time": it.time, "codes": list(it.codes), "erased": it.erased} for it in readings]
    return Note(Kind.FAULTS, time, {"readings": data})


def comment_note(time: float, text: str) -> Note:
    """Return the note of a comment on the whole recording; it replaces the one before."""
    return Note(_COMMENT, time, {"text": text[:LONGEST_COMMENT]})


def car_note(time: float, details: CarDetails) -> Note:
    """Return the note of the car: name, plate, mileage, workshop; it replaces the one before."""
    return Note(Kind.CAR, time, asdict(details))


# Notes to events


@dataclass(frozen=True, slots=True)
class RecordedUnit:
    """The recorded unit, its link, and the catalog; None: not in the notes.

    `passport`: 51–58, None for a piece that was not given. `method`, `names`: of the first plan.
    """

    version_code: int | None = None
    model: Text | None = None
    passport: tuple[str | None, ...] | None = None
    adapter: str = ""
    baud: int | None = None
    echo: bool | None = None
    catalog: str | None = None
    interpretation: str | None = None
    method: str | None = None
    names: tuple[str, ...] = ()

    @property
    def identity(self) -> UnitIdentity:
        """The unit, to be compared with another."""
        return UnitIdentity(self.version_code, passport_of(self.passport))


def catalogs_of(notes: Iterable[Note]) -> list[str]:
    """Return the versions of the catalogs that were in use, one after the other, ten at most."""
    named = (line_of(note.data.get("version")) for note in notes if note.kind == Kind.CATALOG)
    return list(dict.fromkeys(filter(None, named)))[:10]


def unit_of(notes: Iterable[Note], catalog: Catalog) -> RecordedUnit | None:
    """Return the unit of one recording's notes, with the pieces of its passport that a later note
    of it has; None without a note of one.
    """
    first: dict[str, Mapping[str, Any]] = {}
    identity: UnitIdentity | None = None
    for note in notes:
        first.setdefault(note.kind, note.data)
        if note.kind == Kind.UNIT:
            found = _identity(note)
            if identity is None:
                identity = found
            elif found.may_be(identity):
                identity = identity.filled_from(found)
    if identity is None:
        return None
    unit, plan = first[Kind.UNIT], first.get(Kind.PLAN, {})
    version, passport = identity
    return RecordedUnit(
        version_code=version,
        model=None if version is None else catalog.model(version).text,
        passport=(*passport.program, *passport.data) if passport else None,
        adapter=line_of(unit.get("adapter")) or "",
        baud=baud_of(unit.get("baud")),
        echo=unit["echo"] if isinstance(unit.get("echo"), bool) else None,
        catalog=line_of(first.get(Kind.CATALOG, {}).get("version")),
        interpretation=line_of(plan.get("reading")),
        method=line_of(plan.get("method")),
        names=_names(plan.get("names")),
    )


def first_unit(notes: Sequence[Note], catalog: Catalog) -> RecordedUnit | None:
    """Return the unit of the file's first recording with a note of one; else None."""
    first = next((note.recording for note in notes if note.kind == Kind.UNIT), 0)
    return unit_of((note for note in notes if note.recording == first), catalog)


def events_of(notes: Iterable[Note], catalog: Catalog) -> list[Event]:
    """Return the events of `notes`, in their order.

    A repeated unit, a plan, faults read before the recording, and a removed marker are no events.
    A renamed marker stands where the latest one of its time stands.
    """
    events: list[Event | None] = []
    before: UnitFound | None = None  # with all pieces known of its passport
    markers: dict[float, tuple[int, int]] = {}  # by time: place and recording
    for note in notes:
        event = _event(note, catalog)
        if isinstance(event, UnitFound):
            found = event = replace(event, another=_is_another(event, note, before))
            if before is not None and not found.another:
                passport = found.identity.filled_from(before.identity).passport
                before, repeated = replace(found, passport=passport), before.recording
                if repeated == found.recording:
                    continue
            else:
                before = found
        if isinstance(event, Marker):
            place, recording = markers.get(event.time, (None, 0))
            if event.removed:
                if place is not None:
                    events[place] = None
                continue
            if event.renamed and place is not None:
                events[place] = replace(event, recording=recording, renamed=False)
                continue
            markers[event.time] = len(events), event.recording
        events.append(event)
    return [event for event in events if event is not None]


def _is_another(found: UnitFound, note: Note, before: UnitFound | None) -> bool:
    """Return what sampling has decided; older files, and one recording after another, lack it."""
    if before is None:
        return False
    decided = note.data.get("another")
    if isinstance(decided, bool) and found.recording == before.recording:
        return decided
    return not found.identity.may_be(before.identity)


def had_marker(notes: Iterable[Note], time: float) -> bool:
    """Return whether a marker was set at exactly `time`; also one that was removed since."""
    return any(
        note.kind == Kind.MARKER and note.time == time and note.data.get("removed") is not True
        for note in notes
    )


def comment_of(notes: Iterable[Note]) -> str:
    """Return the last comment; empty without one."""
    texts = [
        text_of(note.data.get("text"), LONGEST_COMMENT) for note in notes if note.kind == _COMMENT
    ]
    return next((text for text in reversed(texts) if text is not None), "")


def car_of(notes: Iterable[Note]) -> CarDetails:
    """Return the details in the last note of a car; empty ones without such a note."""
    found = CarDetails()
    for note in notes:
        if note.kind == Kind.CAR:
            found = car_details(note.data)
    return found


def recorded_faults(notes: Iterable[Note]) -> Iterator[FaultReading]:
    """Yield the readings of faults before the recording, of the same unit by the same program."""
    for note in notes:
        if note.kind == Kind.FAULTS and isinstance(data := note.data.get("readings"), list):
            yield from filter(None, map(_fault_reading, data))


def _identity(note: Note) -> UnitIdentity:
    data = note.data
    return UnitIdentity(version_of(data.get("version_code")), passport_of(data.get("passports")))


def _event(note: Note, catalog: Catalog) -> Event | None:
    time, data, recording = note.time, note.data, note.recording
    match note.kind:
        case Kind.MARKER:
            renamed, removed = data.get("renamed") is True, data.get("removed") is True
            label = line_of(data.get("label")) or ""
            return Marker(time, label, renamed=renamed, removed=removed, recording=recording)
        case Kind.NOTE if (words := text_of(data.get("text"), LONGEST_TEXT)) is not None:
            return TextNote(time, words, recording=recording)
        case Kind.GAP:
            began, ended = gap_of(note)
            return Gap(time, began, ended, both_of(data.get("reason")), recording=recording)
        case Kind.STATE if (state := line_of(data.get("state"))) is not None:
            text, reason = both_of(data.get("text")) or _NO_TEXT, both_of(data.get("reason"))
            return StateChanged(time, state, text=text, reason=reason, recording=recording)
        case Kind.ADAPTER | Kind.CLOCK:
            return _of_the_computer(note)
        case Kind.ALARM if (name := line_of(data.get("channel"))) is not None:
            return AlarmChanged(
                time,
                name,
                line_of(data.get("level")) or "",
                line_of(data.get("before")),
                line_of(data.get("side")),
                number_of(data.get("value")),
                number_of(data.get("limit")),
                both_of(data.get("text")) or _NO_TEXT,
                data.get("better") is True,
                recording=recording,
            )
        case Kind.LEARNT if (name := line_of(data.get("dropped"))) is not None:
            return ParameterDropped(time, name, recording=recording)
        case Kind.LEARNT if (name := line_of(data.get("returned"))) is not None:
            return ParameterReturned(time, name, recording=recording)
        case Kind.LEARNT if (method := line_of(data.get("method"))) is not None:
            rates = data.get("rates")
            items = islice(rates.items(), _MOST_NAMES) if isinstance(rates, dict) else ()
            known = {
                key[:LONGEST_LINE]: rate
                for key, value in items
                if (rate := number_of(value)) is not None
            }
            return MethodChosen(time, method, known, recording=recording)
        case Kind.FAULTS_READ if (codes := codes_of(data.get("codes"))) is not None:
            return FaultReading(time, codes, data.get("erased") is True, recording=recording)
        case Kind.UNIT:
            version, passport = _identity(note)
            model = None if version is None else catalog.model(version).text
            return UnitFound(time, version, passport, model=model, recording=recording)
    return None


def _of_the_computer(note: Note) -> AdapterMoved | ClockChanged | None:
    """Return the event of an adapter's or a clock's note."""
    time, data, recording = note.time, note.data, note.recording
    if note.kind == Kind.ADAPTER:
        if (port := line_of(data.get("port"))) is None:
            return None
        return AdapterMoved(time, port, line_of(data.get("before")) or "", recording=recording)
    seconds, before, after = (
        time_of(data.get(key)) for key in ("seconds", "before", "after")
    )  # a length beyond the calendar is none
    if seconds is None:
        return None
    slept = data.get("slept") is True
    return ClockChanged(time, seconds, slept, before or 0.0, after or 0.0, recording=recording)


def gap_of(note: Note) -> tuple[float, float | None]:
    """Return the begin and the end of a note on a gap; None: it has no end."""
    began, ended = time_of(note.data.get("began")), time_of(note.data.get("ended"))
    return note.time if began is None else began, ended


def _names(value: object) -> tuple[str, ...]:
    names = map(line_of, value[:_MOST_NAMES]) if isinstance(value, list) else ()
    return tuple(name for name in names if name is not None)


def _fault_reading(data: object) -> FaultReading | None:
    if not isinstance(data, dict):
        return None
    time, codes = time_of(data.get("time")), codes_of(data.get("codes"))
    if time is None or codes is None:
        return None
    return FaultReading(time, codes, data.get("erased") is True)
