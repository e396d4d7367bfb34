"""The user's config file: settings that need not be typed each time.

# ~/.config/mikas/config.toml (or the system's own place; MIKAS_CONFIG names another)
port = "/dev/ttyUSB0"
lang = "ru"
catalog = ["~/my-catalog.toml"]
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from mikas.errors import UsageError
from mikas.language import Text

_KINDS: dict[str, tuple[type, ...]] = {
    "port": (str,),
    "echo": (str,),
    "timeout": (int, float),
    "retries": (int,),
    "reading": (str,),
    "lang": (str,),
    "catalog": (list,),
}


def path() -> Path:
    """Where the file is, whether or not it exists."""
    if named := os.environ.get("MIKAS_CONFIG"):
        return Path(named)
    from platformdirs import user_config_path

    return user_config_path("mikas", appauthor=False) / "config.toml"


def load() -> dict[str, Any]:
    """The settings in the file; none if there is no file. Raises `UsageError` if it is wrong."""
    file = path()
    if not file.is_file():
        return {}
    import tomllib

    try:
        settings = tomllib.loads(file.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise _wrong(file, str(error), str(error)) from error
    for name, value in settings.items():
        if name not in _KINDS:
            known = ", ".join(_KINDS)
            raise _wrong(
                file,
                f"there is no setting “{name}”; there are {known}",
                f"настройки «{name}» нет; есть {known}",
            )
        if not isinstance(value, _KINDS[name]) or isinstance(value, bool):
            raise _wrong(file, f"{name} is of the wrong kind", f"значение {name} не того вида")
    settings["catalog"] = [str(Path(name).expanduser()) for name in settings.get("catalog", ())]
    return settings


def _wrong(file: Path, en: str, ru: str) -> UsageError:
    return UsageError(problem=Text(f"{file}: {en}", f"{file}: {ru}"))
