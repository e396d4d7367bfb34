"""What a browser would load from elsewhere when it shows the site: nothing may be left.

Links that a reader may follow are no such thing. Scripts of the theme know addresses of parts that
they load on demand; the pages have none of what demands them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

_ELSEWHERE = re.compile(r"\s*(?:[a-z][a-z0-9+.-]*:)?//", re.IGNORECASE)
_LOADED = frozenset({"src", "srcset", "poster", "data", "action", "background"})
_IN_STYLE = re.compile(r"(?:url\(\s*|@import\s+)[\"']?((?:[a-z]+:)?//[^\"')\s]+)", re.IGNORECASE)
# Elements for which the theme's script loads parts, by their classes and names.
_DEMANDS = frozenset({"mermaid", "glightbox", "pyodide"})
_ASKS_THE_REPOSITORY = ("data-md-component", "source")


def loaded_from_elsewhere(site: Path) -> Iterator[str]:
    """Yield a line for each thing in a file of `site` that would be loaded from elsewhere."""
    for path in sorted(site.rglob("*")):
        name = path.relative_to(site).as_posix()
        if path.suffix in (".html", ".svg"):
            text = path.read_text("utf-8")
            elements = _Elements()
            elements.feed(text)
            found = [*elements.found, *_IN_STYLE.findall(text)]
        elif path.suffix == ".css":
            found = _IN_STYLE.findall(path.read_text("utf-8"))
        else:
            continue
        yield from (f"{name}: {each}" for each in found)


class _Elements(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if _DEMANDS.intersection((dict(attrs).get("class") or "").split()):
            self.found.append(f"<{tag} class={dict(attrs)['class']}>")
        if _ASKS_THE_REPOSITORY in attrs:
            self.found.append(f"<{tag}> of the repository")
        for name, value in attrs:
            loads = name in _LOADED or (tag in ("link", "use", "image") and name.endswith("href"))
            if loads and value and _ELSEWHERE.match(value):
                self.found.append(f"<{tag} {name}={value}>")
