"""The language of the command line, set once at the start; texts and numbers in it."""

from __future__ import annotations

from collections.abc import Sequence

from mikas.i18n import Language, Text
from mikas.preferences import language_of, named_language

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


def detect_language(argv: Sequence[str]) -> Language:
    """Return the language of `--lang`, else that of the user's settings, else the system's.

    The help needs it before the arguments are parsed; an invalid value is reported then.
    """
    global _requested  # noqa: PLW0603  (as `set_language`)
    named = _in_arguments(argv) or named_language()
    _requested = bool(named)
    return language_of(named)


def _in_arguments(argv: Sequence[str]) -> str:
    named = ""
    for word, following in zip(argv, [*argv[1:], ""], strict=False):
        if word == "--":
            break
        wanted = following if word == "--lang" else word.removeprefix("--lang=")
        if wanted != word and wanted.lower() in ("en", "ru"):
            named = wanted
    return named
