"""Notes in a recording: who was asked, by what plan, and what happened beside the wire.

A note is a Custom Block of pcapng, of the copyable kind (0x0BAD): other tools read on behind it
(new ones list it, without a time and not as a packet), and editcap keeps it. The project has no
Private Enterprise Number of its own: it uses 32473, which RFC 5612 reserves for documentation.
Others may do so as well, hence the tag in front of the payload; behind it stands one JSON object in
ASCII, `{"kind", "time", "data"}`, filled up with zeros.

Reading looks for notes alone, so it takes a fraction of the time that all packets would take, and
damage anywhere else in the file is no hindrance. A note that can't be read is passed over; one of a
kind that is not known here is kept.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any, BinaryIO, Final, Protocol

from mikas.recording import pcapng
from mikas.recording.scan import LARGEST, RawBlock, scan

if TYPE_CHECKING:
    from mikas.client import Limits
    from mikas.language import Text
    from mikas.sampling.alarms import AlarmEvent
    from mikas.sampling.events import LineState
    from mikas.sampling.plan import Plan

ENTERPRISE: Final = 32473  # RFC 5612: for documentation; nobody's own
TAG: Final = b"mikas/1\n"

_WINDOW: Final = 1 << 20
_OVERLAP: Final = 64  # more than what is looked for is long
_SECTION_START: Final = b"\x0a\x0d\x0d\x0a"  # the same in both byte orders
_BEFORE_TAG: Final = 12  # bytes of a note's block
_SECTION_OR_NOTE: Final = re.compile(
    rb"\x0A\x0D\x0D\x0A.{4}(?:\x4D\x3C\x2B\x1A|\x1A\x2B\x3C\x4D)"
    rb"|(?:\xAD\x0B\0\0.{4}\xD9\x7E\0\0|\0\0\x0B\xAD.{4}\0\0\x7E\xD9)" + re.escape(TAG),
    re.DOTALL,
)


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


def plan_note(time: float, plan: Plan, reading: str = "corrected") -> Note:
    """What is asked from here on. `every`: in which cycles, name by name."""
    data = {
        "method": plan.method,
        "names": [wanted.parameter.name for wanted in plan.wanted],
        "every": [wanted.every for wanted in plan.wanted],
        "max_list": plan.max_list,
        "reading": reading,
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


def alarm_note(event: AlarmEvent) -> Note:
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
    reading: str = "corrected",
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
        sink.note(plan_note(time, plan, reading))


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


# On the disk


def block_of(note: Note) -> pcapng.Custom:
    """The block that holds `note`. Raises `ValueError` for what JSON can't hold, or a huge one."""
    content = {"kind": str(note.kind), "time": note.time, "data": dict(note.data)}
    data = TAG + json.dumps(content, allow_nan=False, separators=(",", ":")).encode()
    if len(data) > LARGEST // 2:
        raise ValueError("the note is too long")
    return pcapng.Custom(ENTERPRISE, data)


def read_block(block: pcapng.Custom) -> Note | None:
    """The note in `block`; None if it holds none."""
    if block.enterprise != ENTERPRISE or not block.data.startswith(TAG):
        return None
    try:
        content = json.loads(block.data[len(TAG) :].rstrip(b"\0"), parse_constant=_refuse)
        kind, time, data = content["kind"], float(content["time"]), dict(content["data"])
        if not isinstance(kind, str):
            return None
        return Note(Kind(kind) if kind in _KINDS else kind, time, data)
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
        return None


_KINDS: Final = frozenset(Kind)


def _refuse(constant: str) -> None:
    """NaN and its like are no JSON."""
    raise ValueError(constant)


def find(file: BinaryIO) -> Iterator[Note]:
    """The notes of a capture that is open for reading and seekable, in the order of the file."""
    recording, known = -1, True
    for offset, is_section in _places(file):
        block = _block_at(file, offset)
        if isinstance(block, pcapng.Section) and is_section:
            recording += 1
            known = block.version[0] == 1
        elif isinstance(block, pcapng.Custom) and known:
            note = read_block(block)
            if note is not None:
                yield Note(note.kind, note.time, note.data, max(0, recording), offset)


def _places(file: BinaryIO) -> Iterator[tuple[int, bool]]:
    """Where sections and notes may begin, and which of the two."""
    start = 0
    while True:
        file.seek(start)
        window = file.read(_WINDOW)
        last = len(window) < _WINDOW
        stop = len(window) if last else len(window) - _OVERLAP
        # Two plain searches, twenty times as fast as the expression, which then judges.
        found = {*_all(window, _SECTION_START, 0), *_all(window, TAG, _BEFORE_TAG)}
        for at in sorted(found):
            match = _SECTION_OR_NOTE.match(window, at)
            if match and at < stop:
                yield start + at, match[0].startswith(b"\x0a\x0d")
        if last:
            return
        start += stop


def _all(window: bytes, what: bytes, behind: int) -> Iterator[int]:
    """Where blocks may begin, `what` being so far behind their beginning."""
    at = window.find(what)
    while at >= 0:
        if at >= behind:
            yield at - behind
        at = window.find(what, at + 1)


def _block_at(file: BinaryIO, offset: int) -> pcapng.Block | None:
    file.seek(offset)
    order: pcapng.Order = ">" if file.read(1) == b"\0" else "<"
    item = next(scan(file, offset, order), None)
    if not isinstance(item, RawBlock):
        return None
    try:
        return pcapng.parse(item.kind, item.body, item.order)
    except pcapng.Malformed:
        return None
