"""notices.txt: the licences of all that the one-folder program holds, as most of them ask for.

What is there is known from where each file came from: an installed package, the installation of
Python, or a package of Debian. Runs in the environment of the program, as a part of PyInstaller.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Sequence
from importlib.metadata import Distribution, distribution, distributions
from pathlib import Path
from typing import Final

from tools.site.licences import joined, licences_of

NAME: Final = "notices.txt"
_LINE: Final = "The licences of all that this program holds. Its own source: {source}"
_PYTHON: Final = "Python {version}\n\n{text}"
_STATED: Final = "{name} {version}\n\nIts package states: {licence}. {home}"
_COPYLEFT: Final = (
    "This program may be changed and built again with another version of this library: its source "
    "has what is needed (make package)."
)


def notices(files: Iterable[Path]) -> str:
    """Return the text for a program made of `files`."""
    packages: dict[str, Distribution] = {}
    others: set[Path] = set()
    owners, python = _owners(), Path(sys.base_prefix).resolve()
    for file in files:
        path = file.resolve()
        if (owner := owners.get(path)) is not None:
            packages[owner.name] = owner
        elif ".so" in path.suffixes and not path.is_relative_to(python):
            others.add(path)
    packages["pyinstaller"] = distribution("pyinstaller")  # the beginning of the program is its
    own = packages.pop("mikas")
    parts = [_LINE.format(source=_home(own)), _of(own), _of_python()]
    parts += [_of(packages[name]) for name in sorted(packages, key=str.lower)]
    return joined([*parts, *_of_system(sorted(others))])


def _owners() -> dict[Path, Distribution]:
    """Return which package a file of this environment belongs to."""
    return {
        Path(str(installed.locate_file(file))).resolve(): installed
        for installed in distributions()
        for file in installed.files or ()
    }


def _of(installed: Distribution) -> str:
    name, version = installed.name, installed.version
    stated = _field(installed, "License-Expression") or _field(installed, "License")
    texts = list(licences_of(installed))
    if not texts:
        texts = [_STATED.format(name=name, version=version, licence=stated, home=_home(installed))]
    elif "LGPL" in stated:
        texts.insert(0, _COPYLEFT)
    return "\n\n".join([f"{name} {version}", *texts])


def _home(installed: Distribution) -> str:
    urls = installed.metadata.get_all("Project-URL") or []
    home = [each.partition(", ")[2] for each in urls if each.lower().startswith("homepage")]
    return next(iter(home), _field(installed, "Home-page"))


def _field(installed: Distribution, name: str) -> str:
    return next(iter(installed.metadata.get_all(name) or []), "")


def _of_python() -> str:
    version = sys.version.split()[0]
    folder = Path(sys.base_prefix)
    for place in (folder, *sorted(folder.glob("lib/python3*")), *folder.glob("share/doc/python3*")):
        for name in ("LICENSE.txt", "LICENSE", "copyright"):
            if (place / name).is_file():
                text = (place / name).read_text("utf-8", "replace")
                return _PYTHON.format(version=version, text=text)
    text = "PSF License: https://docs.python.org/3/license.html"
    return _PYTHON.format(version=version, text=text)


def _of_system(files: Sequence[Path]) -> list[str]:
    """Return the licences of Debian's packages that `files` are of; elsewhere none is known."""
    if shutil.which("dpkg-query") is None:
        return []
    found: dict[str, str] = {}
    for file in files:
        # Where / and /usr are merged, the package may know the file by the shorter name.
        for path in (file, Path("/", *file.parts[2:])):
            asked = subprocess.run(
                ["dpkg-query", "--search", str(path)], capture_output=True, text=True, check=False
            )
            if owner := re.match(r"([a-z0-9.+-]+)(:\w+)?: ", asked.stdout):
                text = Path("/usr/share/doc", owner[1], "copyright")
                found[owner[1]] = text.read_text("utf-8", "replace") if text.is_file() else ""
                break
    return [f"{name} (Debian)\n\n{text.strip()}" for name, text in sorted(found.items())]
