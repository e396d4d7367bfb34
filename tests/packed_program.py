"""The program, pytest and tests as an archive, for the Python of a browser."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from zipfile import ZipFile

from tools.site.packages import own

from mikas import testing

PYTEST = ("pytest", "_pytest", "iniconfig", "packaging", "pluggy", "pygments")


def pack(file: Path, *tests: Path) -> None:
    """Write the archive; each of `tests` is a module in it by its own name."""
    with ZipFile(file, "w") as archive:
        for name, content in own().items():
            archive.writestr(name, content)
        for package in (Path(find_spec(name).origin).parent for name in PYTEST):
            for each in package.rglob("*.py"):
                archive.write(each, Path(package.name) / each.relative_to(package))
        archive.write(find_spec("py").origin, "py.py")  # pytest's own
        for each in Path(testing.__file__).parent.glob("*.py"):  # which the site does not have
            archive.write(each, Path("mikas", "testing", each.name))
        for each in tests:
            archive.write(each, each.name)
