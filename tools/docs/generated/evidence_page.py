"""`evidence.toml` as §6 of the protocol's page, and as the keys of the page of facts."""

from __future__ import annotations

import re

from mikas.catalog import Catalog
from mikas.catalog.evidence import Basis, Sighting, evidence
from mikas.i18n import Language, Text
from tools.docs.checking.citations import CITED, anchor_of
from tools.docs.generated.places import filled
from tools.docs.generated.tables import table
from tools.docs.pages import DOCS, ROOT, RUSSIAN

_NOTHING = "–"
_NO = Text("no", "нет")


def bases(catalog: Catalog, language: Language) -> str:
    """Return the table of §6."""
    known = evidence()
    headers = (
        "clause|the source|sibling units, other texts|seen on a unit",
        "пункт|источник|родственные блоки, другие тексты|видели на блоке",
    )
    rows = []
    for basis in known.bases:
        names = " ".join(f"[{name}](#{_anchor(name, catalog)})" for name in basis.of)
        said = (basis.source.to(language), basis.siblings.to(language) or _NOTHING)
        seen = "; ".join(_seen(basis, each, language) for each in known.sightings_of(*basis.of))
        rows.append((names, *map(_linked, said), _linked(seen or _NO.to(language))))
    return table(language, headers, rows)


def _seen(basis: Basis, sighting: Sighting, language: Language) -> str:
    """Return `D11, 0A, survey 3f2a90c1: …`, the names without those of other rows."""
    names = " ".join(each for each in sighting.of if each in basis.of)
    return f"{names}, {sighting.unit}: {sighting.text.to(language)}"


def facts(_: Catalog, language: Language) -> str:
    """Return the page of facts with the keys of the sources."""
    file = ROOT / (RUSSIAN if language == "ru" else DOCS) / "reference/facts.md"
    sources = evidence().sources.items()
    lines = "".join(f"- {key}: {text.to(language)}\n" for key, text in sources)
    return filled(file.read_text("utf-8"), {"sources": lambda: lines})


def _anchor(name: str, catalog: Catalog) -> str:
    if cited := CITED.fullmatch(name):
        return anchor_of(cited)
    known = {each.name for each in catalog.parameters}
    return f"{'p' if name in known else 'cmd'}-{name.lower()}"


def _linked(text: str) -> str:
    """Return the text with each clause in it as a link of the protocol's page."""
    return re.sub(CITED, lambda found: f"[{found[0]}](#{anchor_of(found)})", text)
