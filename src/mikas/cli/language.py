"""The language that the command line speaks, chosen once at the start."""

from __future__ import annotations

import os
from collections.abc import Sequence

from mikas.i18n import Language, Text

_chosen: Language = "en"
_wished = False


def set_language(language: Language) -> None:
    """From here on everything is said in `language`."""
    global _chosen  # noqa: PLW0603  (one process speaks one language; threading it through every
    # help text would be the larger evil)
    _chosen = language


def current_language() -> Language:
    """The language in force."""
    return _chosen


def requested_language() -> Language | None:
    """The language in force, if the user named one; None if it is only the system's."""
    return _chosen if _wished else None


def tr(en: str, ru: str) -> str:
    """The one of the two that is in force."""
    return ru if _chosen == "ru" else en


def localized(text: Text) -> str:
    """`text` in the language in force."""
    return text.to(_chosen)


def decimal(text: str) -> str:
    """A number's digits with the decimal sign of the language in force."""
    return text.replace(".", ",") if _chosen == "ru" else text


def detect_language(argv: Sequence[str]) -> Language:
    """`--lang` wherever it stands, else MIKAS_LANG, else the config file, else the locale.

    Looked up before the arguments are parsed, because the help itself speaks it. What is wrong with
    `--lang`, or with the config file, is said later, by whoever reads it in earnest.
    """
    global _wished  # noqa: PLW0603  (as `set_language`)
    named = _in_arguments(argv) or os.environ.get("MIKAS_LANG") or _in_config()
    _wished = bool(named)
    return "ru" if (named or _of_locale()).lower().startswith("ru") else "en"


def _in_arguments(argv: Sequence[str]) -> str:
    named = ""
    for word, following in zip(argv, [*argv[1:], ""], strict=False):
        if word == "--":
            break
        wanted = following if word == "--lang" else word.removeprefix("--lang=")
        if wanted != word and wanted.lower() in ("en", "ru"):
            named = wanted
    return named


def _in_config() -> str:
    from mikas.cli import config

    return config.language()


def _of_locale() -> str:
    for name in ("LC_ALL", "LC_MESSAGES", "LANG"):
        if value := os.environ.get(name):
            return value
    if os.name == "nt":  # Windows keeps it elsewhere
        import locale

        return locale.getlocale()[0] or ""
    return ""
