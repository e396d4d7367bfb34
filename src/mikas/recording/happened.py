"""What the notes of a recording tell, as values: who was recorded, and what happened when.

Notes come from a file, so anything may stand in them: what is missing or of another type is None,
and a note that says nothing of its kind makes no event.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from math import isfinite
from typing import Any, ClassVar

from mikas.catalog import Catalog
from mikas.i18n import Text
from mikas.recording.notes import Kind, Note


@dataclass(frozen=True, slots=True)
class Unit:
    """Who was recorded, through what, and by which definitions; None: the notes do not tell.

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


@dataclass(frozen=True, slots=True)
class Happened:
    """Something at a time of the link's clock. `recording`: which of the file's."""

    kind: ClassVar[str]
    time: float
    recording: int = field(default=0, kw_only=True)

    def as_json(self) -> dict[str, Any]:
        """Its `kind` and its fields by name; texts in both languages."""
        named = ((each.name, getattr(self, each.name)) for each in fields(self))
        shown = {name: _json(value) for name, value in named if name != "recording"}
        return {"kind": self.kind} | shown


@dataclass(frozen=True, slots=True)
class MarkerSet(Happened):
    """Somebody marked the moment."""

    kind = "marker"
    label: str = ""


@dataclass(frozen=True, slots=True)
class NoteTaken(Happened):
    """A person's words."""

    kind = "note"
    text: str = ""


@dataclass(frozen=True, slots=True)
class GapSeen(Happened):
    """Nothing came from `began` to `ended` (None: to the recording's end)."""

    kind = "gap"
    began: float = 0.0
    ended: float | None = None
    reason: Text | None = None


@dataclass(frozen=True, slots=True)
class StateSeen(Happened):
    """The way to the ECU was open so far from here on."""

    kind = "state"
    state: str = ""
    text: Text | None = None
    reason: Text | None = None


@dataclass(frozen=True, slots=True)
class AlarmSeen(Happened):
    """A limit was crossed, either way."""

    kind = "alarm"
    name: str = ""
    level: str = ""
    before: str | None = None
    side: str | None = None
    value: float | None = None
    limit: float | None = None
    text: Text | None = None


@dataclass(frozen=True, slots=True)
class MethodChosen(Happened):
    """Asked by this method from here on; `rates`: sets a second that each one gave."""

    kind = "method"
    method: str = ""
    rates: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ParameterDropped(Happened):
    """The unit refuses this parameter."""

    kind = "dropped"
    name: str = ""


@dataclass(frozen=True, slots=True)
class UnitSeen(Happened):
    """Who answered; `another`: not the one before."""

    kind = "unit"
    model: Text | None = None
    version_code: int | None = None
    passport: tuple[str | None, ...] | None = None
    another: bool = False


def unit_of(notes: Iterable[Note], catalog: Catalog) -> Unit | None:
    """Who the notes of one recording say it was; None if they do not."""
    said: dict[str, Mapping[str, Any]] = {}
    for note in notes:
        said.setdefault(note.kind, note.data)
    if Kind.UNIT not in said:
        return None
    unit, plan = said[Kind.UNIT], said.get(Kind.PLAN, {})
    version = _whole(unit.get("version_code"))
    names = plan.get("names")
    return Unit(
        version_code=version,
        model=None if version is None else catalog.model(version).text,
        passport=_passport(unit.get("passports")),
        adapter=_word(unit.get("adapter")) or "",
        baud=_whole(unit.get("baud")),
        echo=unit["echo"] if isinstance(unit.get("echo"), bool) else None,
        catalog=_word(said.get(Kind.CATALOG, {}).get("version")),
        interpretation=_word(plan.get("reading")),
        method=_word(plan.get("method")),
        names=tuple(map(str, names)) if isinstance(names, list) else (),
    )


def events_of(notes: Iterable[Note], catalog: Catalog) -> list[Happened]:
    """What the notes tell, in their order."""
    return list(_events(notes, catalog))


def _events(notes: Iterable[Note], catalog: Catalog) -> Iterator[Happened]:
    before: UnitSeen | None = None
    for note in notes:
        event = _event(note, catalog)
        if isinstance(event, UnitSeen):
            told = (event.version_code, event.passport)
            known = before and (before.version_code, before.passport)
            if told == known and before and before.recording == event.recording:
                continue
            if known is not None and told != known:
                event = UnitSeen(event.time, event.model, *told, True, recording=event.recording)
            before = event
        if event is not None:
            yield event


def _event(note: Note, catalog: Catalog) -> Happened | None:
    time, data, recording = note.time, note.data, note.recording
    match note.kind:
        case Kind.MARKER:
            return MarkerSet(time, _word(data.get("label")) or "", recording=recording)
        case Kind.NOTE if (words := _word(data.get("text"))) is not None:
            return NoteTaken(time, words, recording=recording)
        case Kind.GAP:
            began = _number(data.get("began"))
            ended = _number(data.get("ended"))
            reason = _text(data.get("reason"))
            began = time if began is None else began
            return GapSeen(time, began, ended, reason, recording=recording)
        case Kind.STATE if (state := _word(data.get("state"))) is not None:
            text, reason = _text(data.get("text")), _text(data.get("reason"))
            return StateSeen(time, state, text, reason, recording=recording)
        case Kind.ALARM if (name := _word(data.get("channel"))) is not None:
            return AlarmSeen(
                time,
                name,
                _word(data.get("level")) or "",
                _word(data.get("before")),
                _word(data.get("side")),
                _number(data.get("value")),
                _number(data.get("limit")),
                _text(data.get("text")),
                recording=recording,
            )
        case Kind.LEARNT if (name := _word(data.get("dropped"))) is not None:
            return ParameterDropped(time, name, recording=recording)
        case Kind.LEARNT if (method := _word(data.get("method"))) is not None:
            rates = data.get("rates")
            items = rates.items() if isinstance(rates, dict) else ()
            known = {key: rate for key, value in items if (rate := _number(value)) is not None}
            return MethodChosen(time, method, known, recording=recording)
        case Kind.UNIT:
            version = _whole(data.get("version_code"))
            model = None if version is None else catalog.model(version).text
            passport = _passport(data.get("passports"))
            return UnitSeen(time, model, version, passport, recording=recording)
    return None


def _json(value: object) -> object:
    if isinstance(value, Text):
        return {"en": value.en, "ru": value.ru}
    if isinstance(value, Mapping):
        return dict(value)
    return list(value) if isinstance(value, tuple) else value


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


def _passport(value: object) -> tuple[str | None, ...] | None:
    return tuple(map(_word, value)) if isinstance(value, list) else None
