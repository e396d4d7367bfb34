"""What the tests of a person's own files share: writing one, and how a wrong one is refused."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import pytest

from mikas.catalog import load
from mikas.errors import CatalogError, UsageError

Write: TypeAlias = Callable[[str], Path]


def refused(path: Path, *more: Path) -> CatalogError:
    with pytest.raises(CatalogError) as caught:
        load(path, *more)
    place = f":{caught.value.line}" if caught.value.line else ""
    assert str(caught.value).startswith(f"{caught.value.file}{place}: ")
    return caught.value


def assert_refused(path: Path, line: int, problem: str) -> None:
    """The file is told, with the line and the problem, in both languages."""
    error = refused(path)
    assert error.file == str(path)
    assert problem in error.problem.en
    assert error.line == line
    assert re.search("[А-яЁё]", error.problem.ru)
    assert isinstance(error, UsageError)
