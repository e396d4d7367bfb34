"""Tables of Markdown in one language, and the pages that they stand in (texts/)."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from mikas.catalog import Confidence
from mikas.i18n import Language, Text
from tools.docs.checking.citations import CITED, anchor_of

_TEXTS = Path(__file__).with_name("texts")
CONFIDENCE = {
    Confidence.CONFIRMED: Text("confirmed by two sources", "подтверждено двумя источниками"),
    Confidence.REPORTED: Text("one source", "один источник"),
    Confidence.UNCONFIRMED: Text("unconfirmed", "не подтверждено"),
    Confidence.UNKNOWN: Text("unknown", "неизвестно"),
}


def table(language: Language, headers: tuple[str, str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; `headers`: in English and in Russian, with `|` between them."""
    titles = Text(*headers).to(language).split("|")
    lines = [titles, ["---"] * len(titles), *rows]
    return "".join(f"| {' | '.join(map(_cell, line))} |\n" for line in lines)


def code(text: str) -> str:
    """Return `text` as code; empty stays empty."""
    return f"`{text}`" if text else ""


def cited(clause: str) -> str:
    """Return a clause of the protocol as a link of a page in reference/; other text unchanged."""
    found = CITED.fullmatch(clause)
    return f"[{clause}](../protocol.md#{anchor_of(found)})" if found else clause


def number(value: float, language: Language) -> str:
    """Return a number with the decimal sign of the language and a true minus."""
    text = f"{value:g}".replace("-", "−")
    return text.replace(".", ",") if language == "ru" else text


def interval(limits: tuple[float, float] | None, language: Language) -> str:
    """Return `800 … 900`; empty without limits."""
    return " … ".join(number(each, language) for each in limits) if limits else ""


def page(name: str, language: Language, **tables: str) -> str:
    """Return the page of that name, with these tables in their places."""
    text = (_TEXTS / language / f"{name}.md").read_text("utf-8")
    return text.format(**tables)


def _cell(text: str) -> str:
    return re.sub(r"\s+", " ", text).replace("|", "\\|").strip()
