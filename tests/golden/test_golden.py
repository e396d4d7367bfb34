"""Six drives: file, JSON lines, MQTT messages and the dashboard's are as they were.

A difference that is wanted: `python tests/golden/write.py`, and read the diff.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from golden.garage_rig import DRIVES
from golden.runs_rig import RUNS


@pytest.mark.parametrize("run", RUNS)
@pytest.mark.parametrize("drive", DRIVES, ids=lambda it: it.name)
def test_a_drive_gives_what_it_gave(drive, run, tmp_path):
    kept = Path(__file__).parent / drive.name / f"{run}.txt"
    assert RUNS[run](drive, tmp_path).splitlines() == kept.read_text("utf-8").splitlines()
