"""licences.txt: the licences of all that the site hands out, as most of them ask for."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator
from importlib.metadata import Distribution, distribution
from pathlib import Path

from tools.site.packages import BUILT, PURE, ROOT

NAME = "licences.txt"
# Their packages have no text of it.
_ELSEWHERE = """
Pyodide {pyodide}, with CPython, its standard library and Emscripten's runtime: the files
pyodide.* and stdlib.pack.
Mozilla Public License 2.0: https://www.mozilla.org/MPL/2.0/ (CPython: PSF License,
https://docs.python.org/3/license.html). Source: https://github.com/pyodide/pyodide
"""
_PAGE = ("svelte", "uplot")
_LINE = "=" * 78
_NAMED = re.compile(r"(LICEN[CS]E|COPYING|NOTICE)", re.IGNORECASE)


def text(modules: Path) -> str:
    """Return the text; `modules`: the folder of the page's npm packages."""
    parts = [f"mikas\n\n{_read(ROOT / 'LICENSE')}"]
    parts.append(_ELSEWHERE.format(pyodide=_version(modules / "pyodide")).strip())
    for name in sorted((*PURE, BUILT)):
        installed = distribution(name)
        texts = list(licences_of(installed))
        assert texts, f"{name} has no licence"
        parts += [f"{name} {installed.version}\n\n{each}" for each in texts]
    for name in _PAGE:
        (licence,) = (modules / name).glob("LICENSE*")
        parts.append(f"{name} {_version(modules / name)}\n\n{_read(licence)}")
    return joined(parts)


def joined(parts: Iterable[str]) -> str:
    """Return one text of many."""
    return f"\n\n{_LINE}\n".join(parts) + "\n"


def licences_of(installed: Distribution) -> Iterator[str]:
    """Return the texts in the metadata of an installed package; some packages have none there."""
    for file in sorted(installed.files or ()):
        in_metadata = any(folder.endswith(".dist-info") for folder in file.parts[:-1])
        if in_metadata and (file.parent.name == "licenses" or _NAMED.match(file.name)):
            yield _read(Path(str(installed.locate_file(file))))


def _read(path: Path) -> str:
    return path.read_text("utf-8").strip()


def _version(package: Path) -> str:
    return str(json.loads((package / "package.json").read_text("utf-8"))["version"])
