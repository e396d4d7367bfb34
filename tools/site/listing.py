"""files.json: what the site consists of, for its progress bar and its service worker.

    {"version": "…", "files": [{"path", "bytes", "compressed", "sha256"}, …]}

`version` is of all files together; the service worker has it too, so that a browser sees a new one
as soon as any file has changed. `compressed`: as a web server sends the file.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path

from tools.site.archives import sizes_of

NAME = "files.json"
WORKER = "service-worker.js"
# Stands in the service worker's script until the version is known.
PLACEHOLDER = b"MIKAS_SITE_VERSION"


@dataclass(frozen=True, slots=True)
class File:
    """A file of the site."""

    path: str
    bytes: int
    compressed: int
    sha256: str


def complete(site: Path) -> list[File]:
    """Give the service worker its version, write files.json, and return all files but that."""
    worker = site / WORKER
    others = [path for path in sorted(site.rglob("*")) if path.is_file() and path != worker]
    files = [_file(site, path) for path in others]
    described = "".join(f"{file.path}\0{file.sha256}\n" for file in files).encode()
    script = worker.read_bytes()
    version = hashlib.sha256(described + script).hexdigest()[:16]
    worker.write_bytes(script.replace(PLACEHOLDER, version.encode()))
    files.append(_file(site, worker))
    listed = {"version": version, "files": [asdict(file) for file in files]}
    (site / NAME).write_text(json.dumps(listed, indent=1) + "\n", "utf-8", newline="\n")
    return files


def _file(site: Path, path: Path) -> File:
    content = path.read_bytes()
    return File(
        path=path.relative_to(site).as_posix(),
        **sizes_of(content),
        sha256=hashlib.sha256(content).hexdigest(),
    )
