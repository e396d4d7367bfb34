"""Events as notes of a recording, and notes as events, with the recorded unit.

Notes are read from a file, so anything may be in them: a field that is missing or of another type
is None, and a note without its kind's necessary fields makes no event.

A comment on a whole recording is a note of its own kind at the end of the file; the last one
counts. A copy of the file has the comment, too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from math import isfinite
from typing import Any, Final

from mikas.catalog import Catalog
from mikas.client import Passport
from mikas.commands.unit import version_of
from mikas.i18n import Text
from mikas.recording.capture.notes import Kind, Note
from mikas.sampling.events import (
    AdapterMoved,
    AlarmChanged,
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
_PROGRAM_PIECES: Final = 3  # of a passport; the others are the data's
_COMMENT: Final = "about"
LONGEST_COMMENT: Final = 10_000

# Events to notes


def note_of(event: Event, interpretation: str = "corrected") -> Note:
    """Return `event` as a note. `interpretation`: of values, which a plan's note keeps.

    Raises `ValueError` for an event that no recording keeps.
    """
    data = event.as_json()
    del data["kind"], data["time"]
    match event:
        case TextNote() | Marker() | Gap() | StateChanged() | AdapterMoved():
            time = event.began if isinstance(event, Gap) else event.time
            return Note(Kind(event.kind), time, data)
        case UnitFound():
            data = {
                "version_code": data["version_code"],
                "passports": data["passport"],
                "adapter": event.adapter,
                "baud": event.baud,
                "echo": event.echo,
            }
            return Note(Kind.UNIT, event.time, data)
        case PlanChanged(plan=plan):
            data = {
                "method": plan.method,
                "names": [wanted.parameter.name for wanted in plan.parameters],
                "every": [wanted.divisor for wanted in plan.parameters],
                "max_list": plan.max_list,
                "reading": interpretation,
            }
            return Note(Kind.PLAN, event.time, data)
        case AlarmChanged():
            keys = ("level", "before", "better", "side", "value", "limit", "text")
            data["better"] = event.better
            form = {"channel": event.name} | {key: data[key] for key in keys}
            return Note(Kind.ALARM, event.time, form)
        case MethodChosen() | ParameterDropped() | ParameterReturned():
            limits = {} if event.limits is None else asdict(event.limits)
            if isinstance(event, ParameterDropped):
                data = {"dropped": event.name}
            elif isinstance(event, ParameterReturned):
                data = {"returned": event.name}
            return Note(Kind.LEARNT, event.time, limits | data)
    raise ValueError(event.kind)


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


def unit_of(notes: Iterable[Note], catalog: Catalog) -> RecordedUnit | None:
    """Return the unit of one recording's notes; None without a note of one."""
    first: dict[str, Mapping[str, Any]] = {}
    for note in notes:
        first.setdefault(note.kind, note.data)
    if Kind.UNIT not in first:
        return None
    unit, plan = first[Kind.UNIT], first.get(Kind.PLAN, {})
    version, passport = version_of(unit.get("version_code")), _passport(unit.get("passports"))
    names = plan.get("names")
    return RecordedUnit(
        version_code=version,
        model=None if version is None else catalog.model(version).text,
        passport=(*passport.program, *passport.data) if passport else None,
        adapter=_word(unit.get("adapter")) or "",
        baud=_whole(unit.get("baud")),
        echo=unit["echo"] if isinstance(unit.get("echo"), bool) else None,
        catalog=_word(first.get(Kind.CATALOG, {}).get("version")),
        interpretation=_word(plan.get("reading")),
        method=_word(plan.get("method")),
        names=tuple(map(str, names)) if isinstance(names, list) else (),
    )


def events_of(notes: Iterable[Note], catalog: Catalog) -> list[Event]:
    """Return the events of `notes`, in their order.

    A repeated unit, a plan, and faults read before the recording are no events.
    """
    events: list[Event] = []
    before: UnitFound | None = None
    for note in notes:
        event = _event(note, catalog)
        if isinstance(event, UnitFound):
            if before is not None:
                another = _identity(event) != _identity(before)
                if not another and before.recording == event.recording:
                    continue
                event = replace(event, another=another)
            before = event
        if event is not None:
            events.append(event)
    return events


