"""`mikas split` on a disk that is full."""

from __future__ import annotations

import resource
import subprocess
import sys

import pytest

from merged_harness import record

pytestmark = pytest.mark.realtime


@pytest.mark.parametrize("missing", [1, 100, 2000])
def test_no_half_file_is_left(tmp_path, missing):
    """A part without its last minutes looked like a whole recording."""
    one = record(tmp_path / "one.pcapng", "A111AA52", port="/dev/ttyUSB0", count=20)
    two = record(tmp_path / "two.pcapng", "B222BB52", port="/dev/ttyUSB1", count=60)
    path = tmp_path / "both.pcapng"
    path.write_bytes(one.read_bytes() + two.read_bytes())
    room = two.stat().st_size - missing
    assert one.stat().st_size < room
    ran = subprocess.run(
        [sys.executable, "-Bc", "from mikas.cli.main import main; main()", "split", path],
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, room)),
        capture_output=True,
        text=True,
        encoding="utf-8",
    )
    assert ran.returncode
    assert "both-2.pcapng" in ran.stderr
    assert "no room left" in ran.stderr
    assert (tmp_path / "both-1.pcapng").read_bytes() == one.read_bytes()
    assert not (tmp_path / "both-2.pcapng").exists()
