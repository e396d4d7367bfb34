"""What the tests of a person's own files share: writing one, and how a wrong one is refused."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import pytest

from mikas.catalog import load, shipped
from mikas.errors import CatalogError, UsageError

Write: TypeAlias = Callable[[str], Path]

# Two codes that no shipped parameter has, as a file writes them.
FREE, ALSO_FREE = (
    f"0x{code:02X}" for code in sorted(set(range(0x33, 0x100)) - set(dict(shipped().codes)))[:2]
)
NEW = f'[parameter.P]\ncode = {FREE}\nsize = 1\ntext = "p"\n'
"""A whole new parameter, the least of a file."""


def refused(path: Path, *more: Path) -> CatalogError:
    with pytest.raises(CatalogError) as caught:
        load(path, *more)
    place = f":{caught.value.line}" if caught.value.line else ""
    assert str(caught.value).startswith(f"{caught.value.file}{place}: ")
    return caught.value


def assert_refused(path: Path, line: int, problem: str) -> None:
    """Assert that the error names the file, the line and the problem, in both languages."""
    error = refused(path)
    assert error.file == str(path)
    assert problem in error.problem.en
    assert error.line == line
    assert re.search("[А-яЁё]", error.problem.ru)
    assert isinstance(error, UsageError)
