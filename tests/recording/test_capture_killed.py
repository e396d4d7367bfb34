"""A recording program that is killed: what it had recorded is in the file.

`kill` is SIGKILL on POSIX and TerminateProcess on Windows: the program gets no last word.
"""

from __future__ import annotations

import subprocess
import sys

import pytest

from mikas.recording.capture.reader import CaptureReader, Packet

pytestmark = pytest.mark.realtime

RECORD_FOR_EVER = """
import itertools, sys
from mikas.link.base import Direction
from mikas.recording.capture.writer import CaptureWriter

writer = CaptureWriter(sys.argv[1], url="sim:")
for number in itertools.count(1):
    direction = Direction.SENT if number % 2 else Direction.RECEIVED
    writer.record(direction, number.to_bytes(4, "big"), number / 200)
    print(number, flush=True)
"""


def test_a_killed_recorder_loses_nothing_that_was_recorded(tmp_path):
    path = tmp_path / "killed.pcapng"
    command = [sys.executable, "-c", RECORD_FOR_EVER, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as program:
        try:
            for _ in range(300):
                program.stdout.readline()
        finally:
            program.kill()
        reported = 300 + program.stdout.read().count(b"\n")
    assert program.returncode != 0
    items = list(CaptureReader(path))
    packets = [item for item in items if isinstance(item, Packet)]
    assert len(packets) >= reported
    assert len(items) - len(packets) <= 1  # at most the one that was being written is cut
    for number, packet in enumerate(packets, 1):
        assert (packet.data, packet.time) == (number.to_bytes(4, "big"), number / 200)
