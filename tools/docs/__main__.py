"""python -m tools.docs: builds build/docs, for any web server, or to be opened as files."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mikas.i18n import Language
from tools.docs import offline, rendering
from tools.docs.assembling import assemble
from tools.docs.generated.writing import of_the_site
from tools.docs.pages import LANGUAGES, ROOT, pages

BUILT = ROOT / "build" / "docs"
# What is rendered, and what is done before.
WORK = ROOT / "build" / "docs_work"
_THEME = Path(__file__).with_name("theme")
_OF_EACH_LANGUAGE = (
    ROOT / "web" / "public" / "icon.svg",
    _THEME / "extra.css",
    _THEME / "search-in-files.js",
)


def main() -> int:
    """Build the site; return the exit status."""
    shutil.rmtree(BUILT, ignore_errors=True)
    try:
        made = [of_the_site(language) for language in LANGUAGES]  # one language at a time
        with ThreadPoolExecutor() as both:
            sites = dict(zip(LANGUAGES, both.map(_site, LANGUAGES, made), strict=True))
    except rendering.Failed as error:
        print(f"make docs: {error}", file=sys.stderr)
        return 1
    for language, site in sites.items():
        shutil.copytree(site, BUILT / language)
    shutil.copyfile(_THEME / "front.html", BUILT / "index.html")
    if found := list(offline.loaded_from_elsewhere(BUILT)):
        print(
            "make docs: a browser would load these from elsewhere:",
            *found,
            sep="\n  ",
            file=sys.stderr,
        )
        (BUILT / "index.html").unlink()  # for make, it was not built
        return 1
    total = sum(path.stat().st_size for path in BUILT.rglob("*") if path.is_file())
    print(f"build/docs: {len(list(BUILT.rglob('*.html')))} pages, {total / 1e6:.1f} MB")
    return 0


def _site(language: Language, made: Mapping[str, str]) -> Path:
    """Assemble and render one language; return its folder."""
    folder = WORK / language
    found = pages(language, made)
    assemble(found, folder / "pages")
    for file in _OF_EACH_LANGUAGE:
        shutil.copyfile(file, folder / "pages" / file.name)
    return rendering.render(language, found, folder)


if __name__ == "__main__":
    sys.exit(main())
