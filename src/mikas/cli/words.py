"""The language that the command line speaks, chosen once at the start."""

from __future__ import annotations

import os
from collections.abc import Sequence

from mikas.language import Language, Text

_chosen: Language = "en"


def choose(language: Language) -> None:
    """From here on everything is said in `language`."""
    global _chosen  # noqa: PLW0603  (one process speaks one language; threading it through every
    # help text would be the larger evil)
    _chosen = language


def language() -> Language:
    """The language in force."""
    return _chosen


def say(en: str, ru: str) -> str:
    """The one of the two that is in force."""
    return ru if _chosen == "ru" else en


def shown(text: Text) -> str:
    """`text` in the language in force."""
    return text.to(_chosen)


def from_surroundings(argv: Sequence[str]) -> Language:
    """`--lang` wherever it stands, else MIKAS_LANG, else the system's locale.

    Looked up before the arguments are parsed, because the help itself speaks it. What is wrong with
    `--lang` the parser says.
    """
    wanted = ""
    for index, word in enumerate(argv):
        if word == "--lang" and index + 1 < len(argv):
            wanted = argv[index + 1]
        elif word.startswith("--lang="):
            wanted = word.partition("=")[2]
    for value in (wanted, *(os.environ.get(name, "") for name in _VARIABLES)):
        if value:
            return "ru" if value.lower().startswith("ru") else "en"
    return "en"


_VARIABLES = ("MIKAS_LANG", "LC_ALL", "LC_MESSAGES", "LANG")
