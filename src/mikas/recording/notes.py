"""Notes in a recording: who was asked, by what plan, and what happened beside the wire.

How they lie in the file is `recording/note_blocks.py`'s to know.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any, Final, Protocol

if TYPE_CHECKING:
    from mikas.client import Limits
    from mikas.i18n import Text
    from mikas.sampling.alarms import AlarmChanged
    from mikas.sampling.events import LineState
    from mikas.sampling.plan import Plan


class Kind(StrEnum):
    """What a note tells."""

    UNIT = "unit"
    CATALOG = "catalog"
    PLAN = "plan"
    NOTE = "note"
    MARKER = "marker"
    GAP = "gap"
    STATE = "state"
    ALARM = "alarm"
    LEARNT = "learnt"
    FAULTS = "faults"


@dataclass(frozen=True, slots=True)
class Note:
    """One note. `time`: the link's clock; `data`: what JSON can hold, by name.

    `kind` is a `Kind`, or the word that a later version wrote. When read: `recording` counts the
    recordings of the file as `Source.recording` does, `offset` is the block's place in it.
    """

    kind: str
    time: float
    data: Mapping[str, Any] = field(default_factory=dict)
    recording: int = field(default=0, compare=False)
    offset: int = field(default=0, compare=False)


class NoteSink(Protocol):
    """Whoever keeps notes."""

    def note(self, note: Note) -> None:
        """Take one."""


# What each kind holds


def unit_note(
    time: float,
    *,
    version_code: int | None,
    passports: Sequence[str | None],
    adapter: str = "",
    baud: int = 9600,
    echo: bool | None = None,
) -> Note:
    """Who was asked, and through what. `passports`: 51–58; None for one that was not given."""
    data = {
        "version_code": version_code,
        "passports": list(passports),
        "adapter": adapter,
        "baud": baud,
        "echo": echo,
    }
    return Note(Kind.UNIT, time, data)


def catalog_note(time: float, version: str) -> Note:
    """Which definitions were in force."""
    return Note(Kind.CATALOG, time, {"version": version})


def plan_note(time: float, plan: Plan, interpretation: str = "corrected") -> Note:
    """What is asked from here on. `every`: in which cycles, name by name."""
    data = {
        "method": plan.method,
        "names": [wanted.parameter.name for wanted in plan.parameters],
        "every": [wanted.divisor for wanted in plan.parameters],
        "max_list": plan.max_list,
        "reading": interpretation,
    }
    return Note(Kind.PLAN, time, data)


def text_note(time: float, text: str) -> Note:
    """A person's words."""
    return Note(Kind.NOTE, time, {"text": text})


def marker_note(time: float, label: str = "") -> Note:
    """A moment worth finding again."""
    return Note(Kind.MARKER, time, {"label": label})


def gap_note(began: float, ended: float | None, reason: Text) -> Note:
    """Nothing came from `began` to `ended` (None: it has not ended yet)."""
    data = {"began": began, "ended": ended, "reason": _both(reason)}
    return Note(Kind.GAP, began, data)


def state_note(time: float, state: LineState, reason: Text | None = None) -> Note:
    """The way to the ECU is open so far since `time`."""
    data = {
        "state": state.value,
        "text": _both(state.text),
        "reason": None if reason is None else _both(reason),
    }
    return Note(Kind.STATE, time, data)


def alarm_note(event: AlarmChanged) -> Note:
    """A limit was crossed, either way."""
    data = {
        "channel": event.channel.name,
        "level": event.level.value,
        "before": event.before.value,
        "better": event.better,
        "side": event.side.value,
        "value": event.value,
        "limit": event.limit,
        "text": _both(event.text),
    }
    return Note(Kind.ALARM, event.time, data)


def learnt_note(
    time: float,
    limits: Limits | None,
    *,
    method: str | None = None,
    rates: Mapping[str, float] | None = None,
    dropped: str | None = None,
) -> Note:
    """What this unit was found to take and to lack (D10, D11), as far as that is known.

    `method`: in use from here on, and what each that was measured gave (sets a second); `dropped`:
    a parameter that the unit refuses.
    """
    learnt: dict[str, Any] = {} if limits is None else asdict(limits)
    if method is not None:
        learnt |= {"method": method, "rates": dict(rates or {})}
    if dropped is not None:
        learnt["dropped"] = dropped
    return Note(Kind.LEARNT, time, learnt)


def faults_note(time: float, readings: Iterable[tuple[float, Sequence[int], bool]]) -> Note:
    """What was read of stored faults before this recording began: when, which numbers, and whether
    they had just been erased. The last reading is the latest.
    """
    told = [{"time": at, "codes": list(codes), "erased": erased} for at, codes, erased in readings]
    return Note(Kind.FAULTS, time, {"readings": told})


def _both(text: Text) -> dict[str, str]:
    return {"en": text.en, "ru": text.ru}


# The head of a session


def write_session_header(
    sink: NoteSink,
    time: float,
    *,
    version_code: int | None,
    passports: Sequence[str | None],
    catalog_version: str,
    adapter: str = "",
    baud: int = 9600,
    echo: bool | None = None,
    plan: Plan | None = None,
    interpretation: str = "corrected",
) -> None:
    """What is needed to read a recording again, at its beginning: unit, catalog, plan.

    Written anew when another unit answers, or when the plan changes.
    """
    sink.note(
        unit_note(
            time,
            version_code=version_code,
            passports=passports,
            adapter=adapter,
            baud=baud,
            echo=echo,
        )
    )
    sink.note(catalog_note(time, catalog_version))
    if plan is not None:
        sink.note(plan_note(time, plan, interpretation))


@dataclass(frozen=True, slots=True)
class SessionHeader:
    """The head of one recording in a file; None for what was not written."""

    recording: int
    unit: Note | None = None
    catalog: Note | None = None
    plan: Note | None = None


def session_headers(notes: Iterable[Note]) -> list[SessionHeader]:
    """The head of each recording that has one: its first note of each kind."""
    found: dict[int, dict[str, Note]] = {}
    for note in notes:
        if note.kind in _IN_HEADER:
            found.setdefault(note.recording, {}).setdefault(str(note.kind), note)
    return [SessionHeader(recording, **kinds) for recording, kinds in found.items()]


_IN_HEADER: Final = frozenset({Kind.UNIT, Kind.CATALOG, Kind.PLAN})
