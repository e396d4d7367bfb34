"""The guide to the library runs, in both languages, and its tests pass under pytest."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import PurePosixPath

import pytest
from tools.docs.checking import examples, typed
from tools.docs.markdown import Document
from tools.docs.pages import document

PAGES = [
    f"docs/{language}how-to/{page}.md"
    for page in ("library", "coming-from")
    for language in ("", "ru/")
]


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    file = tmp_path_factory.mktemp("recorded") / "drive.pcapng"
    examples.recording(file)
    return file


@pytest.fixture
def mark(request):
    """The mark of the plugin, where mikas is not installed as a package."""
    request.config.addinivalue_line("markers", "mikas_car(**options): as of the plugin")


@pytest.mark.usefixtures("mark")
@pytest.mark.parametrize("page", PAGES)
def test_every_example_runs(page, drive):
    file = PurePosixPath(page)
    blocks = [each for each in document(file).code if each.language == "python"]
    assert len(blocks) >= 5
    assert not any("no-run" in each.info for each in blocks)
    assert examples.findings(file, drive) == []


def test_type_checkers_see_its_python_at_the_lines_of_the_page():
    page = Document("# a\n\n```python\nx = 1\n\ny: str = x\n```\n```toml\n```\n")
    assert typed.module_of(page).splitlines()[3:6] == ["x = 1", "", "y: str = x"]
    for name in typed.PAGES:
        page = document(PurePosixPath(name))
        module, lines = typed.module_of(page).splitlines(), page.text.splitlines()
        assert all(here in ("", there) for here, there in zip(module, lines, strict=False))
        assert sum(map(bool, module)) > 20


def test_a_type_checker_that_is_missing_is_a_finding(monkeypatch):
    monkeypatch.setenv("PYRIGHT", "no-such-pyright")
    monkeypatch.setattr(typed, "_by_mypy", lambda files, modules: iter(()))
    (found,) = typed.findings()
    assert "no-such-pyright is missing: npm" in found.text


def test_a_type_checker_that_gives_no_report_is_a_finding(monkeypatch):
    monkeypatch.setenv("PYRIGHT", sys.executable)  # it knows no --outputjson
    monkeypatch.setattr(sys, "executable", shutil.which("git"))  # nor -m
    found = list(typed.findings())
    assert len(found) == 2
    assert all("its types were not checked" in each.text for each in found)


def test_its_tests_pass(tmp_path):
    (block,) = (
        each.text
        for each in document(PurePosixPath(PAGES[0])).code
        if each.language == "python" and "\ndef test_" in each.text
    )
    (tmp_path / "test_guide.py").write_text(block, "utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-W", "error", "--strict-markers",
         "-p", "mikas.testing.plugin", "-p", "no:cacheprovider", str(tmp_path)],
        capture_output=True, text=True, cwd=tmp_path, check=False,
        env={**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
    )  # fmt: skip
    assert "1 passed" in done.stdout, done.stdout + done.stderr
