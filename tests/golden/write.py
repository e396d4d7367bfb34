"""Write what the golden drives give now: `python tests/golden/write.py [DRIVE …]`."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

from golden.garage_rig import DRIVES  # noqa: E402  (once the tests are found)
from golden.runs_rig import RUNS  # noqa: E402

for drive in DRIVES:
    for name, run in RUNS.items():
        if drive.name in (sys.argv[1:] or [drive.name]):
            with tempfile.TemporaryDirectory() as folder:
                text = run(drive, Path(folder))
            (HERE / drive.name).mkdir(exist_ok=True)
            (HERE / drive.name / f"{name}.txt").write_text(text, "utf-8")
