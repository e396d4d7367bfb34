"""The language of the command line, set once at the start; texts and numbers in it."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from mikas.i18n import Language, Text

_chosen: Language = "en"
_requested = False


def set_language(language: Language) -> None:
    """Set the language of all texts."""
    global _chosen  # noqa: PLW0603  (one language a process)
    _chosen = language


def current_language() -> Language:
    """Return the current language."""
    return _chosen


def requested_language() -> Language | None:
    """Return the current language if the user named it; None if it is the system's."""
    return _chosen if _requested else None


def tr(en: str, ru: str) -> str:
    """Return the text in the current language."""
    return ru if _chosen == "ru" else en


def localized(text: Text) -> str:
    """Return `text` in the current language."""
    return text.to(_chosen)


def capital(text: str) -> str:
    """Return `text` with a capital first letter."""
    return text[:1].upper() + text[1:]


def decimal(text: str) -> str:
    """Return a number's digits with the decimal sign of the current language."""
    return text.replace(".", ",") if _chosen == "ru" else text


def detect_language(argv: Sequence[str], configured: Callable[[], str]) -> Language:
    """Return the language of `--lang`, else MIKAS_LANG, else `configured()`, else the locale's.

    The help needs it before the arguments are parsed; an invalid value is reported then.
    """
    global _requested  # noqa: PLW0603  (as `set_language`)
    named = _in_arguments(argv) or os.environ.get("MIKAS_LANG") or configured()
    _requested = bool(named)
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


def _of_locale() -> str:
    for name in ("LC_ALL", "LC_MESSAGES", "LANG"):
        if value := os.environ.get(name):
            return value
    if os.name == "nt":  # Windows has no such variables
        import locale

        return locale.getlocale()[0] or ""
    return ""
