"""licences.txt: the licences of all that the site hands out, as most of them ask for."""

from __future__ import annotations

import json
from collections.abc import Iterator
from importlib.metadata import distribution
from pathlib import Path

from site_build.packages import BUILT, PURE, ROOT

NAME = "licences.txt"
# Their packages have no text of it.
_ELSEWHERE = """
Pyodide {pyodide}, with CPython, its standard library and Emscripten's runtime: the files
pyodide.* and stdlib.zip.
Mozilla Public License 2.0: https://www.mozilla.org/MPL/2.0/ (CPython: PSF License,
https://docs.python.org/3/license.html). Source: https://github.com/pyodide/pyodide
"""
_PAGE = ("svelte", "uplot")
_LINE = "=" * 78


def text(modules: Path) -> str:
    """Return the text; `modules`: the folder of the page's npm packages."""
    parts = [f"mikas\n\n{_read(ROOT / 'LICENSE')}"]
    parts.append(_ELSEWHERE.format(pyodide=_version(modules / "pyodide")).strip())
    for name in sorted((*PURE, BUILT)):
        parts += [f"{name} {distribution(name).version}\n\n{each}" for each in _of(name)]
    for name in _PAGE:
        (licence,) = (modules / name).glob("LICENSE*")
        parts.append(f"{name} {_version(modules / name)}\n\n{_read(licence)}")
    return f"\n\n{_LINE}\n".join(parts) + "\n"


def _of(name: str) -> Iterator[str]:
    installed = distribution(name)
    found = [
        Path(str(installed.locate_file(file)))
        for file in installed.files or ()
        if file.parent.name == "licenses"
    ]
    assert found, f"{name} has no licence"
    yield from (_read(path) for path in sorted(found))


def _read(path: Path) -> str:
    return path.read_text("utf-8").strip()


def _version(package: Path) -> str:
    return str(json.loads((package / "package.json").read_text("utf-8"))["version"])
