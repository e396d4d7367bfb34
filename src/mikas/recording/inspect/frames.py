"""A capture frame by frame, as `mikas decode` shows it.

`mikas.recording.exchanges.scalar` finds the frames, the echoes, and which request a response
answers. This module knows no meaning of bytes beyond the command's name; a caller that does passes
`describe`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from mikas.commands import COMMANDS_BY_CODE
from mikas.framing import Damage, DamageReason, Frame
from mikas.i18n import Language, Text
from mikas.link.tee import Direction
from mikas.recording.capture.reader import Packet, Problem, Source
from mikas.recording.exchanges.scalar import Line, LineEvent

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    Describe = Callable[[bytes, bytes | None], Text | None]
    """Takes a request's body, and its response's (None: the request itself is described)."""

SCHEMA: Final = 1
UNFINISHED: Final = "unfinished"  # beside the values of `DamageReason`

_REASONS: Final = {
    "checksum": Text("wrong checksum", "неверная контрольная сумма"),
    "too long": Text("no end in sight", "слишком длинно"),
    "irregular escape": Text("irregular escape", "необычная замена байта"),
    UNFINISHED: Text("unfinished", "не закончено"),
}
_ECHO = Text("echo", "эхо")
_RAW_CHECKSUM = Text("raw checksum", "контрольная сумма без замены")
_IRREGULAR = _REASONS["irregular escape"]


@dataclass(frozen=True, slots=True)
class Seen:
    """A part of the line. `begin`, `end`: the times of the packets with its first and last byte.

    `offset`: place of the first of them in the file. `echo`: the line returned a sent frame.
    """

    source: Source
    direction: Direction
    begin: float
    end: float
    offset: int
    echo: bool


@dataclass(frozen=True, slots=True)
class SeenFrame(Seen):
    """A sound frame. `request`: the body that this one answers; `None` for what was sent, and echo.

    `name` is the command's in the source, for a request; `meaning` what `describe` made of it.
    """

    frame: Frame
    request: bytes | None
    name: str | None
    meaning: Text | None


@dataclass(frozen=True, slots=True)
class SeenDamage(Seen):
    """Bytes that are no frame; `reason`: a value of `DamageReason`, or `UNFINISHED`."""

    data: bytes
    reason: str


Item = SeenFrame | SeenDamage | Problem


def decode(items: Iterable[Packet | Problem], describe: Describe | None = None) -> Iterator[Item]:
    """Yield the frames of `items` as soon as each is whole; pass problems through. Never raise."""
    lines: dict[Source, Line] = {}
    recording = 0
    for item in items:
        if isinstance(item, Problem):
            for line in lines.values():
                line.interrupt()
            yield item
            continue
        if item.source.recording != recording:
            recording = item.source.recording
            yield from _finished(lines, describe)
            lines.clear()
        if item.source not in lines:
            lines[item.source] = Line(item.source)
        for event in lines[item.source].take(item):
            yield _item(event, item.source, describe)
    yield from _finished(lines, describe)


def _finished(lines: dict[Source, Line], describe: Describe | None) -> Iterator[Item]:
    for source, line in lines.items():
        for event in line.finish():
            yield _item(event, source, describe)


def _item(it: LineEvent, source: Source, describe: Describe | None) -> SeenFrame | SeenDamage:
    where = (source, it.direction, it.first.time, it.last.time, it.first.offset, it.echo)
    if isinstance(it.event, Damage):
        return SeenDamage(*where, it.event.data, it.event.reason.value)
    if isinstance(it.event, bytes):
        if it.event.endswith(b"\x0d"):  # the decoder was waiting for a raw checksum 0D (D3)
            return SeenDamage(*where, it.event[:-1], DamageReason.CHECKSUM.value)
        return SeenDamage(*where, it.event, UNFINISHED)
    frame, request, name, meaning = it.event, None, None, None
    if it.echo or it.direction is Direction.SENT:
        command = COMMANDS_BY_CODE.get(frame.body[0]) if frame.body else None
        name = command.SOURCE_NAME if command else None
        if describe is not None and not it.echo:
            meaning = describe(frame.body, None)
    else:
        request = it.answers.body
        if describe is not None and request is not None:
            meaning = describe(request, frame.body)
    return SeenFrame(*where, frame, request, name, meaning)


def to_json(item: Item) -> dict[str, object]:
    """Return a line of `mikas decode --json`: `type` is frame, damage or problem; bytes in hex."""
    if isinstance(item, Problem):
        text = {"en": item.text.en, "ru": item.text.ru}
        return {"schema": SCHEMA, "type": "problem", "offset": item.offset, "text": text}
    line: dict[str, object] = {
        "schema": SCHEMA,
        "type": "frame" if isinstance(item, SeenFrame) else "damage",
        "recording": item.source.recording,
        "port": item.source.url,
        "time": item.begin,
        "end": item.end,
        "direction": item.direction.value,
        "echo": item.echo,
        "offset": item.offset,
    }
    if isinstance(item, SeenDamage):
        return line | {"reason": item.reason, "data": _hex(item.data)}
    meaning = None if item.meaning is None else {"en": item.meaning.en, "ru": item.meaning.ru}
    return line | {
        "body": _hex(item.frame.body),
        "wire": _hex(item.frame.wire),
        "raw_checksum": item.frame.raw_checksum,
        "irregular": item.frame.irregular,
        "name": item.name,
        "request": None if item.request is None else _hex(item.request),
        "meaning": meaning,
    }


def to_text(item: Item, language: Language = "en", *, zero: float = 0.0) -> str:
    """Return one line for a person, times counted from `zero`: `    0.012500 < 0A  Mikas 7.1`.

    `>` was sent, `<` received; a body without checksum and stuffing, damage as it came behind `!`.
    """
    if isinstance(item, Problem):
        return f"{'!':>14} {item.text.to(language)}"
    arrow = ">" if item.direction is Direction.SENT else "<"
    start = f"{item.begin - zero:12.6f} {arrow} "
    if isinstance(item, SeenDamage):
        data, notes = f"! {item.data.hex(' ').upper()}", [_REASONS[item.reason]]
    else:
        data, notes = item.frame.body.hex(" ").upper() or "—", _notes(item)
    if item.echo:
        notes.insert(0, _ECHO)
    return start + "  ".join([data, "; ".join(note.to(language) for note in notes)]).rstrip()


def _notes(item: SeenFrame) -> list[Text]:
    notes = []
    # The name of 01 is not from the source; a meaning may begin with it.
    has_name = item.meaning is not None and item.meaning.en.startswith(item.name or "\0")
    if item.name is not None and not item.echo and not has_name:
        notes.append(Text(item.name, item.name))
    if item.meaning is not None:
        notes.append(item.meaning)
    if item.frame.raw_checksum:
        notes.append(_RAW_CHECKSUM)
    if item.frame.irregular:
        notes.append(_IRREGULAR)
    return notes


def _hex(data: bytes) -> str:
    return data.hex().upper()
