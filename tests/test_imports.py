"""No circle of files: the imports inside functions and those for types alone count as well."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

SOURCES = Path(__file__).parent.parent / "src"


def name_of(file: Path) -> str:
    return ".".join(file.relative_to(SOURCES).with_suffix("").parts).removesuffix(".__init__")


def imports_of(file: Path, modules: set[str]) -> Iterator[str]:
    own = name_of(file)
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        match node:
            case ast.Import(names):
                yield from (each.name for each in names)
            case ast.ImportFrom(module, names, level):
                base = ".".join((*own.split(".")[: -level or None], *filter(None, [module])))
                within = base if level else module
                for each in names:
                    inner = f"{within}.{each.name}"
                    yield inner if inner in modules else within


def test_no_module_imports_itself_by_way_of_others():
    files = {name_of(file): file for file in (SOURCES / "mikas").rglob("*.py")}
    graph = {
        name: {each for each in imports_of(file, set(files)) if each in files} - {name}
        for name, file in files.items()
    }
    assert graph["mikas.dissectors.sigrok._parts.decoder"]  # of relative imports
    assert "mikas.notebook.drawing" in graph["mikas.notebook.recording"]  # of late ones
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" <- ".join(error.args[1]))
