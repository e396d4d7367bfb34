"""Recordings made to cost a reader more than their size, and what counts its work."""

from __future__ import annotations

import io
import os
import struct
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import IO

import pytest

from mikas.framing import encode
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.notes import ENTERPRISE, TAG

SECTION = pcapng.encode(pcapng.Section(application="mikas"))
PORT = pcapng.encode(pcapng.Interface(name="sim:"))
MICRO = 1_000_000
_NOTE_HEAD = 8 + 4 + len(TAG)


def packet(body: bytes, time: float = 0.0, *, sent: bool = True, interface: int = 0) -> bytes:
    """A packet with one frame, or none for an empty body."""
    data = encode(body) if body else b""
    flags = pcapng.OUTBOUND if sent else pcapng.INBOUND
    ticks = int(time * MICRO)
    return pcapng.encode(pcapng.EnhancedPacket(interface, ticks, data, flags))


def exchange(request: bytes, response: bytes, time: float = 0.0) -> bytes:
    return packet(request, time) + packet(response, time + 0.01, sent=False)


def good() -> bytes:
    return SECTION + PORT + exchange(b"\x61\x1a", b"\x10", 1.0)


def nested(count: int, kind: int, body: bytes, step: int = 0) -> bytes:
    """`count` whole blocks, each with the next one in its body: all lengths fit."""
    step = step or 8 + len(body) + -len(body) % 4
    heads, tails = b"", b""
    for number in range(count):
        total = 12 + (count - number) * (step - 8) + (count - number - 1) * 12
        heads += struct.pack("<II", kind, total) + body.ljust(step - 8, b"\0")
        tails = struct.pack("<I", total) + tails
    return heads + tails


def fake_sections(n: int) -> bytes:
    fake = pcapng.encode(pcapng.Section())[:4] + struct.pack("<I", 48) + SECTION[8:12]
    return good() + fake * n


def fake_notes(n: int) -> bytes:
    fake = struct.pack("<III", pcapng.CUSTOM, 1 << 20, ENTERPRISE) + TAG
    return good() + fake * n


def nested_notes(n: int) -> bytes:
    return good() + nested(n, pcapng.CUSTOM, struct.pack("<I", ENTERPRISE) + TAG + b"{}  ")


def nested_sections(n: int) -> bytes:
    """Each is followed by its port and a packet that reaches to the end."""
    return good() + nested(n, pcapng.SECTION, SECTION[8:-4] + PORT)


def nested_packets(n: int) -> bytes:
    """No section: is it a recording that has lost its begin?"""
    return b"\0" + nested(n, pcapng.ENHANCED, struct.pack("<5I", 0, 0, 0, 1 << 30, 0))


def nested_ports(n: int) -> bytes:
    """Packets that look like ports: their interface has the number of the link type."""
    return good() + nested(n, pcapng.ENHANCED, struct.pack("<5I", 147, 0, 0, 1 << 30, 0))


def shifted_notes(n: int) -> bytes:
    """Each is shifted against its packets by other seconds."""
    note = '{"kind":"state","time":%d,"data":{}}'
    blocks = (pcapng.Custom(ENTERPRISE, TAG + (note % at).encode()) for at in range(n))
    return good() + b"".join(
        pcapng.encode(block) + packet(b"\x01", 9.0 + at * at) for at, block in enumerate(blocks)
    )


def planned_streams(n: int) -> bytes:
    """Plans in a row, with the responses of a stream between some of them."""
    note = TAG + b'{"kind":"plan","time":0.0,"data":{"method":"stream","names":["FREQ"]}}'
    plan = pcapng.encode(pcapng.Custom(ENTERPRISE, note))
    return good() + (plan * 9 + packet(b"\x50", 1.0, sent=False) * 4) * n


def nested_fault_requests(n: int) -> bytes:
    request = struct.pack("<5I", 0, 0, 0, 3, 3) + encode(b"\x02")
    return good() + nested(n, pcapng.ENHANCED, request)


