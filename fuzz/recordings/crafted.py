"""Blocks as a stranger would craft them: whole, but with contents that no program writes."""

from __future__ import annotations

import struct
from random import Random
from typing import Final

from fuzz.recordings import hostile
from mikas import framing
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import ENTERPRISE, TAG

_KINDS: Final = (
    *(pcapng.SECTION, pcapng.INTERFACE, pcapng.SIMPLE, pcapng.ENHANCED, pcapng.CUSTOM),
    *(pcapng.CUSTOM_PRIVATE, 5, 4, 0xDEAD),
)
_RESOLUTIONS: Final = (6, 6, 6, 6, 0, 3, 9, 18, 38, 127, 0x80, 0x8A, 0xA0, 0xBF, 0xFF)
_OFFSETS: Final = (0, 0, 0, 1, -1, 10**9, -(10**9), 1 << 40, (1 << 63) - 1, -(1 << 63))
_SPEEDS: Final = (0, 1, 50, 9600, 9600, 115_200, 1 << 32, (1 << 64) - 1)
_LINK_TYPES: Final = (147, 147, 147, 147, 1, 0, 0xFFFF)
_URLS: Final = ("sim:", "/dev/ttyUSB0", "\x1b]0;x\x07", "x" * 3000, "гора", "")
_MAGIC: Final = 0x1A2B3C4D


def recording(random: Random, chunks: list[bytes]) -> bytes:
    """Return a whole file. `chunks`: pieces of real conversations."""
    if random.random() < 0.2:
        return _many_of_one(random)
    return b"".join(_session(random, chunks) for _ in range(random.choice((1, 1, 1, 2, 5, 30))))


def block(random: Random, order: pcapng.Order, chunks: list[bytes]) -> bytes:
    """Return one crafted block of any kind."""
    choice = random.randrange(10)
    if choice < 4:
        return note(random, order)
    if choice < 6:
        return packet(random, order, random.choice(hostile.TICKS), chunks)
    if choice < 7:
        return interface(random, order)
    if choice < 8:
        return section(random, order)
    return _wrong_lengths(random, order)


def section(random: Random, order: pcapng.Order) -> bytes:
    """Return a section, now and then of another version, or no more than its magic."""
    if random.random() < 0.1:
        return _raw(order, pcapng.SECTION, struct.pack(order + "I", _MAGIC))
    made = pcapng.Section(
        hardware=_printed(random),
        application=random.choice(("mikas 1", "mikas", "", _printed(random))),
        version=random.choice(((1, 0), (1, 0), (1, 0), (1, 2), (2, 0), (0xFFFF, 0xFFFF))),
    )
    return pcapng.encode(made, order)


def interface(random: Random, order: pcapng.Order) -> bytes:
    """Return an interface with any resolution, offset and link type."""
    made = pcapng.Interface(
        link_type=random.choice(_LINK_TYPES),
        name=random.choice(_URLS),
        description=_printed(random),
        speed=random.choice(_SPEEDS),
        tsresol=random.choice(_RESOLUTIONS),
        tsoffset=random.choice(_OFFSETS),
    )
    return pcapng.encode(made, order)


def packet(random: Random, order: pcapng.Order, ticks: int, chunks: list[bytes]) -> bytes:
    """Return a packet with protocol frames, whole or not."""
    made = pcapng.EnhancedPacket(
        interface=random.choice((0, 0, 0, 0, 0, 0, 1, 7, (1 << 32) - 1)),
        ticks=ticks & ((1 << 64) - 1),
        data=_wire(random, chunks),
        flags=random.choice((1, 1, 1, 2, 2, 2, 0, 3, (1 << 32) - 1)),
        comment=random.choice(("", "", "", _printed(random))),
        cut=random.choice((0, 0, 0, 0, 1, 1000)),
    )
    return pcapng.encode(made, order)


def note(random: Random, order: pcapng.Order) -> bytes:
    """Return a note with hostile JSON."""
    made = pcapng.Custom(ENTERPRISE, TAG + hostile.note(random), private=random.random() < 0.05)
    return pcapng.encode(made, order)


