"""The site without installation and the documentation, as archives for any web server."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Final

from tools.package.project import DIST, ROOT, Failed, version

_FOLDERS: Final = {"site": ROOT / "build" / "site", "docs": ROOT / "build" / "docs"}


def build() -> list[Path]:
    """Pack both; `make site` and `make docs` have built them."""
    packed = []
    for name, folder in _FOLDERS.items():
        if not folder.is_dir():
            raise Failed(f"there is no {folder.relative_to(ROOT)}; build it first: make {name}")
        path = DIST / f"mikas-{version()}-{name}.zip"
        DIST.mkdir(exist_ok=True)
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(folder.rglob("*")):
                archive.write(file, file.relative_to(folder))
        packed.append(path)
    return packed
