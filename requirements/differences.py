"""Print each package of this environment that has another version than the lock.

python requirements/differences.py
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from importlib.metadata import distributions
from pathlib import Path
from typing import Final

LOCK: Final = Path(__file__).with_name("lock.txt")
_PIN: Final = re.compile(r"^([\w.-]+)==(\S+)", re.MULTILINE)


def differences(lock: str, installed: dict[str, str]) -> Iterator[str]:
    """Yield a line for each package with another version; one may be locked in several."""
    locked: dict[str, set[str]] = {}
    for name, version in _PIN.findall(lock):
        locked.setdefault(name, set()).add(version)
    for name, version in sorted(installed.items()):
        known = locked.get(name)
        if known and version not in known:
            yield f"{name} {' or '.join(sorted(known))} -> {version}"
        elif not known and name not in ("mikas", "setuptools"):
            yield f"{name} {version} (new)"


def main() -> int:
    """Print the lines; return 0."""
    installed = {
        re.sub("[-_.]+", "-", it.metadata["Name"]).lower(): it.version for it in distributions()
    }
    for line in differences(LOCK.read_text(encoding="utf-8"), installed):
        print(line)
    return 0


if __name__ == "__main__":
    sys.exit(main())
