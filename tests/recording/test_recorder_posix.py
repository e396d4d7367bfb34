"""The recorder against the system's own limits: a file that may not grow, a folder that is gone."""

from __future__ import annotations

import shutil
import subprocess
import sys

from recorder_harness import RECEIVED, SENT, begin_session, sampled, wire

from mikas.recording.recorder import Recorder

_LIMITED = """
import resource, sys
from mikas.link.base import Direction
from mikas.recording.recorder import Recorder
resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
recorder = Recorder()
recorder.start(sys.argv[1], url="sim:")
for turn in range(500):
    recorder.record(Direction.SENT, b"\\x01\\xff\\x0d", 1.0 + turn)
print(recorder.failure.reason.en)
"""


def test_a_file_that_may_not_grow_ends_the_recording_with_its_name(tmp_path):
    file = tmp_path / "a.pcapng"
    done = subprocess.run(
        [sys.executable, "-B", "-c", _LIMITED, str(file)],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "a.pcapng" in done.stdout
    assert 3900 < file.stat().st_size <= 4000
    assert len(wire(file)[SENT]) > 100


def test_a_folder_that_is_gone_ends_the_recording_with_its_reason(tmp_path):
    folder = tmp_path / "stick"
    folder.mkdir()
    recorder = Recorder()
    recorder.start(folder / "a.pcapng", url="sim:")
    begin_session(recorder)
    recorder.record(SENT, b"\x01\xff\x0d", 2.0)
    shutil.rmtree(folder)
    for turn in range(5):
        recorder.record(SENT, b"\x01\xff\x0d", 3.0 + turn)
        recorder.record_event(sampled(3.0 + turn))
    assert "deleted" in recorder.failure.reason.en
    assert (recorder.status.samples, recorder.status.lost) == (0, 5)  # those in it are gone too
    assert recorder.status.bytes == 0
    recorder.start(tmp_path / "b.pcapng", url="sim:")
    recorder.record(SENT, b"\x02\xfe\x0d", 9.0)
    recorder.stop()
    assert wire(tmp_path / "b.pcapng") == {SENT: b"\x02\xfe\x0d", RECEIVED: b""}
