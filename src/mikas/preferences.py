"""The user's config file, and the language that a person reads.

The language is that of MIKAS_LANG, else the file's `lang`, else the system's. Where the program has
an option for it (`--lang`), that comes first.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Final

from mikas.errors import UsageError, reason_of, usage_error
from mikas.home import config_folder
from mikas.i18n import Language, Text

A_PORT: Final = Text('a port in quotes, like "COM3"', 'порт в кавычках: "COM3"')
"""What the setting `port` has to be."""


def config_path() -> Path:
    """Return the path of the config file, whether or not it exists."""
    if named := os.environ.get("MIKAS_CONFIG"):
        return Path(named)
    return config_folder() / "config.toml"


def parsed_config(file: Path) -> dict[str, Any]:
    """Return what the config file holds, nothing without a file. Raises `UsageError`."""
    try:
        if not file.is_file():
            return {}
        from mikas import toml

        return toml.parse(toml.text_of(toml.read_bytes(file)))
    except OSError as error:
        reason = reason_of(error)
        raise wrong_config(file, reason.en, reason.ru).caused_by(error, file) from error
    except toml.TomlError as error:
        place = f"{file}:{error.line}" if error.line else file
        raise wrong_config(place, error.problem.en, error.problem.ru) from error


def wrong_config(file: Path | str, en: str, ru: str) -> UsageError:
    """Return the error of a wrong config file, described in both languages."""
    return usage_error(f"The config file {file}: {en}", f"Файл настроек {file}: {ru}")


def named_language() -> str:
    """Return the language that the user has named; empty without one.

    A wrong file names none: who reads the whole of it reports that.
    """
    if named := os.environ.get("MIKAS_LANG"):
        return named
    try:
        return str(parsed_config(config_path()).get("lang", ""))
    except UsageError:
        return ""


def language_of(named: str) -> Language:
    """Return the named language; if it is empty, that of the system."""
    return "ru" if (named or _of_locale()).lower().startswith("ru") else "en"


def user_language() -> Language:
    """Return the language that this user reads."""
    return language_of(named_language())


def _of_locale() -> str:
    for name in ("LC_ALL", "LC_MESSAGES", "LANG"):
        if value := os.environ.get(name):
            return value
    if os.name == "nt":  # Windows has no such variables
        import locale

        return locale.getlocale()[0] or ""
    return ""
