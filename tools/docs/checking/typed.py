"""The Python of the guide and the examples is clean under mypy --strict and pyright.

A page's blocks are one module, each at its own lines, so that a finding names the page's line.
mypy checks examples/ with all else (pyproject.toml).
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from tools.docs.checking.finding import Finding
from tools.docs.markdown import Document
from tools.docs.pages import ROOT, document
from tools.pyright import PyrightFailed, report

PAGES = ("docs/how-to/library.md", "docs/how-to/coming-from.md")
EXAMPLES = "examples"
_ERROR = re.compile(r"(?P<file>[^:]+\.py):(?P<line>\d+): error: (?P<text>.*)")


def findings(pages: tuple[str, ...] = PAGES) -> Iterator[Finding]:
    """Yield what both type checkers say; a checker that can't say anything is a finding too."""
    with tempfile.TemporaryDirectory() as folder:
        modules = {}
        for number, page in enumerate(pages):
            module = Path(folder) / f"page_{number}.py"
            module.write_text(module_of(document(PurePosixPath(page))), "utf-8")
            modules[module.name] = PurePosixPath(page)
        files = [str(Path(folder) / name) for name in modules]
        yield from _by_mypy(files, modules)
        try:
            yield from _by_pyright(files, modules)
        except PyrightFailed as error:
            yield Finding(PurePosixPath(pages[0]), 1, f"its types were not checked: {error}")


def module_of(page: Document) -> str:
    """Return the page's Python, each line at its place; the other lines are empty."""
    lines = [""] * page.text.count("\n")
    for code in page.code:
        if code.language == "python":
            text = code.text.splitlines()
            lines[code.line : code.line + len(text)] = text
    return "\n".join(lines) + "\n"


def _by_mypy(files: list[str], modules: dict[str, PurePosixPath]) -> Iterator[Finding]:
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", *files],
        cwd=ROOT, capture_output=True, encoding="utf-8", check=False,
    )  # fmt: skip
    found = [match for line in done.stdout.splitlines() if (match := _ERROR.match(line))]
    for match in found:
        page = modules.get(Path(match["file"]).name, PurePosixPath(match["file"]))
        yield Finding(page, int(match["line"]), match["text"])
    if done.returncode and not found:
        said = " ".join((done.stdout + done.stderr).split())
        yield Finding(modules[Path(files[0]).name], 1, f"its types were not checked: {said}")


def _by_pyright(files: list[str], modules: dict[str, PurePosixPath]) -> Iterator[Finding]:
    for each in report(*files, EXAMPLES)["generalDiagnostics"]:
        if each["severity"] == "error":
            file = Path(each["file"])
            place = modules.get(file.name)
            if place is None:
                place = PurePosixPath(file.relative_to(ROOT).as_posix())
            yield Finding(place, each["range"]["start"]["line"] + 1, each["message"])
