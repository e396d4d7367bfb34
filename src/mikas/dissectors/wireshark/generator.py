"""One Lua file: the tables and words, then the hand-written parts, which share one scope."""

from __future__ import annotations

from importlib.resources import files
from typing import Final

from mikas.catalog import Catalog
from mikas.commands.unit import passport_text
from mikas.dissectors.tables import tables_of
from mikas.dissectors.wireshark.labels import LABELS
from mikas.i18n import Language
from mikas.recording.exchanges.verdicts import Doubt
from mikas.recording.inspect import NOT_TRUSTED

MARK: Final = "-- Mikas K-Line dissector for Wireshark, written by `mikas wireshark`"
"""The beginning of the first line, by which the file is known as its own."""

_PARTS: Final = (
    "fields", "framing", "meaning", "matching", "line", "words", "tree", "keeping", "dissector",
    "instruments",
)  # fmt: skip
_HEAD: Final = """\
{mark}
-- (version {version}, catalog {catalog}). Do not edit: run the command again, also after a change
-- of your own catalog.
"""


def source(catalog: Catalog, language: Language, interpretation: str, version: str) -> str:
    """Return the dissector. `interpretation`: the one by default; `version`: the program's."""
    tables = tables_of(catalog, language)
    given = {
        "INTERPRETATION": interpretation,
        "LABELS": {key: text.to(language) for key, text in LABELS.items()},
        "DOUBTS": {doubt.name: doubt.value.to(language) for doubt in Doubt},
        "NOT_TRUSTED": NOT_TRUSTED.to(language),
        "CODE_PAGE": [passport_text(bytes([code])) for code in range(256)],
        "TABLES": tables,
    }
    head = _HEAD.format(mark=MARK, version=version, catalog=catalog.version)
    data = [f"local {name} = {lua(value)}\n" for name, value in given.items()]
    parts = [files(__package__).joinpath(f"{part}.lua").read_text("utf-8") for part in _PARTS]
    return "\n".join([head, *data, *parts])


def in_ascii(text: str) -> str:
    """Return the same program in ASCII: in its texts, a byte of UTF-8 is an escape, `\\194`."""
    encoded = text.encode()
    return "".join(chr(byte) if byte < 128 else f"\\{byte}" for byte in encoded)


def lua(value: object, indent: str = "") -> str:
    """Return `value`, of the tables, as a Lua literal."""
    deeper = f"{indent}  "
    match value:
        case None:
            return "nil"
        case bool():
            return "true" if value else "false"
        case str():
            return _text(value)
        case dict():
            entries = [f"[{lua(key)}] = {lua(each, deeper)}" for key, each in value.items()]
        case list():
            entries = [lua(each, deeper) for each in value]
        case _:
            return repr(value)
    if not entries:
        return "{}"
    line = f"{{ {', '.join(entries)} }}"
    if len(line) <= 100 and "\n" not in line:
        return line
    return f"{{\n{deeper}" + f",\n{deeper}".join(entries) + f",\n{indent}}}"


def _text(text: str) -> str:
    """Return a quoted text; a text of a user's file can't end it."""
    quoted = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(f"\\{ord(each):03d}" if ord(each) < 32 else each for each in quoted) + '"'
