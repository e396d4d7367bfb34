"""What all parts share: the folders, and the version, which stands in pyproject.toml alone."""

from __future__ import annotations

import os
import subprocess
import tomllib
from pathlib import Path
from typing import Any, Final

ROOT: Final = Path(__file__).resolve().parents[2]
HERE: Final = ROOT / "tools" / "package"
DIST: Final = ROOT / "dist"
"""What a release has."""
BUILD: Final = ROOT / "build" / "package"
"""What is kept between two builds."""
ICONS: Final = HERE / "icons"
_BEFORE_GIT: Final = 1_580_601_600  # of hatchling's archives, for a source without a history


class Failed(Exception):
    """The package can't be built; the text says why, and what to do."""


def pyproject() -> dict[str, Any]:
    """Return pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))


def project() -> dict[str, Any]:
    """Return the table `project`."""
    table: dict[str, Any] = pyproject()["project"]
    return table


def version() -> str:
    """Return the version."""
    return str(project()["version"])


def check_tag(tag: str) -> None:
    """Raise `Failed` unless `tag` is that of this version: `v0.1.0`."""
    if tag != f"v{version()}":
        raise Failed(f"the tag is {tag}, but pyproject.toml has the version {version()}")


def time_of_source() -> int:
    """Return the UNIX time of files that are built: SOURCE_DATE_EPOCH, or that of the commit."""
    if given := os.environ.get("SOURCE_DATE_EPOCH"):
        return int(given)
    asked = subprocess.run(
        ["git", "log", "-1", "--format=%ct"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return int(asked.stdout) if asked.stdout.strip().isdigit() else _BEFORE_GIT
