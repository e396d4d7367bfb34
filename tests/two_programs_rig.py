"""Another program that records to a file, until it is ended or killed."""

from __future__ import annotations

import subprocess
import sys
from contextlib import contextmanager

_RECORDS = """
import sys
from mikas.link.base import Direction
from mikas.recording import CaptureWriter
with CaptureWriter(sys.argv[1], url="sim:") as writer:
    writer.record(Direction.RECEIVED, b"\\x00", 1.0)
    print("recording", flush=True)
    sys.stdin.read()
"""


@contextmanager
def another_recording(path):
    """The process, once it records to `path`."""
    command = [sys.executable, "-c", _RECORDS, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout.readline().strip() == b"recording"
            yield process
        finally:
            process.kill()
