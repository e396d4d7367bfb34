"""Changes to a real recording: of blocks, as a malicious editor makes them, and of bytes."""

from __future__ import annotations

import struct
from collections.abc import Callable
from io import BytesIO
from random import Random
from typing import Final

from fuzz.recordings import crafted, hostile
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.scan import scan

Blocks = list[bytes]


def pieces(data: bytes) -> Blocks:
    """Return the blocks of a file; bytes that are no block are one piece."""
    return [data[item.offset : item.end] for item in scan(BytesIO(data))]


def mutated(random: Random, data: bytes, others: list[bytes], chunks: list[bytes]) -> bytes:
    """Return the recording `data` with some changes. `others`: recordings to take blocks from."""
    parts = pieces(data)
    if len(parts) > 60 and random.random() < 0.7:  # shorter ones are read faster
        begin = random.randrange(len(parts) - 40)
        parts = parts[: random.choice((0, 8))] + parts[begin : begin + random.choice((20, 40, 80))]
    for _ in range(random.choice((0, 1, 1, 2, 5))):
        random.choice(_OF_BLOCKS)(random, parts, others, chunks)
    changed = bytearray(b"".join(parts))
    for _ in range(random.choice((0, 0, 1, 1, 3, 10))):
        if changed:
            random.choice(_OF_BYTES)(random, changed)
    return bytes(changed)


def _place(random: Random, parts: Blocks) -> int:
    return random.randrange(len(parts)) if parts else 0


def _inserted(random: Random, parts: Blocks, _others: list[bytes], chunks: list[bytes]) -> None:
    for _ in range(random.choice((1, 1, 3, 30))):
        made = crafted.block(random, random.choice(("<", "<", ">")), chunks)
        parts.insert(_place(random, parts), made)


def _noted(random: Random, parts: Blocks, _others: list[bytes], _chunks: list[bytes]) -> None:
    for _ in range(random.choice((1, 3, 10))):
        parts.insert(_place(random, parts), crafted.note(random, "<"))


def _spliced(random: Random, parts: Blocks, others: list[bytes], _chunks: list[bytes]) -> None:
    taken = pieces(random.choice(others))
    at = _place(random, taken)
    parts[_place(random, parts) :] = taken[at : at + random.choice((1, 10, 60))]


def _doubled(random: Random, parts: Blocks, _others: list[bytes], _chunks: list[bytes]) -> None:
    at = _place(random, parts)
    parts[at:at] = parts[at : at + random.choice((1, 4))] * random.choice((1, 2, 40))


def _swapped(random: Random, parts: Blocks, _others: list[bytes], _chunks: list[bytes]) -> None:
    for _ in range(random.choice((1, 10))):
        if parts:
            one, other = _place(random, parts), _place(random, parts)
            parts[one], parts[other] = parts[other], parts[one]


def _dropped(random: Random, parts: Blocks, _others: list[bytes], _chunks: list[bytes]) -> None:
    at = random.choice((0, 0, 1, _place(random, parts)))
    del parts[at : at + random.choice((1, 1, 3, 20))]


def _restamped(random: Random, parts: Blocks, _others: list[bytes], _chunks: list[bytes]) -> None:
    """Write other ticks into one packet, or into all from there on."""
    first, count = _place(random, parts), random.choice((1, 1, 5, 1000))
    ticks, step = random.choice(hostile.TICKS), random.choice((0, 1, 3000, 10**9, 1 << 50))
    for at in range(first, min(len(parts), first + count)):
        part = parts[at]
        if part.startswith(struct.pack("<I", pcapng.ENHANCED)) and len(part) >= 32:
            high, low = divmod(ticks & ((1 << 64) - 1), 1 << 32)
            parts[at] = part[:12] + struct.pack("<II", high, low) + part[20:]
            ticks += step


def _redescribed(random: Random, parts: Blocks, _others: list[bytes], _chunks: list[bytes]) -> None:
    """Put another interface in the place of one."""
    for at, part in enumerate(parts):
        if part.startswith(struct.pack("<I", pcapng.INTERFACE)):
            parts[at] = crafted.interface(random, "<")
            if random.random() < 0.5:
                return


def _flipped(random: Random, data: bytearray) -> None:
    data[random.randrange(len(data))] ^= 1 << random.randrange(8)


def _overwritten(random: Random, data: bytearray) -> None:
    at, count = random.randrange(len(data)), random.choice((1, 2, 4, 16, 200))
    data[at : at + count] = random.randbytes(len(data[at : at + count]))


def _numbered(random: Random, data: bytearray) -> None:
    """Write a telling number where one may stand."""
    at = random.randrange(len(data)) & -4
    word = random.choice((*hostile.WORDS, *hostile.LENGTHS)) & 0xFFFFFFFF
    data[at : at + 4] = struct.pack(random.choice("<>") + "I", word)


def _cut(random: Random, data: bytearray) -> None:
    del data[random.randrange(len(data)) :]


def _shortened(random: Random, data: bytearray) -> None:
    at = random.randrange(len(data))
    del data[at : at + random.choice((1, 3, 4, 12, 300))]


def _lengthened(random: Random, data: bytearray) -> None:
    at = random.randrange(len(data))
    fill = random.choice((b"\0", b"\x0a\x0d\x0d\x0a", b"\x0d", b"\xff", b"mikas/1\n"))
    data[at:at] = fill * random.choice((1, 2, 7, 100))


def _digits(random: Random, data: bytearray) -> None:
    """Put another number in the place of one in a note's JSON."""
    at = data.find(b'":', random.randrange(len(data)))
    if at >= 0:
        new = hostile.value(random).encode("utf-8", "replace")[:40]
        data[at + 2 : at + 2 + len(new)] = new


_OF_BLOCKS: Final[tuple[Callable[[Random, Blocks, list[bytes], list[bytes]], None], ...]] = (
    *(_inserted, _noted, _spliced, _doubled, _swapped, _dropped, _restamped, _redescribed),
)
_OF_BYTES: Final[tuple[Callable[[Random, bytearray], None], ...]] = (
    *(_flipped, _overwritten, _numbered, _cut, _shortened, _lengthened, _digits),
)
