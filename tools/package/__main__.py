"""python -m tools.package [PART…]: builds into dist/; without PART all that people install.

wheel     wheel and source distribution
program   the one-folder program, as an archive; of the wheel in dist/
deb       the Debian package; of the folder that `program` has left in build/package
sites     build/site and build/docs, as archives
sums      SHA256SUMS of all files in dist/
notes     what is new in this version, to stdout
tag TAG   nothing: fails unless TAG is that of the version in pyproject.toml
"""

from __future__ import annotations

import hashlib
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Final

from tools.package.notes import notes
from tools.package.project import DIST, Failed, check_tag

_SUMS: Final = "SHA256SUMS"


def main(arguments: Sequence[str]) -> int:
    """Build the parts; return the exit status."""
    try:
        match [*arguments]:
            case ["tag", tag]:
                check_tag(tag)
            case ["notes"]:
                print(notes(), end="")
            case parts if unknown := set(parts) - set(PARTS):
                print(f"{__doc__}\nUnknown: {' '.join(unknown)}", file=sys.stderr)
                return 2
            case parts:
                for part in parts or _of_this_system():
                    _build(part)
    except Failed as error:
        print(f"python -m tools.package: {error}", file=sys.stderr)
        return 1
    return 0


def _build(part: str) -> None:
    begun = time.monotonic()
    for path in PARTS[part]():
        size = path.stat().st_size / 1e6
        print(f"dist/{path.name}: {size:.1f} MB, {time.monotonic() - begun:.0f} s", flush=True)


def _late(module: str) -> Callable[[], list[Path]]:
    """Return the function `build` of a module, imported when it is called: for `deb` mikas has to
    be installed, and for `wheel` what builds it.
    """

    def build() -> list[Path]:
        built: list[Path] = import_module(f"tools.package.{module}").build()
        return built

    return build


def sums() -> list[Path]:
    """Write SHA256SUMS, which `sha256sum --check` reads."""
    path = DIST / _SUMS
    files = sorted(each for each in DIST.iterdir() if each.is_file() and each != path)
    lines = [f"{hashlib.sha256(each.read_bytes()).hexdigest()}  {each.name}\n" for each in files]
    path.write_text("".join(lines), "ascii", newline="\n")
    return [path]


PARTS: Final = {
    **{name: _late(name) for name in ("wheel", "program", "deb", "sites")},
    "sums": sums,
}


def _of_this_system() -> list[str]:
    debian = ["deb"] if shutil.which("dpkg-deb") else []
    return ["wheel", "program", *debian, "sums"]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
