"""The user's config file: default settings for every command.

# ~/.config/mikas/config.toml (or the system's own place; MIKAS_CONFIG names another)
port = "/dev/ttyUSB0"
lang = "ru"
inter_byte = 0.5                   # a slow network
catalog = ["~/my-catalog.toml"]    # a relative path is relative to this file
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from mikas.errors import UsageError, reason_of, usage_error
from mikas.i18n import Text

ECHO = ("auto", "on", "off")
CHECKSUMS = ("stuffed", "raw")
INTERPRETATIONS = ("corrected", "literal", "alternative")
LANGUAGES = ("en", "ru")
MIN_TIMEOUT, MAX_TIMEOUT = 0.001, 60
MAX_RETRIES = 100

_WORDS = {
    "echo": ECHO,
    "checksum": CHECKSUMS,
    "interpretation": INTERPRETATIONS,
    "lang": LANGUAGES,
}
_SETTINGS = (
    "port", "echo", "timeout", "inter_byte", "retries", "checksum", "strict", "interpretation",
    "lang", "catalog",
)  # fmt: skip


def path() -> Path:
    """Return the path of the config file, whether or not it exists."""
    if named := os.environ.get("MIKAS_CONFIG"):
        return Path(named)
    if sys.platform not in ("win32", "darwin"):  # as platformdirs, without its import
        base = os.environ.get("XDG_CONFIG_HOME", "").strip()
        folder = Path(base) if base else Path("~/.config").expanduser()
        return folder / "mikas" / "config.toml"
    from platformdirs import user_config_path

    return user_config_path("mikas", appauthor=False) / "config.toml"


def own_catalog() -> Path:
    """Return the path of the user's own catalog, whether or not it exists."""
    return path().with_name("catalog.toml")


def own_tests() -> Path:
    """Return the folder of the user's guided tests, whether or not it exists."""
    return path().parent / "tests"


def language() -> str:
    """Return the file's `lang`; empty without one, and for a wrong file, which `load` reports."""
    try:
        return str(_parsed(path()).get("lang", ""))
    except (UsageError, RuntimeError):
        return ""


def load() -> dict[str, Any]:
    """Return the settings in the file, none without a file. Raises `UsageError` if it is wrong."""
    file = path()
    settings = _parsed(file)
    for name, value in settings.items():
        if name not in _SETTINGS:
            known = ", ".join(_SETTINGS)
            raise _wrong(
                file,
                f"there is no setting “{name}”; the settings are {known}",
                f"настройки «{name}» нет; есть {known}",
            )
        wanted = _expected(name, value)
        if wanted is not None:
            raise _wrong(file, f"{name} has to be {wanted.en}", f"{name} — это {wanted.ru}")
    settings["catalog"] = [
        str(file.parent / Path(name).expanduser()) for name in settings.get("catalog", ())
    ]
    return settings


def _expected(name: str, value: object) -> Text | None:
    """Return the values allowed for this setting; None if `value` is one."""
    if name == "strict":
        return None if isinstance(value, bool) else Text("true or false", "true или false")
    if isinstance(value, bool):  # an int in Python, and allowed nowhere else
        value = None
    if name in _WORDS:
        words = ", ".join(_WORDS[name])
        return None if value in _WORDS[name] else Text(f"one of {words}", f"одно из {words}")
    if name == "port":
        good = isinstance(value, str) and bool(value.strip())
        return None if good else Text('a port in quotes, like "COM3"', 'порт в кавычках: "COM3"')
    if name in ("timeout", "inter_byte"):
        good = isinstance(value, int | float) and MIN_TIMEOUT <= value <= MAX_TIMEOUT
        limits = f"{MIN_TIMEOUT} … {MAX_TIMEOUT}"
        return None if good else Text(f"seconds, {limits}", f"число секунд, {limits}")
    if name == "retries":
        good = isinstance(value, int) and 0 <= value <= MAX_RETRIES
        return (
            None
            if good
            else Text(f"a whole number, 0 to {MAX_RETRIES}", f"целое число от 0 до {MAX_RETRIES}")
        )
    good = isinstance(value, list) and all(map(_is_path, value))
    return None if good else Text('a list of files, ["my.toml"]', 'список файлов: ["my.toml"]')


def _is_path(value: object) -> bool:
    return isinstance(value, str) and bool(value) and "\0" not in value


def _parsed(file: Path) -> dict[str, Any]:
    if not file.is_file():
        return {}
    from mikas import toml

    try:
        return toml.parse(toml.text_of(toml.read_bytes(file)))
    except OSError as error:
        reason = reason_of(error)
        raise _wrong(file, reason.en, reason.ru) from error
    except toml.TomlError as error:
        place = f"{file}:{error.line}" if error.line else file
        raise _wrong(place, error.problem.en, error.problem.ru) from error


def _wrong(file: Path | str, en: str, ru: str) -> UsageError:
    return usage_error(f"The config file {file}: {en}", f"Файл настроек {file}: {ru}")
