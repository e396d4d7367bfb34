"""Every label is used by the page."""

from __future__ import annotations

import re
from pathlib import Path

import mikas.report
from mikas.report.labels import LABELS


def test_every_label_is_on_the_page() -> None:
    folder = Path(mikas.report.__file__).parent
    files = [folder / "page.py", *folder.glob("*.html"), *folder.glob("sections/*.py")]
    text = "".join(file.read_text("utf-8") for file in files)
    assert {name for name in LABELS if not re.search(rf"""["']{name}["']""", text)} == set()
