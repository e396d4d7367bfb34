"""The environment that the program is made of: the wheel, its packages by the lock, PyInstaller."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Final

from tools.package.project import BUILD, ROOT
from tools.package.wheel import wheel

_WHEELHOUSE: Final = BUILD / "wheelhouse"
_ENVIRONMENT: Final = BUILD / "environment"
_INSTALL: Final = ROOT / "requirements" / "install.py"

EXTRAS: Final = ("export", "fleet", "mqtt")
"""Whoever has the program alone can add nothing to it. What needs a notebook (plot), a cluster
(dask) or an object store (s3) is for people with a Python, and is left out."""


def python() -> Path:
    """Return the Python of the environment, with the present wheel."""
    programs = _ENVIRONMENT / ("Scripts" if sys.platform == "win32" else "bin")
    found = programs / ("python.exe" if sys.platform == "win32" else "python")
    if not _is_current(_ENVIRONMENT):
        _run(sys.executable, "-m", "venv", "--clear", str(_ENVIRONMENT))
        _run(str(found), str(_INSTALL), *EXTRAS, "package")
        _mark(_ENVIRONMENT)
    pip = (str(found), "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
    _run(*pip, "--no-deps", "--no-index", "--force-reinstall", str(wheel()))
    return found


def wheelhouse() -> Path:
    """Return the folder of all packages of the environment; filled anew when the lock has changed.

    What installs from it needs no network (tests/installing).
    """
    if not _is_current(_WHEELHOUSE):
        shutil.rmtree(_WHEELHOUSE, ignore_errors=True)
        _WHEELHOUSE.mkdir(parents=True)
        # The environment's pip, for others may know neither groups nor these hashes.
        _run(str(python()), str(_INSTALL), f"--download={_WHEELHOUSE}", *EXTRAS, "package")
        _mark(_WHEELHOUSE)
    return _WHEELHOUSE


def _run(*command: str) -> None:
    subprocess.run(command, cwd=ROOT, env=variables(), check=True)


def variables() -> dict[str, str]:
    """Return the variables of this process without those that lead to other packages."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def _digest() -> str:
    digest = hashlib.sha256(repr((sys.version, sys.prefix, EXTRAS)).encode())
    for file in (ROOT / "pyproject.toml", ROOT / "requirements" / "lock.txt"):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def _is_current(folder: Path) -> bool:
    mark = folder / "made-for"
    return mark.is_file() and mark.read_text("ascii") == _digest()


def _mark(folder: Path) -> None:
    (folder / "made-for").write_text(_digest(), "ascii")
