"""One language's pages in a folder, as Zensical takes them: Markdown, pictures, a configuration.

A link to a page leads to that page in the same language, a link to a picture or to a published
file (vectors of the protocol, their runner, the codec in C, a licence) to a copy of it, and a
link to any other file of the repository to the repository's web address.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from tools.docs.dialect import rewritten
from tools.docs.markdown import with_targets
from tools.docs.pages import DOCS, ROOT, Page, led_to, path_of, web_address

_PICTURES = frozenset({".gif", ".jpg", ".png", ".svg", ".webp"})
_PUBLISHED = (PurePosixPath("conformance"), PurePosixPath("examples/c"), DOCS)
_NOT_PUBLISHED = frozenset({".md", ""})
_NOTE = """\
!!! note "Перевода этой страницы ещё нет"
    Ниже — английский текст.

"""


def assemble(pages: Mapping[str, Page], folder: Path) -> None:
    """Write the pages and their pictures into `folder`."""
    shutil.rmtree(folder, ignore_errors=True)
    copied: set[PurePosixPath] = set()
    for page in pages.values():
        targets: dict[int, str] = {}
        for link in page.document.links:
            if link.external or not link.path:
                continue
            place = led_to(page.file, link)
            if _is_copied(place):
                copied.add(place)
            targets[link.start] = _target(page, place, pages, link.anchor)
        text = rewritten(with_targets(page.document, targets))
        _write(folder / page.path, text if page.translated else _noted(text))
    for file in copied:
        copy = folder / _copy(file)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / file, copy)


def _target(page: Page, place: PurePosixPath, pages: Mapping[str, Page], anchor: str) -> str:
    behind = f"#{anchor}" if anchor else ""
    if _is_copied(place):
        return _relative(_copy(place), page.path)
    if place.is_relative_to(DOCS) and (path := path_of(place)) in pages:
        # The words of a heading, and so its anchor, are those of the page's own language.
        return _relative(path, page.path) + (
            behind if page.translated == pages[path].translated else ""
        )
    return web_address(place) + behind


def _is_copied(place: PurePosixPath) -> bool:
    return place.suffix in _PICTURES or (
        place.suffix not in _NOT_PUBLISHED and any(map(place.is_relative_to, _PUBLISHED))
    )


def _copy(place: PurePosixPath) -> str:
    """Return the path of a picture or a published file below the folder of a language."""
    return place.relative_to(DOCS).as_posix() if place.is_relative_to(DOCS) else f"files/{place}"


def _relative(path: str, page: str) -> str:
    return os.path.relpath(path, PurePosixPath(page).parent.as_posix()).replace(os.sep, "/")


def _noted(text: str) -> str:
    heading, _, rest = text.partition("\n")
    return f"{heading}\n\n{_NOTE}{rest}"


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, "utf-8", newline="\n")
