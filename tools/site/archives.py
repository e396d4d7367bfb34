"""Archives whose bytes depend on nothing but the names and contents of their files."""

from __future__ import annotations

import gzip
import io
import zipfile
from collections.abc import Mapping

# The earliest time that a ZIP archive can hold.
_TIME = (1980, 1, 1, 0, 0, 0)


def zip_of(files: Mapping[str, bytes]) -> bytes:
    """Return a ZIP archive of `files`, uncompressed, in the order of their names."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as writer:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _TIME)
            entry.create_system = 3  # the same on Windows
            entry.external_attr = 0o644 << 16
            writer.writestr(entry, files[name], zipfile.ZIP_STORED)
    return archive.getvalue()


def files_of(archive: bytes) -> dict[str, bytes]:
    """Return the files of a ZIP archive, without its folders."""
    with zipfile.ZipFile(io.BytesIO(archive)) as reader:
        return {name: reader.read(name) for name in reader.namelist() if not name.endswith("/")}


def compressed(content: bytes) -> bytes:
    """Return `content` compressed by gzip, as a web server sends it."""
    return gzip.compress(content, 9, mtime=0)


def sizes_of(content: bytes) -> dict[str, int]:
    """Return the size of a file, bare and as a web server sends it: never more than bare."""
    return {"bytes": len(content), "compressed": min(len(content), len(compressed(content)))}
