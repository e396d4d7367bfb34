"""What `make package` has built: sizes, and how long the program in one folder takes to start.

Where nothing was built yet, it is built, which needs a network once.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from tools.package import deb, program, wheel
from tools.package.project import DIST

from bench.rows import Row, Scope, Theme, timed

_MB = 1e6


def run(scope: Scope) -> Iterator[Theme]:
    if not program.FOLDER.is_dir():
        wheel.build()
        program.build()
    if not [*DIST.glob("*.deb")] and shutil.which("dpkg-deb"):
        deb.build()
    starts = timed(_start, scope.of(11, 3))
    inside = [
        each for each in program.FOLDER.rglob("*") if each.is_file() and not each.is_symlink()
    ]
    built = {
        "The wheel": [wheel.wheel()],
        "The program in one folder, packed": [*DIST.glob("mikas-*-linux-*")],
        "The Debian package": [*DIST.glob("*.deb")],
        "The folder, on the disk": inside,
    }
    rows = [Row(what, [_size(files)], "MB", 1) for what, files in built.items() if files]
    how = "of the one folder, a whole process with an empty environment."
    rows.append(Row("`mikas --help`", starts, "s", 2, at_most=0.3, how=how))
    yield Theme("Installed", "The files as `make package` has built them.", rows)


def _size(files: list[Path]) -> float:
    return sum(file.stat().st_size for file in files) / _MB


def _start() -> None:
    command = [str(program.FOLDER / "mikas"), "--help"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env={})
