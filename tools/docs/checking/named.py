"""Every path and every name of Python in a document exists; files of a release are of this one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import PurePosixPath
from pkgutil import resolve_name

import mikas
from mikas.catalog import shipped
from tools.docs.checking.finding import Finding
from tools.docs.pages import ROOT, document

_ROOTS = (
    "src/|tests/|docs/|bench/|fuzz/|tools/|examples/|web/|changes/"
    r"|requirements/|\.ci/|\.github/|\.importlinter"
)
_PATH = re.compile(rf"`((?:{_ROOTS})[^`\s]*)`")
_NAME = re.compile(r"\bmikas(?:\.[A-Za-z_]\w*)+")
# The groups of entry points; udev's 70-mikas.rules; Wireshark's plugin; fish's completion; programs
# of Windows and macOS.
_OTHER_NAMES = frozenset(
    {
        "mikas.app",
        "mikas.exe",
        "mikas.exports",
        "mikas.fish",
        "mikas.links",
        "mikas.rules",
        "mikas.lua",
    }
)
_RELEASED = re.compile(r"\bmikas[-_](\d+\.\d+\.\d+(?:(?:a|b|rc)\d+)?)")
_WIRESHARK = "src/mikas/dissectors/wireshark"
_PLACEHOLDER = re.compile(r"[A-Z]{3,}|…")  # web/src/screens/NAME/Screen.svelte


def findings(file: PurePosixPath) -> Iterator[Finding]:
    """Yield what `file` names and what does not exist."""
    for number, line in enumerate(document(file).text.splitlines(), 1):
        for path in _PATH.findall(line):
            if not _PLACEHOLDER.search(path) and not exists_in_repository(path):
                yield Finding(file, number, f"{path}: no such file")
        for version in _RELEASED.findall(line):
            if version != mikas.__version__:
                yield Finding(file, number, f"{version}: the version is {mikas.__version__}")
        for name in _NAME.findall(line):
            others = _OTHER_NAMES | fields_of_wireshark()
            if name not in others and not exists_in_python(name):
                yield Finding(file, number, f"{name}: no such name")


@cache
def exists_in_repository(path: str) -> bool:
    """Whether a path, which may be a pattern, names a file or folder."""
    return any(ROOT.glob(path.rstrip("/")))


@cache
def exists_in_python(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    try:
        resolve_name(name)
    except (ImportError, AttributeError):
        return False
    return True


@cache
def fields_of_wireshark() -> frozenset[str]:
    """Return the fields of the dissector, which begin with the protocol's name as ours do."""
    scripts = "".join(path.read_text("utf-8") for path in (ROOT / _WIRESHARK).glob("*.lua"))
    parameters = (f"mikas.param.{each.name}" for each in shipped().parameters)
    return frozenset([*re.findall(r'"(mikas\.[\w.]+)"', scripts), *parameters])