def _session(random: Random, chunks: list[bytes]) -> bytes:
    order: pcapng.Order = random.choice(("<", "<", ">"))
    parts = [section(random, order)]
    parts += [interface(random, order) for _ in range(random.choice((1, 1, 1, 1, 2, 0)))]
    ticks = random.choice(hostile.TICKS)
    step = random.choice((3000, 3000, 50_000, 10**6, 10**12, 0, -4000))
    foreign = random.choice((0.02, 0.1, 0.5))
    for _ in range(random.choice((0, 3, 20, 100))):
        if random.random() < foreign:
            parts.append(block(random, order, chunks))
        if random.random() < 0.02:
            ticks = random.choice(hostile.TICKS)
        parts.append(packet(random, order, ticks, chunks))
        ticks += random.randrange(abs(step) + 1) * (1 if step >= 0 else -1)
    return b"".join(parts)


def _many_of_one(random: Random) -> bytes:
    """Return a good beginning and thousands of small things that each begin, or seem to."""
    order: pcapng.Order = random.choice(("<", ">"))
    head = pcapng.encode(pcapng.Section(application="mikas 1"), order)
    head += pcapng.encode(pcapng.Interface(name="sim:", speed=9600), order)
    head += pcapng.encode(pcapng.EnhancedPacket(0, 1000, b"\x02\xfe\x0d", 2), order)
    magic = struct.pack(order + "I", _MAGIC)
    some = random.choice(
        (
            struct.pack(order + "II", pcapng.SECTION, 28) + magic,
            struct.pack(order + "II", pcapng.SECTION, 1 << 20) + magic,
            _raw(order, pcapng.SECTION, magic),
            _raw(order, pcapng.SECTION, magic + struct.pack(order + "HHq", 1, 0, -1)),
            struct.pack(order + "III", pcapng.CUSTOM, 12, ENTERPRISE) + TAG,
            struct.pack(order + "III", pcapng.CUSTOM, 1 << 20, ENTERPRISE) + TAG,
            pcapng.encode(pcapng.Custom(ENTERPRISE, TAG + b"{}"), order),
            pcapng.encode(pcapng.Interface(), order),
            pcapng.encode(pcapng.Interface(link_type=1), order),
            pcapng.encode(pcapng.EnhancedPacket(0, 5000, b"\x02\xfe\x0d", 2), order),
            pcapng.encode(pcapng.EnhancedPacket(9, 5000, b"", 2), order),
            pcapng.encode(pcapng.EnhancedPacket(0, 5000, b"\x0d" * 64, 1), order),
            pcapng.encode(pcapng.SimplePacket(b"\x0d"), order),
            struct.pack(order + "III", pcapng.ENHANCED, 1 << 16, 0),
            struct.pack(order + "III", 0xDEAD, 12, 12),
            hostile.note(random)[:200],
        )
    )
    # Not more than the costly readers can read in a second when each byte is read once.
    count = random.choice((50, 500, 3000))
    some = some * min(count, 60_000 // len(some))
    if random.random() < 0.3:  # and all of it inside one block
        some = _raw(order, random.choice(_KINDS), some + bytes(-len(some) % 4))
    return head + some + (head if random.random() < 0.5 else b"")


def _wrong_lengths(random: Random, order: pcapng.Order) -> bytes:
    """Return a block whose lengths differ, are too long, or overlap the next blocks."""
    kind, first = random.choice(_KINDS), random.choice(hostile.LENGTHS)
    last = random.choice((first, first, random.choice(hostile.LENGTHS)))
    body = random.randbytes(random.choice((0, 4, 8, 16, 20, 64)))
    head = struct.pack(order + "II", kind, first & 0xFFFFFFFF)
    return head + body + struct.pack(order + "I", last & 0xFFFFFFFF)


def _raw(order: pcapng.Order, kind: int, body: bytes) -> bytes:
    total = struct.pack(order + "I", len(body) + 12)
    return struct.pack(order + "I", kind) + total + body + total


def _wire(random: Random, chunks: list[bytes]) -> bytes:
    choice = random.randrange(10)
    if choice < 6:
        return random.choice(chunks)
    if choice < 8:
        body = random.choice((b"\x61", b"\x71", b"\x64", b"\x63", b"\x02", b"\x01", b"\x21", b""))
        body += random.randbytes(random.choice((0, 1, 2, 8, 60)))
        return framing.encode(body) if body else b"\x0d"
    if choice < 9:
        return random.randbytes(random.choice((0, 1, 3, 40, 600)))
    return random.choice((b"\x0d" * 200, b"\x40" * 300, b"\x40\xcd" * 100, b"\x01\xff\x0d" * 100))


def _printed(random: Random) -> str:
    return hostile.text(random).encode("utf-8", "replace").decode()