def broken_packets(n: int) -> bytes:
    """The second length is wrong in every other one."""
    whole = exchange(b"\x61\x1a", b"\x10")
    return good() + (whole[:-4] + b"\1\2\3\4" + whole) * n


def shifted_packets(n: int) -> bytes:
    return good() + (b"\0" + packet(b"\x61\x1a")) * n


def both_byte_orders(n: int) -> bytes:
    big = pcapng.encode(pcapng.Section(), ">") + pcapng.encode(pcapng.Interface(), ">")
    big += pcapng.encode(pcapng.EnhancedPacket(0, 0, b"\x01\xff\x0d", pcapng.OUTBOUND), ">")
    return good() + (big + SECTION + PORT + packet(b"\x01")) * n


def far_lengths(n: int) -> bytes:
    """Whatever may be a block has its second length elsewhere, in no order."""
    totals = (4 * (1 + number * 7919 % (5 * n)) for number in range(n))
    heads = (struct.pack("<IIII", pcapng.ENHANCED, 64 + total, 0, 0) for total in totals)
    return good() + b"\1" + b"".join(heads) + bytes(64)


def distinct_requests(n: int) -> bytes:
    """Each asks for other parameters, and the clock runs to and fro."""
    codes = (b"\x61\x1a" + bytes([1 + number % 200, 1 + number // 200]) for number in range(n))
    return good() + b"".join(
        exchange(body, b"\1\2\3", 9.0 * (at % 2)) for at, body in enumerate(codes)
    )


def lists_set_anew(n: int) -> bytes:
    bodies = (b"\x64\x1a" + bytes([1 + number % 200]) for number in range(n))
    return good() + b"".join(exchange(body, b"\0") + exchange(b"\x63", b"\1\2") for body in bodies)


def sessions(n: int) -> bytes:
    return b"".join(SECTION + PORT + exchange(b"\x61\x1a", b"\x50", at) for at in range(n))


def empty_packets(n: int) -> bytes:
    """Within an unfinished frame, while the clock runs to and fro."""
    begun = pcapng.encode(pcapng.EnhancedPacket(0, 0, b"\5", pcapng.INBOUND))
    return good() + begun + b"".join(packet(b"", 9.0 * (at % 2), sent=False) for at in range(n))


def responses_to_a_long_request(n: int) -> bytes:
    flood = pcapng.EnhancedPacket(0, MICRO, encode(b"\x10") * n, pcapng.INBOUND)
    return good() + packet(b"\x61" + b"\x1a" * 2000) + pcapng.encode(flood)


EXCHANGES = (
    distinct_requests,
    lists_set_anew,
    sessions,
    empty_packets,
    responses_to_a_long_request,
)
FILES = (
    fake_sections,
    fake_notes,
    nested_notes,
    nested_sections,
    nested_packets,
    nested_fault_requests,
    broken_packets,
    shifted_packets,
    both_byte_orders,
    far_lengths,
    nested_ports,
    shifted_notes,
    planned_streams,
)


class CountedFile(io.FileIO):
    """A file that counts the bytes that are read from it."""

    taken = 0

    def read(self, size: int | None = -1, /) -> bytes:
        data = super().read(size)
        self.taken += len(data)
        return data


@contextmanager
def counted(path: Path) -> Iterator[list[CountedFile]]:
    """Give the files as which `path` is opened meanwhile."""
    opened: list[CountedFile] = []

    def fdopen(descriptor: int, mode: str, buffering: int = -1) -> IO[bytes]:
        if not path.exists() or not os.path.samestat(os.fstat(descriptor), path.stat()):
            return usual(descriptor, mode, buffering)
        opened.append(CountedFile(descriptor, mode))
        return opened[-1]

    usual = os.fdopen
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(os, "fdopen", fdopen)
        yield opened


def calls(work: Callable[[], object]) -> int:
    """Return how many functions `work` calls, those of C included."""
    counter = count()

    def profile(frame: object, event: str, arg: object) -> None:
        if event in ("call", "c_call"):
            next(counter)

    sys.setprofile(profile)
    try:
        work()
    finally:
        sys.setprofile(None)
    return next(counter)
