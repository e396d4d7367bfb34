"""The wheel and the source distribution; both hold the built page (`tools/hatch_build.py`)."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from tools.package.project import DIST, ROOT, version


def build() -> list[Path]:
    """Build both into dist/."""
    for old in (*DIST.glob("*.whl"), *DIST.glob("mikas-*.tar.gz")):
        old.unlink()
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "--directory", str(DIST)], cwd=ROOT, check=True
    )
    return [wheel(), DIST / f"mikas-{version()}.tar.gz"]


def wheel() -> Path:
    """Return the path of the wheel of this version."""
    return DIST / f"mikas-{version()}-py3-none-any.whl"
