"""Recordings that the tests of notebooks show: of a virtual car, and of chosen values and notes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import mikas
from mikas.framing import encode
from mikas.link.base import Direction
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import note_of
from mikas.sampling.events import Event
from session_header_harness import write_session_header

URL = "sim:?clock=simulated&scenario=warm-idle&faults=13,55"
NOON = 1_700_000_000.0
FREQ = 0x29  # 40 rpm a bit


def of_a_car(path: Path, *events: Event, names: Sequence[str] = (), count: int = 60) -> Path:
    """Record a virtual car with all that a session notes, and these events."""
    with CaptureWriter(path, url=URL) as sink, mikas.connect(URL, sink=sink) as ecu:
        write_session_header(
            sink,
            ecu.tester.link.now(),
            version_code=ecu.version_code,
            passports=ecu.passport().pieces,
            catalog_version=ecu.catalog.version,
            adapter="a cable",
        )
        ecu.faults()
        for _ in ecu.watch(*names, method="batch", count=count):
            pass
        for event in events:
            sink.note(note_of(event))
    return path


def of_values(
    path: Path,
    values: Iterable[tuple[float, int]],
    *events: Event,
    zero: float = NOON,
    code: int = FREQ,
) -> Path:
    """Record responses of one byte, each (seconds, raw value), and these events."""
    with CaptureWriter(path, url="/dev/ttyUSB0") as sink:
        for time, raw in values:
            sink.record(Direction.SENT, encode(bytes((0x61, code))), zero + time)
            sink.record(Direction.RECEIVED, encode(bytes((raw,))), zero + time + 0.01)
        for event in events:
            sink.note(note_of(event))
    return path
