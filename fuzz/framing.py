"""`mikas.framing` against a second reading of §2 that has the whole stream before it.

Input: strictness and limit, the chunks' seed, the stream. The decoder must report the same events
in every chunking, keep its memory within the limit, and give back what `encode` made.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random
from typing import Final

from mikas.framing import Damage, DamageReason, Decoder, Event, Frame, encode

WORDS: Final = ("\x0d", "\x40", "\x40\xcd", "\x40\x00", "\x0d\x0d", "\xf3\x0d\x0d", "\xc0\x40\x0d")
_HEADER: Final = 3  # bytes before the stream
_NO_LIMIT: Final = 1 << 16
_REGULAR: Final = (0xCD, 0x00)


def check(data: bytes) -> None:
    if len(data) < _HEADER:
        return
    strict, limit, stream = bool(data[0] & 1), 1 + (data[1] or 4095), data[_HEADER:]
    expected = Reading(strict, limit)
    expected.read(stream)
    for chunks in ([stream], _cut(stream, Random(data[2]))):
        decoder = Decoder(strict=strict, limit=limit)
        events: list[Event] = []
        for chunk in chunks:
            events += decoder.feed(chunk)
            assert len(decoder.pending) <= limit + 1  # and a 0D that waits for the next byte
        assert events == expected.events
        assert decoder.pending == expected.pending
        assert decoder.offset == len(stream)
    for event in expected.events:
        if isinstance(event, Frame) and not event.irregular:
            assert event.wire in (encode(event.body), encode(event.body, raw_checksum=True))
    _round_trip(stream)


def _round_trip(body: bytes) -> None:
    for raw in (False, True):
        wire = encode(body, raw_checksum=raw)
        (event,) = Decoder(strict=True, limit=_NO_LIMIT).feed(wire)
        assert isinstance(event, Frame)
        assert (event.body, event.wire, event.irregular) == (body, wire, False)


def _cut(stream: bytes, random: Random) -> Iterator[bytes]:
    position = 0
    while position < len(stream):
        size = random.choice((1, 1, 2, 3, 7, 60))
        yield stream[position : position + size]
        position += size


@dataclass
class Reading:
    """§2 to the letter, byte by byte."""

    strict: bool
    limit: int
    events: list[Event] = field(default_factory=list)
    pending: bytes = b""

    def read(self, stream: bytes) -> None:
        position = 0
        while (end := stream.find(b"\x0d", position)) >= 0:
            position = self._part(stream, position, end)
            if position <= end:
                break  # the byte behind decides
        rest = stream[position:]
        if len(rest.removesuffix(b"\x0d")) > self.limit:
            self._too_long(rest, position)
        else:
            self.pending = rest

    def _part(self, stream: bytes, start: int, end: int) -> int:
        """Read the bytes before one 0D; return where the next ones begin."""
        part, behind = stream[start:end], stream[end + 1 : end + 2]
        if len(part) > self.limit:
            self._too_long(part, start)
        elif not part:  # D5
            pass
        elif sum(part) % 256 == 0:  # D3
            self._frame(part, b"\x0d", start)
        elif (sum(part) + 0x0D) % 256 == 0 and not behind:
            return start
        elif (sum(part) + 0x0D) % 256 == 0 and behind == b"\x0d":
            self._frame(part, b"\x0d\x0d", start)
            return end + 2
        else:
            self.events.append(Damage(DamageReason.CHECKSUM, part, start))
        return end + 1

    def _too_long(self, part: bytes, start: int) -> None:
        self.events.append(Damage(DamageReason.TOO_LONG, part[: self.limit], start))

    def _frame(self, part: bytes, ends: bytes, start: int) -> None:
        plain: list[int] = []
        regular, escaped = True, False
        for value in part:
            if escaped:
                regular &= value in _REGULAR  # D4
                plain[-1] = (0x40 + value) % 256
            else:
                plain.append(value)
            escaped = value == 0x40 and not escaped
        # A 40 that nothing follows is a raw checksum (D3), but no body's end.
        raw_escape = escaped and ends == b"\x0d"
        regular &= raw_escape or not escaped
        body = bytes(plain if ends == b"\x0d\x0d" else plain[:-1])
        if self.strict and not regular:
            self.events.append(Damage(DamageReason.IRREGULAR_ESCAPE, part, start))
        else:
            raw = raw_escape or ends == b"\x0d\x0d"
            self.events.append(Frame(body, part + ends, start, raw, not regular))
