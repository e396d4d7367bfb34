"""Run pyright, with the version and the checksum that web/package-lock.json has.

It is a part of every check that calls it: one that is missing fails the check, and is not skipped.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from tools.docs.pages import ROOT

_LOCKED = ROOT / "web/node_modules/.bin/pyright"


class PyrightFailed(Exception):
    """pyright is missing or gave no report; the message says which."""


def report(*arguments: str) -> dict[str, Any]:
    """Return pyright's report. `PYRIGHT` names another pyright than the locked one."""
    program = os.environ.get("PYRIGHT") or str(_LOCKED)
    # Node and the Python with mikas are both beside this Python. Not by --pythonpath: with it
    # pyright finds no py.typed of an editable installation.
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    found = shutil.which(program, path=path)
    if found is None:
        raise PyrightFailed(f"{program} is missing: npm --prefix web ci")
    done = subprocess.run(
        [found, "--outputjson", *arguments],
        capture_output=True,
        encoding="utf-8",
        check=False,
        cwd=ROOT,
        env={**os.environ, "PATH": path},
    )
    try:
        parsed: dict[str, Any] = json.loads(done.stdout)
    except ValueError:
        raise PyrightFailed(f"pyright gave no report: {done.stdout}{done.stderr}") from None
    return parsed
