"""What the tests of captures share: a small one, and what is read from one."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader, Packet, Problem
from mikas.recording.capture.writer import CaptureWriter

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED
MICRO = 1_000_000


def small_capture(path: Path) -> bytes:
    """Writes one of eight packets; its bytes."""
    with CaptureWriter(path, url="sim:", overwrite=True) as writer:
        for number in range(4):
            writer.record(SENT, b"\x61\x1a\x85\x0d"[: number + 1], number)
            writer.record(RECEIVED, b"\x7d\x83\x0d", number + 0.5)
    return path.read_bytes()


def read(path: Path) -> tuple[list[Packet], list[Problem]]:
    items = list(CaptureReader(path))
    return (
        [item for item in items if isinstance(item, Packet)],
        [item for item in items if isinstance(item, Problem)],
    )


def contents(packets: Iterable[Packet]) -> list[tuple[Direction, bytes, float]]:
    return [(packet.direction, packet.data, packet.time) for packet in packets]
