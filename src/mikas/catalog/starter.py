"""A catalog file to start from: an entry for each code of a unit that the catalog does not know.

A code that the catalog knows stays as it is defined there, and is listed in a comment, as is a
datum that no entry can have: more than two bytes, or another size than the catalog's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mikas.catalog.lookup import Catalog
from mikas.cleaning import clean_line
from mikas.i18n import Language, Text

_LARGEST = 2  # bytes of a parameter, docs/reference/catalog.md
_KNOWN = Text("Defined already:", "Уже описаны:")
_OTHER_SIZE = Text(
    "{code}: bytes here: {size}, in the catalog: {defined}; it keeps the catalog's definition",
    "{code}: здесь байтов {size}, в каталоге {defined}; остаётся описание каталога",
)
_TOO_LARGE = Text(
    "{code}: {size} bytes, more than an entry can have ({raw})",
    "{code}: байтов {size}, больше, чем бывает у параметра ({raw})",
)
_SEEN = Text("at the scan:", "при опросе:")


def names_of(catalog: Catalog, code: int) -> str:
    """Return the names of a code's parameters with spaces between; empty for an unknown code."""
    return " ".join(parameter.name for parameter in catalog.by_code(code))


def starter_catalog(
    data: Mapping[int, bytes], catalog: Catalog, heading: Sequence[str], language: Language
) -> str:
    """Return the text of a catalog file for a unit with `data`, by code, over `catalog`.

    `heading`: lines of its first comment. `language`: of the comments; the texts have both.
    """
    known, remarks, entries = [], [], []
    for code, raw in sorted(data.items()):
        fields = {"code": f"{code:02X}", "size": len(raw), "raw": raw.hex(" ").upper()}
        defined = catalog.size_of(code)
        if defined == len(raw):
            known.append(f"{code:02X} {names_of(catalog, code)}")
        elif defined is not None:
            remarks.append(_OTHER_SIZE.filled(defined=defined, **fields).to(language))
        elif len(raw) > _LARGEST:
            remarks.append(_TOO_LARGE.filled(**fields).to(language))
        else:
            entries.append(_entry(code, raw, language))
    if known:
        remarks.insert(0, f"{_KNOWN.to(language)} {', '.join(known)}")
    comment = [clean_line(line) for line in (*heading, *remarks)]
    return "\n".join(["".join(f"# {line}\n" for line in comment), *entries])


def _entry(code: int, raw: bytes, language: Language) -> str:
    seen = f"{_SEEN.to(language)} {raw.hex(' ').upper()}"
    return (
        f"[parameter.CODE_{code:02X}]  # {seen}\n"
        f"code = 0x{code:02X}\n"
        f"size = {len(raw)}\n"
        f'text = {{ en = "code {code:02X}", ru = "код {code:02X}" }}\n'
    )
