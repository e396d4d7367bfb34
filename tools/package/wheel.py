"""The wheel and the source distribution; both hold the built page (`tools/hatch_build.py`).

The wheel brings the manual, which is made before and found by that hook in build/share.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from tools.package import manual
from tools.package.project import DIST, ROOT, version

_SHARE = ROOT / "build" / "share"


def build() -> list[Path]:
    """Build both into dist/."""
    for old in (*DIST.glob("*.whl"), *DIST.glob("mikas-*.tar.gz")):
        old.unlink()
    try:
        write_manual(_SHARE)
        subprocess.run(
            [sys.executable, "-m", "hatchling", "build", "--directory", str(DIST)],
            cwd=ROOT, check=True,
        )  # fmt: skip
    finally:
        shutil.rmtree(_SHARE, ignore_errors=True)  # a later build of another state would take it
    return [wheel(), DIST / f"mikas-{version()}.tar.gz"]


def write_manual(share: Path) -> None:
    """Write the pages into a folder `share`, as one that `man` looks into."""
    for name, page in manual.files().items():
        path = share / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(page, "utf-8", newline="\n")


def wheel() -> Path:
    """Return the path of the wheel of this version."""
    return DIST / f"mikas-{version()}-py3-none-any.whl"
