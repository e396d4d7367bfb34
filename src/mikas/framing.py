"""Bytes ⇄ frames: checksum, byte stuffing, terminator (§2).

A frame on the wire is `[body][checksum][0D]`, body and checksum stuffed. The decoder never raises
on input: damage is an event.

Rule D3: stuffing does not change the sum modulo 256, so the bytes before a `0D` can be checked
unchanged. Sum 0: a whole frame. Sum F3 followed by a second `0D`: a frame whose checksum `0D` was
sent raw. Otherwise: damage, and the next frame starts after that `0D`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

TERMINATOR = 0x0D
ESCAPE = 0x40

_STUFFED_TERMINATOR = b"\x40\xcd"  # 40 + CD = 10D
_STUFFED_ESCAPE = b"\x40\x00"  # 40 + 00 = 40
_RAW_TERMINATOR_SUM = 0xF3  # -0D: all but a raw checksum 0D has been summed


class DamageReason(Enum):
    """The reason why bytes are no frame."""

    CHECKSUM = "checksum"
    """The sum is not 0."""
    TOO_LONG = "too long"
    """No terminator within the limit."""
    IRREGULAR_ESCAPE = "irregular escape"
    """Neither 40 CD nor 40 00; in strict mode only (D4)."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A valid frame. `wire`: with the terminator; `offset`: of its first byte in the stream.

    `raw_checksum`: the checksum was 0D or 40 and not stuffed (D3). `irregular`: an escape was
    neither 40 CD nor 40 00 and was decoded by the sum rule (D4).
    """

    body: bytes
    """The bytes without stuffing, checksum and terminator."""
    wire: bytes
    """The bytes as on the wire, with the terminator."""
    offset: int
    """Of its first byte in the stream."""
    raw_checksum: bool = False
    """Whether the checksum was 0D or 40 and not stuffed (D3)."""
    irregular: bool = False
    """Whether an escape was neither 40 CD nor 40 00 (D4)."""


@dataclass(frozen=True, slots=True)
class Damage:
    """Bytes that are no frame, without their terminator. `offset`: of the first one."""

    reason: DamageReason
    """Why they are no frame."""
    data: bytes
    """The bytes, without their terminator."""
    offset: int
    """Of the first one in the stream."""


Event = Frame | Damage


def checksum(body: bytes) -> int:
    """Return the byte that makes the sum with `body` 0 modulo 256 (§2.1). `01` → FF."""
    return -sum(body) & 0xFF


def stuff(data: bytes) -> bytes:
    """Replace `0D` by `40 CD`, `40` by `40 00` (§2.2)."""
    # The escapes first: stuffing a terminator makes new ones.
    return data.replace(b"\x40", _STUFFED_ESCAPE).replace(b"\x0d", _STUFFED_TERMINATOR)


def encode(body: bytes, *, raw_checksum: bool = False) -> bytes:
    """Return the frame of `body`: `01` → `01 FF 0D` (§2).

    `raw_checksum`: do not stuff the checksum (D3: the source does not specify it, and some units
    may need it).
    """
    check = bytes([checksum(body)])
    return stuff(body) + (check if raw_checksum else stuff(check)) + b"\x0d"


def unstuff(data: bytes) -> tuple[bytes, bool]:
    """Return `data` without stuffing, and whether an escape was irregular (D4).

    A `40` is added to any following byte; at the end it stays a `40`.
    """
    escapes = data.count(ESCAPE)
    if not escapes:
        return data, False
    if escapes == data.count(_STUFFED_TERMINATOR) + data.count(_STUFFED_ESCAPE):
        # Every 40 opens a pair that is one of the two, so the pairs can't overlap.
        return data.replace(_STUFFED_TERMINATOR, b"\x0d").replace(_STUFFED_ESCAPE, b"\x40"), False
    plain = bytearray()
    position = 0
    while position < len(data):
        value = data[position]
        if value == ESCAPE and position + 1 < len(data):
            position += 1
            value = (ESCAPE + data[position]) & 0xFF
        plain.append(value)
        position += 1
    return bytes(plain), True


class Decoder:
    """Decodes chunks of bytes into frames and damage, independent of the chunks' sizes.

    `limit`: bytes of the longest frame on the wire without terminator; a longer one is damage, so
    memory is bounded. `strict`: an irregular escape (D4) is damage. Bare terminators (D5) are
    skipped, and counted in `noise`.
    """

    def __init__(self, *, limit: int = 4096, strict: bool = False) -> None:
        if limit < 1:
            raise ValueError("limit must be at least 1 byte")
        self.limit = limit
        self.strict = strict
        self.noise: int = 0
        """The bare terminators that were skipped (D5)."""
        self._buffer = bytearray()
        self._searched = 0  # no terminator before this index: feeding single bytes stays linear
        self._offset = 0  # of the buffer's first byte in the stream
        self._overflowed = False  # inside an over-long frame, already reported

    @property
    def pending(self) -> bytes:
        """The bytes of an unfinished frame."""
        return bytes(self._buffer)

    @property
    def is_between_frames(self) -> bool:
        """Whether the next byte begins a frame."""
        return not self._buffer and not self._overflowed

    @property
    def offset(self) -> int:
        """The number of bytes fed."""
        return self._offset + len(self._buffer)

    def reset(self) -> bytes:
        """Drop the unfinished frame and return its bytes."""
        dropped = bytes(self._buffer)
        self._drop(len(dropped))
        self._overflowed = False
        return dropped

    def feed(self, data: bytes) -> list[Event]:
        """Return the frames and the damage that `data` completes, in order. Never raises."""
        self._buffer += data
        events: list[Event] = []
        start = 0
        while (end := self._buffer.find(TERMINATOR, self._searched)) >= 0:
            if self._overflowed:
                self._overflowed = False
                start = self._searched = end + 1
                continue
            part = bytes(self._buffer[start:end])
            total = sum(part) & 0xFF
            next_start = end + 1
            if len(part) > self.limit:
                events.append(self._too_long(start))
            elif part and total == 0:
                events.append(self._frame(part, start))
            elif total == _RAW_TERMINATOR_SUM and next_start == len(self._buffer):
                self._searched = end  # the next byte decides
                break
            elif total == _RAW_TERMINATOR_SUM and self._buffer[next_start] == TERMINATOR:
                events.append(self._frame(part, start, raw_terminator=True))
                next_start += 1
            elif part:
                events.append(Damage(DamageReason.CHECKSUM, part, self._offset + start))
            else:  # a bare terminator, D5
                self.noise += 1
            start = self._searched = next_start
        else:
            self._searched = len(self._buffer)
        self._drop(start)
        self._bound(events)
        return events

    def _frame(self, part: bytes, start: int, *, raw_terminator: bool = False) -> Event:
        """`raw_terminator`: the checksum was a raw 0D, so that `part` is the body."""
        offset = self._offset + start
        plain, irregular = unstuff(part)
        raw = raw_terminator
        if not raw_terminator and part[-1] == plain[-1] == ESCAPE:
            # A lone 40 at the end is a raw checksum, and no other irregularity; in `40 40` the
            # first escapes the second.
            raw, irregular = True, unstuff(part[:-1])[1]
        if irregular and self.strict:
            return Damage(DamageReason.IRREGULAR_ESCAPE, part, offset)
        if raw_terminator:
            return Frame(plain, part + b"\x0d\x0d", offset, raw, irregular)
        return Frame(plain[:-1], part + b"\x0d", offset, raw, irregular)

    def _too_long(self, start: int) -> Damage:
        data = bytes(self._buffer[start : start + self.limit])
        return Damage(DamageReason.TOO_LONG, data, self._offset + start)

    def _bound(self, events: list[Event]) -> None:
        """Keep the buffer within the limit; report a longer frame once."""
        # A terminator that waits for its successor (D3) does not count.
        if self._overflowed:
            self._drop(len(self._buffer))
        elif self._searched > self.limit:
            events.append(self._too_long(0))
            self._drop(len(self._buffer))
            self._overflowed = True

    def _drop(self, count: int) -> None:
        del self._buffer[:count]
        self._offset += count
        self._searched = max(0, self._searched - count)
