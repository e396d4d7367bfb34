"""The documents name files that exist."""

from __future__ import annotations

import re
from pathlib import Path
from pkgutil import resolve_name

import pytest

REPOSITORY = Path(__file__).parents[1]
DOCUMENTS = ("CONTRIBUTING.md", "SECURITY.md", "README.md", *sorted(
    path.relative_to(REPOSITORY).as_posix() for path in (REPOSITORY / "docs").rglob("*.md")
))  # fmt: skip
ROOTS = (
    "src/|tests/|docs/|bench/|fuzz/|site_build/|examples/|web/|changes/"
    "|\\.ci/|\\.github/|\\.importlinter"
)
OTHER_NAMES = {"mikas.links", "mikas.rules"}  # the group of entry points; udev's 70-mikas.rules
PLACEHOLDER = re.compile(r"[A-Z]{3,}|…")  # web/src/screens/NAME/Screen.svelte


def links(text: str) -> list[str]:
    """Targets of Markdown links and pictures inside the repository."""
    found = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text)
    return [link for link in found if not re.match(r"[a-z]+:", link)]


def paths(text: str) -> list[str]:
    """Words in backticks that begin with a folder of the repository."""
    return re.findall(rf"`((?:{ROOTS})[^`\s]*)`", text)


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_link_leads_somewhere(name):
    document = REPOSITORY / name
    broken = [
        link for link in links(document.read_text("utf-8")) if not (document.parent / link).exists()
    ]
    assert broken == []


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_path_exists(name):
    named = paths((REPOSITORY / name).read_text("utf-8"))
    missing = [
        path
        for path in named
        if not PLACEHOLDER.search(path) and not list(REPOSITORY.glob(path.rstrip("/")))
    ]
    assert missing == []


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_python_name_exists(name):
    named = set(re.findall(r"\bmikas(?:\.[A-Za-z_]\w*)+", (REPOSITORY / name).read_text("utf-8")))
    assert [each for each in sorted(named - OTHER_NAMES) if not exists(each)] == []


def exists(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    try:
        resolve_name(name)
    except (ImportError, AttributeError):
        return False
    return True


def test_the_paths_are_found():
    assert paths("see `src/mikas/link/`, `tests/x.py` and `mikas read`") == [
        "src/mikas/link/",
        "tests/x.py",
    ]
    assert links("[a](b.md#c) ![d](e/f.png) [g](https://h)") == ["b.md", "e/f.png"]
