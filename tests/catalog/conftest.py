"""A person's own catalog files, written where each test has a folder of its own."""

from __future__ import annotations

from pathlib import Path

import pytest
from catalog_harness import Write


@pytest.fixture
def write(tmp_path: Path) -> Write:
    count = 0

    def to_file(text: str) -> Path:
        nonlocal count
        count += 1
        path = tmp_path / f"own{count}.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return to_file
