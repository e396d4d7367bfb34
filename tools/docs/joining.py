"""python -m tools.docs.joining: the documentation beside the page without installation.

`build/site/docs/` is no part of the page: it is neither in its list of files nor in its service
worker. Front pages, and others with the mark of the place, get a link to the page, which has one to
the front pages.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from mikas.i18n import Text
from tools.docs.__main__ import BUILT
from tools.docs.pages import LANGUAGES
from tools.site.serve import SITE

# Stands in the front pages, and in the owner's first steps.
_PLACE = "<!-- the page without installation -->"
_LINK = Text("Open mikas in this browser", "Открыть mikas в этом браузере")


def join(docs: Path, site: Path) -> None:
    """Copy the documentation into the folder of the page, with links to the page."""
    joined = site / "docs"
    shutil.rmtree(joined, ignore_errors=True)
    shutil.copytree(docs, joined)
    for language in LANGUAGES:
        home = joined / language
        assert _PLACE in (home / "index.html").read_text("utf-8"), home
        for page in home.rglob("*.html"):
            text = page.read_text("utf-8")
            if _PLACE not in text:
                continue
            up = "../" * len(page.relative_to(site).parents[:-1])
            style = "md-button md-button--primary"
            link = f'<p><a class="{style}" href="{up}index.html">{_LINK.to(language)}</a></p>'
            page.write_text(text.replace(_PLACE, link), "utf-8", newline="\n")


def main() -> int:
    """Join what was built; return the exit status."""
    join(BUILT, SITE)
    print(f"build/site/docs: the documentation, {sum(1 for _ in BUILT.rglob('*.html'))} pages")
    return 0


if __name__ == "__main__":
    sys.exit(main())
