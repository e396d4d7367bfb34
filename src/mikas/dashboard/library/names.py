"""Names of files that the program makes, and those that it accepts in a folder.

A name made here is a file on every system, also once it is copied to another one: Linux counts 255
bytes, Windows reserves characters and the names of devices, and drops dots and spaces at the end.
Nor does it look like another name or like an option of a command.
"""

from __future__ import annotations

import re
import unicodedata
from typing import Final

from mikas.cleaning import REPLACEMENT, clean_line

_SEPARATORS: Final = r'[/\\:*?"<>|]'
_UNFIT: Final = re.compile(rf"(?:{_SEPARATORS}|[\s{REPLACEMENT}])+")
# With all behind a dot. Windows takes the superscripts for digits, and drops spaces.
_DEVICE: Final = re.compile(
    r"(?i)^(con|prn|aux|nul|conin\$|conout\$|(?:com|lpt)[0-9\u00b9\u00b2\u00b3])(?=\s*(?:\.|$))"
)
_JOINERS: Final = "\u200c\u200d"  # in Persian, and in emoji
_ENDS: Final = f" .{_JOINERS}"
_BEGINS: Final = f"{_ENDS}-~"  # a hidden file, an option, a home folder
_MOST_GIVEN: Final = 1000  # characters of a name that are looked at
_MOST_CHARACTERS: Final = 100
_MOST_BYTES: Final = 200  # of 255; the rest is for ` (12).pcapng.part`
_MOST_FOUND: Final = 240  # bytes of a name in a folder; the program adds `.json.new`


def file_stem(name: str | None, suffix: str) -> str:
    """Return `name` as a file name without `suffix`; empty if no character of it fits."""
    fit = unicodedata.normalize("NFC", clean_line(name or "", _MOST_GIVEN))
    fit = "".join(each for each in fit if each in _JOINERS or unicodedata.category(each) != "Cf")
    fit = _UNFIT.sub(" ", fit).strip(_ENDS).removesuffix(suffix).lstrip(_BEGINS)
    fit = fit[:_MOST_CHARACTERS].encode()[:_MOST_BYTES].decode(errors="ignore").strip(_ENDS)
    return _DEVICE.sub(r"\1-", fit)


def is_file_name(name: str, suffix: str) -> bool:
    """Whether a file of this name is used: it can be shown as it is, and is no path."""
    return (
        name.endswith(suffix)
        and not name.startswith(".")
        and clean_line(name) == name
        and not re.search(_SEPARATORS, name)
        and len(name.encode()) <= _MOST_FOUND
    )