def comment_of(notes: Iterable[Note]) -> str:
    """Return the last comment; empty without one."""
    texts = [note.data.get("text") for note in notes if note.kind == _COMMENT]
    return next((text for text in reversed(texts) if isinstance(text, str)), "")


def recorded_faults(notes: Iterable[Note]) -> Iterator[FaultReading]:
    """Yield the readings of faults before the recording, of the same unit by the same program."""
    for note in notes:
        if note.kind == Kind.FAULTS and isinstance(data := note.data.get("readings"), list):
            yield from filter(None, map(_fault_reading, data))


def _identity(unit: UnitFound) -> tuple[int | None, Passport | None]:
    return unit.version_code, unit.passport


def _event(note: Note, catalog: Catalog) -> Event | None:
    time, data, recording = note.time, note.data, note.recording
    match note.kind:
        case Kind.MARKER:
            return Marker(time, _word(data.get("label")) or "", recording=recording)
        case Kind.NOTE if (words := _word(data.get("text"))) is not None:
            return TextNote(time, words, recording=recording)
        case Kind.GAP:
            began, ended = _number(data.get("began")), _number(data.get("ended"))
            began = time if began is None else began
            return Gap(time, began, ended, _text(data.get("reason")), recording=recording)
        case Kind.STATE if (state := _word(data.get("state"))) is not None:
            text, reason = _text(data.get("text")) or _NO_TEXT, _text(data.get("reason"))
            return StateChanged(time, state, text=text, reason=reason, recording=recording)
        case Kind.ADAPTER if (port := _word(data.get("port"))) is not None:
            return AdapterMoved(time, port, _word(data.get("before")) or "", recording=recording)
        case Kind.ALARM if (name := _word(data.get("channel"))) is not None:
            return AlarmChanged(
                time,
                name,
                _word(data.get("level")) or "",
                _word(data.get("before")),
                _word(data.get("side")),
                _number(data.get("value")),
                _number(data.get("limit")),
                _text(data.get("text")) or _NO_TEXT,
                data.get("better") is True,
                recording=recording,
            )
        case Kind.LEARNT if (name := _word(data.get("dropped"))) is not None:
            return ParameterDropped(time, name, recording=recording)
        case Kind.LEARNT if (name := _word(data.get("returned"))) is not None:
            return ParameterReturned(time, name, recording=recording)
        case Kind.LEARNT if (method := _word(data.get("method"))) is not None:
            rates = data.get("rates")
            items = rates.items() if isinstance(rates, dict) else ()
            known = {key: rate for key, value in items if (rate := _number(value)) is not None}
            return MethodChosen(time, method, known, recording=recording)
        case Kind.UNIT:
            version = version_of(data.get("version_code"))
            model = None if version is None else catalog.model(version).text
            passport = _passport(data.get("passports"))
            return UnitFound(time, version, passport, model=model, recording=recording)
    return None


def _fault_reading(data: object) -> FaultReading | None:
    if not isinstance(data, dict):
        return None
    time, codes = data.get("time"), data.get("codes")
    if not isinstance(time, (int, float)) or not isinstance(codes, list):
        return None
    if not all(isinstance(code, int) and 0 <= code <= 0xFF for code in codes):
        return None
    return FaultReading(float(time), tuple(codes), data.get("erased") is True)


def _word(value: object) -> str | None:
    return value if isinstance(value, str) else None


def _whole(value: object) -> int | None:
    return value if isinstance(value, int) and not isinstance(value, bool) else None


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        return float(value) if isfinite(value) else None
    except OverflowError:
        return None


def _text(value: object) -> Text | None:
    if not isinstance(value, dict):
        return None
    en, ru = _word(value.get("en")), _word(value.get("ru"))
    return None if en is None or ru is None else Text(en, ru)


def _passport(value: object) -> Passport | None:
    if not isinstance(value, list):
        return None
    pieces = tuple(map(_word, value))
    return Passport(pieces[:_PROGRAM_PIECES], pieces[_PROGRAM_PIECES:])
