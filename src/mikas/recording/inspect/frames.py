"""A capture frame by frame, as `mikas decode` shows it.

`mikas.recording.exchanges.scalar` finds the frames, the echoes, and which request a response
answers; the meaning of the bytes comes from the caller's `describe`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from mikas.i18n import Language, Text
from mikas.link.tee import Direction
from mikas.recording.capture.reader import Packet, Problem, Source
from mikas.recording.exchanges.scalar import UNFINISHED, DecodedDamage, DecodedFrame, PortDecoder

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    Describe = Callable[[bytes, bytes | None], Text | None]
    """Takes a request's body, and its response's (None: the request itself is described)."""

SCHEMA: Final = 1

_REASONS: Final = {
    "checksum": Text("wrong checksum", "неверная контрольная сумма"),
    "too long": Text("no end in sight", "слишком длинно"),
    "irregular escape": Text("irregular escape", "необычная замена байта"),
    UNFINISHED: Text("unfinished", "не закончено"),
}
_ECHO = Text("echo", "эхо")
_RAW_CHECKSUM = Text("raw checksum", "контрольная сумма без замены")
_IRREGULAR = _REASONS["irregular escape"]


Item = DecodedFrame | DecodedDamage | Problem


def decode(items: Iterable[Packet | Problem], describe: Describe | None = None) -> Iterator[Item]:
    """Yield the frames of `items` as soon as each is whole; pass problems through. Never raise."""
    ports: dict[Source, PortDecoder] = {}
    recording = 0
    for item in items:
        if isinstance(item, Problem):
            for port in ports.values():
                port.matching.interrupt()
            yield item
            continue
        if item.source.recording != recording:
            recording = item.source.recording
            for port in ports.values():
                yield from port.finish()
            ports.clear()
        if item.source not in ports:
            ports[item.source] = PortDecoder(item.source)
        for part in ports[item.source].feed(item):
            yield part if describe is None else _described(part, describe)
    for port in ports.values():
        yield from port.finish()


def _described(
    item: DecodedFrame | DecodedDamage, describe: Describe
) -> DecodedFrame | DecodedDamage:
    if isinstance(item, DecodedDamage) or item.echo:
        return item
    request, response = item.request, item.frame.body
    if item.direction is Direction.SENT:
        return replace(item, meaning=describe(item.frame.body, None))
    return item if request is None else replace(item, meaning=describe(request, response))


def to_json(item: Item) -> dict[str, object]:
    """Return a line of `mikas decode --json`: `type` is frame, damage or problem; bytes in hex."""
    if isinstance(item, Problem):
        text = {"en": item.text.en, "ru": item.text.ru}
        return {"schema": SCHEMA, "type": "problem", "offset": item.offset, "text": text}
    line: dict[str, object] = {
        "schema": SCHEMA,
        "type": "frame" if isinstance(item, DecodedFrame) else "damage",
        "recording": item.source.recording,
        "port": item.source.url,
        "time": item.begin,
        "end": item.end,
        "direction": item.direction.value,
        "echo": item.echo,
        "offset": item.offset,
    }
    if isinstance(item, DecodedDamage):
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
    if isinstance(item, DecodedDamage):
        data, notes = f"! {item.data.hex(' ').upper()}", [_REASONS[item.reason]]
    else:
        data, notes = item.frame.body.hex(" ").upper() or "—", _notes(item)
    if item.echo:
        notes.insert(0, _ECHO)
    return start + "  ".join([data, "; ".join(note.to(language) for note in notes)]).rstrip()


def _notes(item: DecodedFrame) -> list[Text]:
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
