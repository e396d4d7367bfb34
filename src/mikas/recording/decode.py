"""A capture frame by frame: what `mikas decode` shows.

Each direction has a decoder of its own (§2). `mikas.recording.matching` tells which frames are echo
and which request a response answers (D1, D13). What bytes mean is not known here beyond the
command's name; a caller that does know hands in `describe`.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from mikas.commands import COMMANDS_BY_CODE
from mikas.framing import Damage, DamageReason, Decoder, Frame
from mikas.i18n import Language, Text
from mikas.link.tee import Direction
from mikas.recording.matching import SILENCE, SILENCE_AFTER_SENDING, Matching
from mikas.recording.reader import Packet, Problem, Source

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    Describe = Callable[[bytes, bytes | None], Text | None]
    """Takes a request's body, and its response's (`None`: it is the request that is shown)."""

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
    """What every item has. `begin`, `end`: the times of the packets with its first and last byte.

    `offset` is where the first of them stands in the file. `echo`: the line only gave back what was
    sent.
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
    """The frames of `items`, each as soon as it is whole; problems pass through. Never raises."""
    lines: dict[Source, _Line] = {}
    recording = 0
    for item in items:
        if isinstance(item, Problem):
            for line in lines.values():
                line.interrupt()
            yield item
            continue
        if item.source.recording != recording:
            recording = item.source.recording
            yield from _finished(lines)
            lines.clear()
        if item.source not in lines:
            lines[item.source] = _Line(item.source, describe)
        yield from lines[item.source].take(item)
    yield from _finished(lines)


def _finished(lines: dict[Source, _Line]) -> Iterator[Item]:
    for line in lines.values():
        yield from line.finish()


@dataclass(frozen=True, slots=True)
class _Stretch:
    """Up to which byte of its stream one packet reaches."""

    end: int
    time: float
    offset: int


class _Stream:
    """One direction: a decoder, and which packet brought which byte."""

    def __init__(self) -> None:
        self.decoder = Decoder()
        self.last: float | None = None
        self._stretches: deque[_Stretch] = deque()

    def feed(self, packet: Packet) -> list[tuple[Frame | Damage, _Stretch, _Stretch]]:
        """What the packet completes, with the packets of its first and last byte."""
        self.last = packet.time
        end = self.decoder.offset + len(packet.data)
        self._stretches.append(_Stretch(end, packet.time, packet.offset))
        placed = [
            (event, *self._place(event.offset, _length(event)))
            for event in self.decoder.feed(packet.data)
        ]
        self._forget(self.decoder.offset - len(self.decoder.pending))
        return placed

    def cut(self) -> tuple[bytes, _Stretch, _Stretch] | None:
        """Gives up the unfinished frame, if there is one."""
        left = self.decoder.reset()
        if not left:
            return None
        return left, *self._place(self.decoder.offset - len(left), len(left))

    def _place(self, start: int, length: int) -> tuple[_Stretch, _Stretch]:
        self._forget(start)
        last = next(it for it in self._stretches if it.end >= start + length)
        return self._stretches[0], last

    def _forget(self, start: int) -> None:
        while self._stretches and self._stretches[0].end <= start:
            self._stretches.popleft()


class _Line:
    """One port: both directions, and what is known of its echo."""

    def __init__(self, source: Source, describe: Describe | None) -> None:
        self._source = source
        self._describe = describe
        self._byte_time = 10 / (source.baud or 9600)  # §1
        self._streams = {direction: _Stream() for direction in Direction}
        self._sent_last = False
        self._matching = Matching()

    def take(self, packet: Packet) -> Iterator[Item]:
        stream = self._streams[packet.direction]
        if self._is_late(packet, stream):
            yield from self._cut(packet.direction)
        if packet.direction is Direction.SENT and not self._sent_last:
            self._matching.turn()
        for event, first, last in stream.feed(packet):
            where = (self._source, packet.direction, first.time, last.time, first.offset)
            echo = self._note(packet.direction, event)
            if isinstance(event, Damage):
                yield SeenDamage(*where, echo, event.data, event.reason.value)
            else:
                yield self._frame(where, echo, event)
        self._sent_last = packet.direction is Direction.SENT

    def interrupt(self) -> None:
        """A part of the file is missing here."""
        self._matching.interrupt()

    def finish(self) -> Iterator[Item]:
        for direction in Direction:
            yield from self._cut(direction)

    def _is_late(self, packet: Packet, stream: _Stream) -> bool:
        if stream.last is None:
            return False
        begin = packet.time - len(packet.data) * self._byte_time
        answered = packet.direction is Direction.RECEIVED and self._sent_last
        return begin - stream.last > (SILENCE_AFTER_SENDING if answered else SILENCE)

    def _cut(self, direction: Direction) -> Iterator[Item]:
        cut = self._streams[direction].cut()
        if cut is not None:
            data, first, last = cut
            where = (self._source, direction, first.time, last.time, first.offset)
            if data.endswith(b"\x0d"):  # the decoder still hoped for a raw checksum 0D (D3)
                yield SeenDamage(*where, False, data[:-1], DamageReason.CHECKSUM.value)
            else:
                yield SeenDamage(*where, False, data, UNFINISHED)

    def _note(self, direction: Direction, event: Frame | Damage) -> bool:
        """Keeps what matters for what comes; returns whether `event` is an echo."""
        wire = event.wire if isinstance(event, Frame) else event.data
        body = event.body if isinstance(event, Frame) else None
        if direction is Direction.SENT:
            self._matching.sent(wire, body)
            return False
        return self._matching.received(wire, body)

    def _frame(
        self, where: tuple[Source, Direction, float, float, int], echo: bool, frame: Frame
    ) -> SeenFrame:
        request = None
        name = None
        meaning = None
        if echo or where[1] is Direction.SENT:
            command = COMMANDS_BY_CODE.get(frame.body[0]) if frame.body else None
            name = command.SOURCE_NAME if command else None
            if self._describe is not None and not echo:
                meaning = self._describe(frame.body, None)
        else:
            request = self._matching.answered
            if self._describe is not None and request is not None:
                meaning = self._describe(request, frame.body)
        return SeenFrame(*where, echo, frame, request, name, meaning)


def _length(event: Frame | Damage) -> int:
    return len(event.wire) if isinstance(event, Frame) else len(event.data)


def to_json(item: Item) -> dict[str, object]:
    """One line of `mikas decode --json`: `type` is frame, damage or problem; bytes in hex."""
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
    """One line for a person, times counted from `zero`: `    0.012500 < 0A  Mikas 7.1`.

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
    told = item.meaning is not None and item.meaning.en.startswith(item.name or "\0")
    if item.name is not None and not item.echo and not told:  # 01 has a word of ours for a name
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
