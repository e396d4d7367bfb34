"""Zensical over the assembled pages of a language, configured so that nothing is fetched."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Collection, Mapping
from pathlib import Path

from mikas.i18n import Language, Text
from tools.docs.navigation import NAVIGATION, Entry, Section
from tools.docs.pages import LANGUAGES, REPOSITORY, ROOT

_NAMES = {"en": "English", "ru": "Русский"}
_DESCRIPTION = Text(
    "Diagnostics for Mikas 5.4 and 7.1 engine control units over K-Line",
    "Диагностика блоков управления Микас 5.4 и 7.1 по K-Line",
)
_TO_DARK = Text("Dark", "Тёмная тема")
_TO_LIGHT = Text("Light", "Светлая тема")
_ABOUT = Text("The repository", "Репозиторий")
# Stands in the links to the other languages, for Zensical leads to their front pages only.
_SAME_PAGE = "SAME-PAGE"
_COLOURS = re.compile(r"\x1b\[[\d;]*m")
# The theme asks for a map of the site behind each of these.
_ALTERNATE = re.compile(r'<link rel="alternate"[^>]*>')

_FEATURES = (
    "content.code.copy", "navigation.footer", "navigation.sections", "navigation.top",
    "navigation.tracking", "search.highlight", "toc.follow",
)  # fmt: skip
_EXTENSIONS: Mapping[str, object] = {
    "admonition": {},
    "attr_list": {},
    "md_in_html": {},
    "tables": {},
    "toc": {
        "permalink": True,
        "slugify": {"object": "tools.docs.markdown.slugs"},
    },
    "pymdownx.highlight": {"pygments_lang_class": True},
    "pymdownx.superfences": {},
}


class Failed(Exception):
    """Zensical ended with an error; the text is what it printed."""


def render(language: Language, paths: Collection[str], folder: Path) -> Path:
    """Render the pages in `folder`/pages; return the folder of the site of that language."""
    site = folder / "site"
    shutil.rmtree(site, ignore_errors=True)
    configuration = folder / "zensical.toml"
    configuration.write_text(_toml({"project": _project(language, paths)}), "utf-8")
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "zensical",
            "build",
            "--clean",
            "--strict",
            "-f",
            str(configuration),
        ],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        check=False,
    )
    if done.returncode:
        raise Failed(_COLOURS.sub("", done.stdout))
    for name in ("404.html", "sitemap.xml", "sitemap.xml.gz", "objects.inv"):
        (site / name).unlink(missing_ok=True)  # of a site with an address of its own
    # For pages that are opened as files, which may read no file but scripts.
    index = (site / "search.json").read_text("utf-8")
    (site / "search.js").write_text(f"var __index = {index}", "utf-8", newline="\n")
    for page in site.rglob("*.html"):
        text = _ALTERNATE.sub("", page.read_text("utf-8"))
        own = page.relative_to(site).as_posix()
        page.write_text(text.replace(_SAME_PAGE, own), "utf-8", newline="\n")
    return site


def _project(language: Language, paths: Collection[str]) -> dict[str, object]:
    return {
        "site_name": "mikas",
        "site_description": _DESCRIPTION.to(language),
        "docs_dir": "pages",
        "site_dir": "site",
        "use_directory_urls": False,
        "nav": _nav(NAVIGATION, language, paths),
        "theme": {
            "language": language,
            "font": False,
            "features": list(_FEATURES),
            "logo": "icon.svg",
            "favicon": "icon.svg",
            "palette": [
                _palette("light", "default", "lucide/moon", _TO_DARK.to(language)),
                _palette("dark", "slate", "lucide/sun", _TO_LIGHT.to(language)),
            ],
        },
        "extra_css": ["extra.css"],
        "extra": {
            "polyfills": ["search-in-files.js"],
            "generator": False,
            "alternate": [
                {"name": _NAMES[each], "lang": each, "link": f"../{each}/{_SAME_PAGE}"}
                for each in LANGUAGES
            ],
            # As a link alone: what Zensical calls the repository asks GitHub for its stars.
            "social": [
                {"icon": "simple/github", "link": REPOSITORY, "name": _ABOUT.to(language)},
            ],
        },
        "markdown_extensions": _EXTENSIONS,
        # `make check` finds these, and says where in the repository.
        "validation": {"invalid_links": False, "invalid_link_anchors": False},
        "plugins": {"search": {}},
    }


def _palette(system: str, scheme: str, icon: str, name: str) -> dict[str, object]:
    return {
        "media": f"(prefers-color-scheme: {system})",
        "scheme": scheme,
        "primary": "black",
        "toggle": {"icon": icon, "name": name},
    }


def _nav(
    within: tuple[Entry | Section, ...], language: Language, paths: Collection[str]
) -> list[object]:
    made: list[object] = []
    for each in within:
        title = each.title.to(language)
        if isinstance(each, Section):
            inside = _nav(each.entries, language, paths)
            made += [{title: inside}] if inside else []
        elif each.path in paths:
            made.append({title: each.path})
    return made


def _toml(value: object) -> str:
    """Return nested tables of strings, numbers, truth values and lists as TOML."""
    assert isinstance(value, Mapping)
    return "".join(f"{json.dumps(key)} = {_inline(each)}\n" for key, each in value.items())


def _inline(value: object) -> str:
    if isinstance(value, Mapping):
        pairs = (f"{_string(key)} = {_inline(each)}" for key, each in value.items())
        return "{" + ", ".join(pairs) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return _string(value) if isinstance(value, str) else json.dumps(value)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
