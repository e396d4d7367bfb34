"""One Python file: the tables, then the hand-written parts, without their imports of each other.

Its Python may be as old as 3.4, which PulseView for Windows brings.
"""

from __future__ import annotations

import re
from importlib.resources import files
from pprint import pformat
from typing import Any, Final

from mikas.catalog import INTERPRETATIONS, Catalog
from mikas.dissectors.tables import tables_of
from mikas.i18n import Language

_PARTS: Final = ("framing", "commands", "turns", "decoder")
_LANGUAGES: Final = ("en", "ru")
MARK: Final = "# Mikas K-Line decoder for sigrok, written by `mikas sigrok`"
"""The beginning of the first line, by which the file is known as its own."""

_DOCUMENT: Final = re.compile(r'"""(.+?)"""\n+', re.DOTALL)
_IMPORT: Final = re.compile(r"^(from \.\w+ import .*|import sigrokdecode .*)\n+", re.MULTILINE)
_HEAD: Final = f"""\
{MARK}
# Do not edit: run the command again, also after a change of your own catalog.
# SPDX-License-Identifier: MIT
"""


def source(
    catalog: Catalog,
    *,
    language: Language = "en",
    interpretation: str = "corrected",
    checksum: str = "stuffed",
) -> str:
    """Return the decoder with this catalog. The others are what its options are by default."""
    defaults = {"checksum": checksum, "interpretation": interpretation, "language": language}
    parts = [_part(name) for name in _PARTS]
    document, code = parts.pop()
    tables = _tables(catalog, defaults)
    sections = [
        f'{_HEAD}"""{document}"""\n',
        "import sigrokdecode as srd\n",
        "".join(f"{name} = {value}\n" for name, value in tables.items()),
        *(f"{_comment(before)}\n{after}" for before, after in parts),
        code,
    ]
    return "\n\n".join(sections)


def _part(name: str) -> tuple[str, str]:
    """Return the docstring and the rest of a part, without its imports of other parts."""
    text = files(__package__).joinpath("_parts", f"{name}.py").read_text("utf-8")
    document = _DOCUMENT.match(text)
    assert document
    return document[1], _IMPORT.sub("", text[document.end() :])


def _comment(document: str) -> str:
    return "".join(f"# {line}".rstrip() + "\n" for line in document.strip().splitlines())


def _tables(catalog: Catalog, defaults: dict[str, str]) -> dict[str, str]:
    """Return the values that the parts import from `tables`, as Python; texts in both languages."""
    tables = tables_of(catalog, None)
    parameters: dict[int, list[dict[str, Any]]] = {}
    for row in tables["parameters"]:
        kept = {key: row[key] for key in ("name", "text", "size", "decimals")}
        kept["interpretations"] = [row["interpretations"][name] for name in INTERPRETATIONS]
        parameters.setdefault(row["code"], []).append(kept)
    needed = ("title", "shown", "stream", "address_bytes", "request", "responses")
    values = {
        "LANGUAGES": _LANGUAGES,
        "INTERPRETATIONS": INTERPRETATIONS,
        "DEFAULTS": defaults,
        "COMMANDS": {
            code: {key: row[key] for key in needed} for code, row in tables["commands"].items()
        },
        "PARAMETERS": parameters,
        "FAULTS": tables["faults"],
        "MODELS": tables["models"],
        "MESSAGES": tables["messages"],
    }
    return {name: pformat(value, width=98, sort_dicts=False) for name, value in values.items()}
