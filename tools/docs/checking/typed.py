"""The Python of the guide and the examples is clean under mypy --strict and pyright.

A page's blocks are one module, each at its own lines, so that a finding names the page's line.
mypy checks examples/ with all else (pyproject.toml).
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from tools.docs.checking.finding import Finding
from tools.docs.markdown import Document
from tools.docs.pages import ROOT, document

PAGES = ("docs/how-to/library.md", "docs/how-to/coming-from.md")
EXAMPLES = "examples"
PYRIGHT = ROOT / "web/node_modules/.bin/pyright"
_ERROR = re.compile(r"(?P<file>[^:]+\.py):(?P<line>\d+): error: (?P<text>.*)")


def findings(pages: tuple[str, ...] = PAGES) -> Iterator[Finding]:
    """Yield what the type checkers say. pyright is that of `make check`."""
    with tempfile.TemporaryDirectory() as folder:
        modules = {}
        for number, page in enumerate(pages):
            module = Path(folder) / f"page_{number}.py"
            module.write_text(module_of(document(PurePosixPath(page))), "utf-8")
            modules[module.name] = PurePosixPath(page)
        files = [str(Path(folder) / name) for name in modules]
        for line in _printed(sys.executable, "-m", "mypy", "--strict", *files).splitlines():
            if match := _ERROR.match(line):
                page_of = modules[Path(match["file"]).name]
                yield Finding(page_of, int(match["line"]), match["text"])
        if PYRIGHT.exists():
            yield from _by_pyright(files, modules)


def module_of(page: Document) -> str:
    """Return the page's Python, each line at its place; the other lines are empty."""
    lines = [""] * page.text.count("\n")
    for code in page.code:
        if code.language == "python":
            text = code.text.splitlines()
            lines[code.line : code.line + len(text)] = text
    return "\n".join(lines) + "\n"


def _by_pyright(files: list[str], modules: dict[str, PurePosixPath]) -> Iterator[Finding]:
    printed = _printed(
        str(PYRIGHT), "--outputjson", "--pythonpath", sys.executable, *files, EXAMPLES
    )
    for each in json.loads(printed)["generalDiagnostics"]:
        if each["severity"] == "error":
            file = Path(each["file"])
            place = modules.get(file.name)
            if place is None:
                place = PurePosixPath(file.relative_to(ROOT).as_posix())
            yield Finding(place, each["range"]["start"]["line"] + 1, each["message"])


def _printed(*command: str) -> str:
    done = subprocess.run(
        command, cwd=ROOT, stdout=subprocess.PIPE, encoding="utf-8", check=False
    )  # fmt: skip
    return done.stdout
