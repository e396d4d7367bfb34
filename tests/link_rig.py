"""What other distributions bring: a scheme for one test, a distribution with real metadata."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

from mikas.link import urls


@contextmanager
def registered(scheme: str, opener: urls.Opener) -> Iterator[None]:
    """`scheme:` means `opener` until the end of the block."""
    entries = urls.registered() | {scheme: [SimpleNamespace(load=lambda: opener)]}
    with patch.object(urls, "registered", lambda: entries):
        yield


@contextmanager
def installed(folder: Path, distribution: str, links: dict[str, str]) -> Iterator[None]:
    """A distribution that brings these links."""
    with brought(folder, distribution, urls.GROUP, links):
        yield


@contextmanager
def brought(folder: Path, distribution: str, group: str, places: dict[str, str]) -> Iterator[None]:
    """`folder` on the module path, with the metadata that pip writes for a distribution there."""
    metadata = folder / f"{distribution}-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n", "utf-8"
    )
    entries = [f"{name} = {place}\n" for name, place in places.items()]
    (metadata / "entry_points.txt").write_text("".join([f"[{group}]\n", *entries]), "utf-8")
    sys.path.insert(0, str(folder))
    urls.registered.cache_clear()
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        urls.registered.cache_clear()
