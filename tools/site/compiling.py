"""Bytecode by the Python that will run it.

Compiling takes twelve of the fifteen seconds that a start from sources takes in a browser. The
bytecode is unchecked: it holds a hash of its source instead of a time, and is never compared with
a source, because there is none.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Set
from pathlib import Path

from tools.site import pyodide
from tools.site.archives import files_of, zip_of

# Columns of the lines would be an eighth of all.
_OPTIONS: dict[str, object] = {"args": ["-X", "no_debug_ranges"]}


def compiled(
    files: Mapping[str, bytes],
    by: Path,
    *,
    stays_source: Set[str] = frozenset(),
    stripped: bool,
) -> dict[str, bytes]:
    """Return `files` with `a.pyc` instead of `a.py`; others, and `stays_source`, as they are.

    `by`: the folder of Pyodide. `stripped`: without docstrings and assertions.
    """
    sources = {
        name: content
        for name, content in files.items()
        if name.endswith(".py") and name not in stays_source
    }
    with tempfile.TemporaryDirectory(prefix="mikas-site-") as name:
        folder = Path(name)
        (folder / "sources.zip").write_bytes(zip_of(sources))
        pyodide.call(
            "compile_archive",
            "/folder/sources.zip",
            "/folder/bytecode.zip",
            2 if stripped else 0,
            folder=folder,
            pyodide=by,
            options=_OPTIONS,
        )
        bytecode = files_of((folder / "bytecode.zip").read_bytes())
    return {name: content for name, content in files.items() if name not in sources} | bytecode
