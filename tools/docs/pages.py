"""Which file is which page, in each language, and where a link of a page leads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path, PurePosixPath
from typing import get_args
from urllib.parse import unquote

from mikas.i18n import Language
from tools.docs.markdown import Document, Link

ROOT = Path(__file__).resolve().parents[2]
REPOSITORY = "https://github.com/mikas-diagnostics/mikas"
LANGUAGES: tuple[Language, ...] = get_args(Language)
DOCS = PurePosixPath("docs")
RUSSIAN = DOCS / "ru"


@dataclass(frozen=True, slots=True)
class Page:
    """A page of the site in one language, from a file of the repository.

    `path`: below the site's folder of that language. `file`: below the repository; the English one
    where there is no translation yet. `made`: the text of a page that is no file.
    """

    path: str
    language: Language
    file: PurePosixPath
    made: str | None = None

    @property
    def translated(self) -> bool:
        """Whether the text is in the page's language."""
        return (self.language == "ru") == self.file.is_relative_to(RUSSIAN)

    @property
    def document(self) -> Document:
        """The page's contents."""
        return document(self.file) if self.made is None else Document(self.made)


@cache
def document(file: PurePosixPath) -> Document:
    """Read a Markdown file of the repository, once."""
    return Document((ROOT / file).read_text("utf-8"))


def files(language: Language) -> Iterator[PurePosixPath]:
    """Yield the Markdown files of a language, below the repository."""
    for path in sorted((ROOT / DOCS).rglob("*.md")):
        file = PurePosixPath(path.relative_to(ROOT).as_posix())
        if file.is_relative_to(RUSSIAN) == (language == "ru"):
            yield file


def pages(language: Language, made: Mapping[str, str]) -> dict[str, Page]:
    """Return the pages of a language by their paths: all that exist in English, and `made` ones."""
    found = {path_of(file): Page(path_of(file), language, file) for file in files("en")}
    if language == "ru":
        found |= {path_of(file): Page(path_of(file), language, file) for file in files("ru")}
    home = RUSSIAN if language == "ru" else DOCS
    return found | {path: Page(path, language, home / path, text) for path, text in made.items()}


def path_of(file: PurePosixPath) -> str:
    """Return the path on the site of a file below docs/."""
    home = RUSSIAN if file.is_relative_to(RUSSIAN) else DOCS
    return file.relative_to(home).as_posix()


def led_to(file: PurePosixPath, link: Link) -> PurePosixPath:
    """Return the place in the repository that a link of `file` leads to, existing or not.

    ValueError: outside the repository.
    """
    if not link.path:
        return file
    parts: list[str] = []
    for part in (*file.parent.parts, *PurePosixPath(unquote(link.path)).parts):
        if part != "..":
            parts.append(part)
        elif parts:
            parts.pop()
        else:
            raise ValueError(f"{link.target} leads out of the repository")
    return PurePosixPath(*parts)


def web_address(place: PurePosixPath) -> str:
    """Return the repository's web address of a file or folder."""
    kind = "tree" if (ROOT / place).is_dir() else "blob"
    return f"{REPOSITORY}/{kind}/main/{place.as_posix()}"
