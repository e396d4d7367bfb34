"""The example notebooks run from top to bottom, and the results shown in them are not stale."""

from __future__ import annotations

import re

import nbformat
import pytest
from execute import NOTEBOOKS, executed, results

LARGEST = 400_000  # bytes


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def path(request):
    return request.param


@pytest.mark.realtime
@pytest.mark.filterwarnings("ignore:Proactor event loop:RuntimeWarning")  # Windows: zmq goes on
def test_each_notebook_runs_and_has_the_results_that_it_shows(path):
    """Its own cells check its numbers against the virtual car that it drives."""
    assert results(executed(path)) == results(nbformat.read(path, as_version=4)), (
        f"{path.name} shows other results: .venv/bin/python tests/notebooks/execute.py"
    )


def test_each_notebook_is_for_readers_of_both_languages_and_small(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert path.stat().st_size < LARGEST
    for cell in notebook.cells:
        if cell.cell_type == "markdown" and len(cell.source) > 60:
            assert re.search("[а-яё]", cell.source), cell.source
            assert re.search("[a-z]{4}", cell.source), cell.source
        if cell.cell_type == "code":
            assert max(map(len, cell.source.splitlines())) <= 130, cell.source
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.execution_count == place for place, cell in enumerate(code, 1))
    assert sum("assert" in cell.source for cell in code) >= 1
    assert "/tmp/" not in path.read_text("utf-8")


def test_the_guide_names_each_notebook():
    assert [path.stem for path in NOTEBOOKS] == ["fuel_economy", "ignition_map", "two_cars"]
    guide = (NOTEBOOKS[0].parents[1] / "README.md").read_text("utf-8")
    assert all(f"](notebooks/{path.name})" in guide for path in NOTEBOOKS)
