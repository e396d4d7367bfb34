"""The decoder for sigrok and PulseView: one Python file, the tables in front of the parts.

sigrok imports each folder in its folders of decoders as a Python module, and takes `Decoder` from
it. So a folder `mikas` with nothing but an `__init__.py` is a whole decoder. The Python in it may
be as old as 3.4, which PulseView for Windows brings.
"""

from __future__ import annotations

import os
import re
import sys
from importlib.resources import files
from pathlib import Path
from pprint import pformat
from typing import Any, Final

from mikas.catalog import INTERPRETATIONS, Catalog
from mikas.dissectors.tables import plain, tables_of
from mikas.errors import UsageError, reason_at, usage_error
from mikas.files import open_regular
from mikas.i18n import Language
from mikas.saving import save

_PARTS: Final = ("framing", "commands", "turns", "decoder")
_LANGUAGES: Final = ("en", "ru")
_MARK: Final = "# Made by `mikas sigrok`"
_DOCUMENT: Final = re.compile(r'"""(.+?)"""\n+', re.DOTALL)
_IMPORT: Final = re.compile(r"^(from \.\w+ import .*|import sigrokdecode .*)\n+", re.MULTILINE)


def decoder_text(
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
        f'{_MARK}, which replaces this file. SPDX-License-Identifier: MIT\n"""{document}"""\n',
        "import sigrokdecode as srd\n",
        "".join(f"{name} = {value}\n" for name, value in tables.items()),
        *(f"{_comment(before)}\n{after}" for before, after in parts),
        code,
    ]
    return "\n\n".join(sections)


def decoders_folder() -> Path:
    """Return the folder of the user's decoders, whether or not it exists.

    That is SIGROKDECODE_DIR, else as GLib's `g_get_user_data_dir`, which macOS does not differ in.
    """
    if named := os.environ.get("SIGROKDECODE_DIR", "").strip():
        return Path(named)
    data = os.environ.get("XDG_DATA_HOME", "").strip()
    if not data and sys.platform == "win32":
        data = os.environ.get("LOCALAPPDATA", "").strip() or "~/AppData/Local"
    return Path(data or "~/.local/share").expanduser() / "libsigrokdecode" / "decoders"


def install(folder: Path, text: str) -> Path:
    """Write the decoder into this folder of decoders, and return the path of its file.

    Raises `UsageError` if another decoder of that name is there, or it can't be written.
    """
    path = folder / "mikas" / "__init__.py"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if os.path.lexists(path) and not _is_ours(path):
            raise usage_error(
                f"{path} is not a file of `mikas sigrok`; move it away first",
                f"{path} — файл не от `mikas sigrok`; сначала уберите его",
            )
        save(path, text)
    except OSError as error:
        raise UsageError(problem=reason_at(path, error)) from error
    return path


def _is_ours(path: Path) -> bool:
    with open_regular(path) as file:
        return file.read(len(_MARK)) == _MARK.encode()


def _part(name: str) -> tuple[str, str]:
    """Return the docstring and the rest of a part, without its imports of other parts."""
    text = files(__name__).joinpath("parts", f"{name}.py").read_text("utf-8")
    document = _DOCUMENT.match(text)
    assert document
    return document[1], _IMPORT.sub("", text[document.end() :])


def _comment(document: str) -> str:
    return "".join(f"# {line}".rstrip() + "\n" for line in document.strip().splitlines())


def _tables(catalog: Catalog, defaults: dict[str, str]) -> dict[str, str]:
    """Return the values that the parts import from `tables`, as Python; texts in both languages."""
    tables = plain(tables_of(catalog), None)
    parameters: dict[int, list[dict[str, Any]]] = {}
    for row in tables["parameters"]:
        kept = {key: row[key] for key in ("name", "text", "size", "decimals")}
        kept["readings"] = [row["readings"][name] for name in INTERPRETATIONS]
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
