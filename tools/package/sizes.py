"""python -m tools.package.sizes: the megabytes that the packages take, for docs/how-to/install.md.

Counted are the files of the locked packages in this environment, as pip has installed them, with
their compiled modules. Run it after a change of the dependencies, with the
page built (`make page`).
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import cache_from_source, find_spec
from pathlib import Path
from typing import Final

import tomlkit
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tools.docs.pages import ROOT

MEASURED: Final = ROOT / "tools/docs/generated/texts/sizes.toml"
_MEGA: Final = 1_000_000


def dependencies(extra: str = "") -> list[str]:
    """Return the names of the packages that pyproject.toml names, with those of an extra."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    wanted, found = list(project["dependencies"]), []
    extras = [extra] if extra else []
    while extras:
        wanted += project["optional-dependencies"][extras.pop()]
    for each in map(Requirement, wanted):
        if each.name == "mikas":
            for inner in sorted(each.extras):
                found += [name for name in dependencies(inner) if name not in found]
        elif (name := canonicalize_name(each.name)) not in found:
            found.append(name)
    return sorted(found)


def closure(names: Iterable[str]) -> set[str]:
    """Return these packages with all that they need here."""
    found: set[str] = set()
    waiting = list(names)
    while waiting:
        name = canonicalize_name(waiting.pop())
        if name in found:
            continue
        try:
            needs = distribution(name).requires or []
        except PackageNotFoundError:
            continue  # of another system
        found.add(name)
        waiting += [
            need.name
            for need in map(Requirement, needs)
            if need.marker is None or need.marker.evaluate({"extra": ""})
        ]
    return found


def size_of(name: str) -> int:
    """Return the bytes of a package's files, with the compiled modules."""
    paths = {Path(str(file.locate())) for file in distribution(name).files or ()}
    paths |= {Path(cache_from_source(str(path))) for path in paths if path.suffix == ".py"}
    return sum(path.stat().st_size for path in paths if path.is_file())


def own_size() -> int:
    """Return the bytes of mikas, as the wheel has it."""
    spec = find_spec("mikas")
    if spec is None or spec.origin is None:
        raise SystemExit("mikas is not installed")
    home = Path(spec.origin).parent
    if not (home / "dashboard/page/index.html").is_file():
        raise SystemExit("the page is not built: make page")
    files = (path for path in home.rglob("*") if path.is_file())
    of_the_site = home / "browser"
    return sum(path.stat().st_size for path in files if of_the_site not in path.parents)


def megabytes(size: int) -> float:
    """Return the size in megabytes, in three digits at most."""
    return round(size / _MEGA, 1) if size < 10 * _MEGA else float(round(size / _MEGA))


def main() -> int:
    """Measure, and write the figures."""
    base = dependencies()
    needed, all_exports = closure(base), closure(dependencies("export"))
    own = own_size()
    total = own + sum(map(size_of, needed))
    measured = {
        "mikas": megabytes(own),
        "total": round(total / _MEGA),
        "with_exports": round((total + sum(map(size_of, all_exports - needed))) / _MEGA),
        "needed": len(needed - set(base)),
        "packages": {name: megabytes(size_of(name)) for name in base},
    }
    text = f"# {re.sub(':.*', '', (__doc__ or '').splitlines()[0])}\n{tomlkit.dumps(measured)}"
    MEASURED.write_text(text, "utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
