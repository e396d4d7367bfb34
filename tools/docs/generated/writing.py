"""Which generated pages and drawings are files of the repository, and which only on the site.

Files are what GitHub should show as well; `make check` fails while one is stale.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import PurePosixPath

from mikas.catalog import Catalog, shipped
from mikas.i18n import Language
from tools.docs.generated import (
    catalog_pages,
    causes_page,
    command_pages,
    evidence_page,
    frames,
    help_pages,
    install_page,
    protocol_page,
    python_pages,
)
from tools.docs.pages import DOCS, LANGUAGES, RUSSIAN

_PAGES: dict[str, Callable[[Catalog, Language], str]] = {
    "reference/parameters.md": catalog_pages.parameters,
    "reference/faults.md": catalog_pages.faults,
    "reference/channels.md": catalog_pages.channels,
    "reference/causes.md": causes_page.causes,
    "reference/commands.md": command_pages.commands,
    "reference/facts.md": evidence_page.facts,
    "how-to/install.md": install_page.install,
    "protocol.md": protocol_page.protocol,
}


def files() -> Iterator[tuple[PurePosixPath, str]]:
    """Yield every generated file of the repository, with its text."""
    catalog = shipped()
    for language in LANGUAGES:
        home = RUSSIAN if language == "ru" else DOCS
        for path, made in _PAGES.items():
            yield home / path, made(catalog, language)
        if language == "en":
            yield from ((DOCS / path, text) for path, text in _python("en").items())
        for name, drawing in frames.drawings(catalog, language):
            yield DOCS / "pictures" / language / f"{name}.svg", drawing


def of_the_site(language: Language) -> dict[str, str]:
    """Return the pages that are on the site only, by their paths.

    The reference of the library is a file in English; in Russian its introductions differ.
    """
    python = _python(language) if language == "ru" else {}
    return {"reference/help.md": help_pages.help_page(language)} | python


def _python(language: Language) -> dict[str, str]:
    python_pages.places()  # before all: which classes have a page
    return {
        python_pages.path_of(each): python_pages.python_page(each, language)
        for each in python_pages.PAGES
    }
