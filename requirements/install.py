"""Install what the lock has into the environment of this Python, hashes checked.

python requirements/install.py mikas test    the project (editable), and the group `test`
python requirements/install.py check         a group of pyproject.toml alone
python requirements/install.py export        the requirements of the project with this extra, and
                                             not the project: for a list of parts
python requirements/install.py extras        the same with all extras
python requirements/install.py --download=FOLDER export    the same, only downloaded
python requirements/install.py --newest mikas extras test    without the lock: the newest releases
                                             that pyproject.toml allows; --pre: pre-releases, too

pip can't hold the lock against a project that it builds, so the project's requirements and what
builds it are installed first, and then the project without them.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

HERE: Final = Path(__file__).resolve().parent
LOCK: Final = HERE / "lock.txt"
_PROJECT: Final = "mikas"
_PIP: Final = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")
_ALL: Final = "extras"
_DOWNLOAD: Final = "--download="
_NEWEST: Final = "--newest"
_PRE: Final = "--pre"
_UPGRADE: Final = "--upgrade"
_LOCKED: Final = ("--require-hashes", "--constraint", str(LOCK))


def main(arguments: Sequence[str]) -> int:
    """Install the parts; return the exit status of the first pip that failed, or 0."""
    options = {_NEWEST, _PRE} & set(arguments)
    parts = [it for it in arguments if it not in options and not it.startswith(_DOWNLOAD)]
    folders = [each.removeprefix(_DOWNLOAD) for each in arguments if each.startswith(_DOWNLOAD)]
    do = ["download", f"--dest={folders[-1]}"] if folders else ["install"]
    text = (HERE.parent / "pyproject.toml").read_text(encoding="utf-8")
    pyproject = tomllib.loads(text)
    groups, extras = pyproject["dependency-groups"], pyproject["project"]["optional-dependencies"]
    if _ALL in parts:
        parts = [*extras, *(each for each in parts if each != _ALL)]
    unknown = set(parts) - {_PROJECT, *groups, *extras}
    if unknown or not parts:
        known = ", ".join([_PROJECT, _ALL, *groups, *extras])
        print(f"{__doc__}\nUnknown: {', '.join(unknown)}. Known: {known}", file=sys.stderr)
        return 2
    requirements = [r for part in parts if part in extras for r in _of_extra(extras, part)]
    if requirements or _PROJECT in parts:
        requirements += pyproject["project"]["dependencies"]
    wanted = [part for part in parts if part in groups] + ["build"] * (_PROJECT in parts)
    with tempfile.TemporaryDirectory() as folder:
        # First pip itself: that of a new environment may know neither groups nor these hashes.
        pip = _requirements(folder, "pip.txt", _locked_pip())
        commands = [["--require-hashes", *pip]]
        how = [_UPGRADE, *({_PRE} & options)] if options else _LOCKED
        others = _requirements(folder, "requirements.txt", "\n".join(requirements))
        commands.append([*how, *others, *(f"--group={group}" for group in wanted)])
        if _PROJECT in parts:
            commands.append(["--no-deps", "--no-build-isolation", "--editable", "."])
        for command in commands:
            done = subprocess.run([*_PIP, *do, *command], cwd=HERE.parent, check=False)
            if done.returncode:
                return done.returncode
    return 0


def _requirements(folder: str, name: str, text: str) -> list[str]:
    """Return pip's options for a file of requirements; none for no requirements."""
    path = Path(folder, name)
    path.write_text(text, encoding="utf-8")
    return ["--requirement", str(path)] if text else []


def _locked_pip() -> str:
    """Return pip's lines of the lock."""
    match = re.search(r"^pip==(.*\\\n)*.*\n", LOCK.read_text(encoding="utf-8"), re.MULTILINE)
    assert match
    return match[0]


def _of_extra(extras: dict[str, list[str]], name: str) -> Iterator[str]:
    for requirement in extras[name]:
        inner = re.fullmatch(rf"{_PROJECT}\[(.*)\]", requirement)
        if inner:
            for part in inner[1].split(","):
                yield from _of_extra(extras, part)
        else:
            yield requirement


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
