"""The notes of a release: what towncrier has written into CHANGELOG.md for this version."""

from __future__ import annotations

import re

from tools.package.project import ROOT, Failed, version


def notes() -> str:
    """Return the section of this version. Raises `Failed` if there is none."""
    text = (ROOT / "CHANGELOG.md").read_text("utf-8")
    sections = re.split(r"^## ", text, flags=re.MULTILINE)
    found = next((each for each in sections if each.startswith(f"[{version()}]")), None)
    if found is None:
        raise Failed(f"CHANGELOG.md has no {version()}; towncrier build --version {version()}")
    return found.partition("\n")[2].strip() + "\n"
