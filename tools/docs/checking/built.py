"""Every link of the built site leads to a page, a file or an anchor that is there."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

from tools.docs.checking.finding import Finding


def findings(site: Path) -> Iterator[Finding]:
    """Yield the links of the pages of `site` that lead nowhere, once for each page and target."""
    for page in sorted(site.rglob("*.html")):
        name = PurePosixPath(page.relative_to(site).as_posix())
        seen: set[str] = set()
        for line, target in _parts(page).targets:
            if target not in seen:
                seen.add(target)
                if problem := _problem(site, page, target):
                    yield Finding("build/docs" / name, line, f"{target}: {problem}")


def _problem(site: Path, page: Path, target: str) -> str:
    parts = urlsplit(target)
    if parts.scheme or parts.netloc:
        return ""
    if parts.path.startswith("/"):
        return "does not work below another address"
    path = unquote(parts.path)
    place = Path(os.path.normpath(page.parent / path)) if path else page
    if not place.is_relative_to(site):
        return "leads out of the site"
    if place.is_dir() or not place.exists():
        return "no such file"
    anchor = unquote(parts.fragment)
    if anchor and place.suffix == ".html" and anchor not in _parts(place).anchors:
        return "no such anchor"
    return ""


class _Parts(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.targets: list[tuple[int, str]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if not value:
                continue
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif name in ("href", "src") and value != "#":
                self.targets.append((self.getpos()[0], value))


@cache
def _parts(page: Path) -> _Parts:
    parts = _Parts()
    parts.feed(page.read_text("utf-8"))
    return parts
