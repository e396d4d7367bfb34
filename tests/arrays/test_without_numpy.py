"""Ordinary tests of what reads recordings, run once more over the arrays of the browser.

Here are those that tell most for their time. By hand, all but those that need numpy itself:
`python -m pytest -p arrays.without_numpy tests/recording tests/report tests/guided`.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
CHOSEN = (
    "catalog/test_catalog_formulas.py",
    "guided/test_guided_engine.py",
    "drives/test_mixture.py",
    "drives/test_overview.py",
    "drives/test_pulls.py",
    "drives/test_trips.py",
    "recording/export/test_export_csv.py",
    "recording/export/test_export_tracks.py",
    "recording/exchanges/test_values.py",
    "recording/test_channels.py",
    "recording/test_recorded_faults.py",
    "recording/test_search.py",
    "recording/test_window.py",
    "report/test_warm_idle.py",
    "client/test_derived.py",
)
OF_NUMPY = "a_column_is_its_numbers or of_a_long_file"  # they are written in more of numpy


def test_the_same_over_the_arrays_of_the_browser():
    command = [sys.executable, "-m", "pytest", "-p", "arrays.without_numpy", "-n", "0"]
    command += ["-p", "no:cacheprovider", "-k", f"not ({OF_NUMPY})"]
    command += [f"tests/{name}" for name in CHOSEN]
    ran = subprocess.run(
        command, check=False, capture_output=True, text=True, timeout=300, cwd=ROOT
    )
    assert ran.returncode == 0, ran.stdout
