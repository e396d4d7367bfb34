"""The same file through eyes that are not ours: Wireshark's command line.

Skipped where there is no tshark, unless `MIKAS_REQUIRE_TSHARK` is set: then that is a failure.
"""

from __future__ import annotations

import os
import shutil
import subprocess

import pytest

from capture_writing_harness import appending
from mikas.link.base import Direction
from mikas.recording.capture.writer import CaptureWriter

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED
FLAGS = {RECEIVED: 1, SENT: 2}

pytestmark = pytest.mark.skipif(
    shutil.which("tshark") is None and not os.environ.get("MIKAS_REQUIRE_TSHARK"),
    reason="tshark is not installed",
)

CHUNKS = [
    (SENT, b"\x01\xff\x0d", 0.0),
    (RECEIVED, b"\x01\xff\x0d\x0a\xf6\x0d", 0.010203),
    (SENT, b"\x61\x1a\x85\x0d", 1_700_000_000.000001),
    (RECEIVED, b"\x7d", 1_700_000_000.5),
    (RECEIVED, b"\x83\x0d", 1_700_000_000.501042),
]


def shown_by_tshark(path):
    fields = (
        "frame.time_epoch",
        "frame.packet_flags_direction",
        "data.data",
        "frame.interface_name",
    )
    chosen = [argument for field in fields for argument in ("-e", field)]
    result = subprocess.run(
        ["tshark", "-r", path, "-T", "fields", *chosen],
        env={**os.environ, "HOME": str(path.parent)},  # without the plugins of who runs the tests
        check=True,
        capture_output=True,
        encoding="utf-8",
    )
    assert "cut short" not in result.stderr
    return [tuple(line.split("\t")) for line in result.stdout.splitlines()]


def expected(chunks, url):
    return [
        (f"{time:.6f}000", f"0x{FLAGS[direction]:08x}", data.hex(), url)
        for direction, data, time in chunks
    ]


def test_tshark_sees_every_chunk_with_its_time_and_direction(tmp_path):
    path = tmp_path / "line.pcapng"
    with CaptureWriter(path, url="/dev/ttyUSB0") as writer:
        for chunk in CHUNKS:
            writer.record(*chunk)
    assert shown_by_tshark(path) == expected(CHUNKS, "/dev/ttyUSB0")


def test_tshark_reads_a_file_that_is_still_being_written(tmp_path):
    path = tmp_path / "line.pcapng"
    with CaptureWriter(path, url="sim:") as writer:
        for chunk in CHUNKS:
            writer.record(*chunk)
        assert shown_by_tshark(path) == expected(CHUNKS, "sim:")


def test_tshark_reads_several_recordings_in_a_file(tmp_path):
    path = tmp_path / "line.pcapng"
    with CaptureWriter(path, url="a") as writer:
        for chunk in CHUNKS:
            writer.record(*chunk)
    with appending(path, url="a") as writer:
        writer.record(*CHUNKS[0])
    assert shown_by_tshark(path) == expected([*CHUNKS, CHUNKS[0]], "a")
