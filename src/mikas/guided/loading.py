"""Read guided tests from TOML files: the shipped ones, then the user's folder `tests`.

A wrong file is an error with file and line (`CatalogError`); the others still load. docs/
guided-tests.md describes all keys.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Final

from mikas.catalog import Catalog
from mikas.catalog.loading.source import CatalogFile, read_source
from mikas.errors import CatalogError, reason_of
from mikas.guided.build import Builder
from mikas.guided.definition import GuidedTest
from mikas.i18n import Text

FOLDER: Final = "tests"
"""The folder of the user's tests, beside the config file."""

MOST_FILES: Final = 200


@dataclass(frozen=True, slots=True)
class LoadedTests:
    """The tests by name, and the error of each file that is not one."""

    tests: Mapping[str, GuidedTest]
    errors: tuple[CatalogError, ...] = ()


def load(catalog: Catalog, folder: Path | None = None) -> LoadedTests:
    """Return the shipped tests and those in the user's `folder`, a later name over an earlier."""
    tests = dict(_shipped(catalog))
    errors: list[CatalogError] = []
    for path in _files(folder, errors):
        try:
            test = from_source(read_source(path), catalog, own=True)
        except CatalogError as error:
            errors.append(error)
        else:
            tests[test.name] = test
    return LoadedTests(tests, tuple(errors))


def _files(folder: Path | None, errors: list[CatalogError]) -> list[Path]:
    if folder is None:
        return []
    try:
        files = sorted(path for path in folder.iterdir() if path.suffix == ".toml")
    except FileNotFoundError:
        return []
    except OSError as error:
        reason = reason_of(error)
        problem = Text(f"can't be read: {reason.en}", f"не читается: {reason.ru}")
        errors.append(CatalogError(str(folder), 0, problem))
        return []
    if len(files) > MOST_FILES:
        problem = Text(
            f"has more than {MOST_FILES} tests; only the first are read",
            f"больше {MOST_FILES} проверок; прочитаны только первые",
        )
        errors.append(CatalogError(str(folder), 0, problem))
    return files[:MOST_FILES]


@lru_cache(maxsize=4)
def _shipped(catalog: Catalog) -> Mapping[str, GuidedTest]:
    """Return the shipped tests by name."""
    files = sorted((Path(__file__).parent / "shipped").glob("*.toml"))
    return {test.name: test for test in (from_source(read_source(path), catalog) for path in files)}


def from_source(source: CatalogFile, catalog: Catalog, *, own: bool = False) -> GuidedTest:
    """Return the test in `source`, named as its file. Raises `CatalogError`."""
    return Builder(source, catalog).test(own=own)
