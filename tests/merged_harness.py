"""Recordings of two cars, and what Wireshark's tools make of them."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

import mikas
from mikas.catalog import shipped
from mikas.client.cars import CarDetails
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import car_note
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.dating import moved
from mikas.recording.capture.notes import block_of, read_block
from mikas.recording.capture.scan import RawBlock, scan
from session_header_harness import write_session_header

needs_wireshark = pytest.mark.skipif(
    shutil.which("mergecap") is None and not os.environ.get("MIKAS_REQUIRE_TSHARK"),
    reason="Wireshark's mergecap, editcap and reordercap are not installed",
)
MICRO = 1_000_000
MERGES = ("cat", "mergecap", "mergecap -a", "mergecap -I none", "cat, editcap")
PASSPORT = ("PROGRAM", "x", "x", "x", "x", "x", "x")


def record(
    path: Path,
    plate: str,
    *,
    faults: str = "",
    version: int = 10,
    port: str = "",
    count: int = 40,
    head: bool = True,
) -> Path:
    """Record a car. `head`: its notes come before the first packet, as in the dashboard."""
    model = "5.4" if version == 9 else "7.1"
    url = f"sim:?clock=simulated&scenario=warm-idle&model={model}&faults={faults}"
    with CaptureWriter(path, url=port or url) as sink:

        def describe(now: float) -> None:
            write_session_header(
                sink,
                now,
                version_code=version,
                passports=(plate, *PASSPORT),
                catalog_version=shipped().version,
            )
            sink.note(car_note(now, CarDetails(plate=plate)))

        if head:
            describe(0.0)
        with mikas.connect(url, sink=sink) as ecu:
            ecu.faults()
            if not head:
                describe(ecu.tester.link.now())
            for _ in ecu.watch("FREQ", "TWAT", method="batch", count=count):
                pass
            ecu.faults()
    return path


def shifted(path: Path, out: Path, seconds: float) -> Path:
    """Write a copy whose packets and notes have later times: editcap shifts packets alone."""
    data = b""
    with path.open("rb") as file:
        for item in scan(file):
            assert isinstance(item, RawBlock)
            block = pcapng.parse(item.kind, item.body, item.order)
            assert block is not None
            if isinstance(block, pcapng.EnhancedPacket):
                block = replace(block, ticks=block.ticks + round(seconds * MICRO))
            elif isinstance(block, pcapng.Custom) and (note := read_block(block)):
                block = block_of(moved(note, seconds))
            data += pcapng.encode(block, item.order)
    out.write_bytes(data)
    return out


def ran(*command: object) -> None:
    """Run one of the tools."""
    subprocess.run([*map(str, command)], check=True, capture_output=True)


def merged(how: str, out: Path, *files: Path) -> Path:
    """Merge in one of the ways of `MERGES`."""
    if how.startswith("cat"):
        joined = out.with_suffix(".cat") if "editcap" in how else out
        joined.write_bytes(b"".join(file.read_bytes() for file in files))
        if "editcap" in how:
            ran("editcap", joined, out)
    else:
        ran(*how.split(), "-w", out, *files)
    return out
