"""The user's config file: default settings for every command.

# ~/.config/mikas/config.toml (or the system's own place; MIKAS_CONFIG names another)
port = "/dev/ttyUSB0"
lang = "ru"
inter_byte = 0.5                   # a slow network
catalog = ["~/my-catalog.toml"]    # a relative path is relative to this file
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mikas.home import expanded
from mikas.i18n import Text
from mikas.preferences import A_PORT, config_path, parsed_config, wrong_config

ECHO = ("auto", "on", "off")
CHECKSUMS = ("stuffed", "raw")
INTERPRETATIONS = ("corrected", "literal", "alternative", "family")
LANGUAGES = ("en", "ru")
MIN_TIMEOUT, MAX_TIMEOUT = 0.001, 60
MAX_PAUSE = 2.0  # s
MAX_RETRIES = 100

_WORDS = {
    "echo": ECHO,
    "checksum": CHECKSUMS,
    "interpretation": INTERPRETATIONS,
    "lang": LANGUAGES,
}
_SETTINGS = (
    "port", "echo", "timeout", "inter_byte", "pause", "retries", "checksum", "strict",
    "interpretation", "lang", "catalog",
)  # fmt: skip


def own_catalog() -> Path:
    """Return the path of the user's own catalog, whether or not it exists."""
    return config_path().with_name("catalog.toml")


def own_tests() -> Path:
    """Return the folder of the user's guided tests, whether or not it exists."""
    return config_path().parent / "tests"


def own_causes() -> Path:
    """Return the folder of the user's causes, whether or not it exists."""
    return config_path().parent / "causes"


def load() -> dict[str, Any]:
    """Return the settings in the file, none without a file. Raises `UsageError` if it is wrong."""
    file = config_path()
    settings = parsed_config(file)
    for name, value in settings.items():
        if name not in _SETTINGS:
            known = ", ".join(_SETTINGS)
            raise wrong_config(
                file,
                f"there is no setting “{name}”; the settings are {known}",
                f"настройки «{name}» нет; есть {known}",
            )
        wanted = _expected(name, value)
        if wanted is not None:
            raise wrong_config(file, f"{name} has to be {wanted.en}", f"{name} — это {wanted.ru}")
    settings["catalog"] = [
        str(file.parent / expanded(name)) for name in settings.get("catalog", ())
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
        return None if good else A_PORT
    if name == "pause":
        good = value == "auto" or (isinstance(value, int | float) and 0 <= value <= MAX_PAUSE)
        limits = f"0 … {MAX_PAUSE:g}"
        return (
            None if good else Text(f'"auto" or seconds, {limits}', f'"auto" или секунды, {limits}')
        )
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
