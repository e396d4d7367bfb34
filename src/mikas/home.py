"""This user's home folder, and a place for a user without one.

A container or a service may have none: no HOME and no entry in the list of users, or an empty HOME.
Then nothing is found below it and nothing can be kept there: `NO_HOME` can never be a folder. It is
not the current folder, where a library would make one called `~`.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Final

from mikas.i18n import Text

NO_HOME: Final = Path(os.devnull, "no-home")
WHY: Final = Text(
    "this user has no home folder; set HOME to a folder",
    "у этого пользователя нет домашней папки; укажите папку в HOME",
)


def home() -> Path:
    """Return the home folder; `NO_HOME` without one."""
    if os.name == "posix" and (named := os.environ.get("HOME")) is not None:
        return Path(named) if named.startswith("/") else NO_HOME
    try:
        return Path.home()
    except RuntimeError:
        return NO_HOME


def expanded(name: str) -> Path:
    """Return the path with the home folder for `~`; another user's that is unknown stays a name."""
    path = Path(name)
    if path.parts[:1] == ("~",):
        return home().joinpath(*path.parts[1:])
    try:
        return path.expanduser()
    except RuntimeError:
        return path


def config_folder() -> Path:
    """Return the folder of the user's settings."""
    if _has_places_of_its_own():
        from platformdirs import user_config_path

        return user_config_path("mikas", appauthor=False)
    return _of_xdg("XDG_CONFIG_HOME", ".config")


def state_folder() -> Path:
    """Return the folder of the files that are kept for the user between runs."""
    if _has_places_of_its_own():
        from platformdirs import user_state_path

        return NO_HOME / "mikas" if home() == NO_HOME else user_state_path("mikas", appauthor=False)
    return _of_xdg("XDG_STATE_HOME", ".local", "state")


def documents_folder() -> Path:
    """Return the folder of the user's documents."""
    from platformdirs import user_documents_path

    return NO_HOME / "Documents" if home() == NO_HOME else user_documents_path()


def _has_places_of_its_own() -> bool:
    return sys.platform in ("win32", "darwin")


def _of_xdg(variable: str, *usual: str) -> Path:
    named = os.environ.get(variable, "").strip()
    return (Path(named) if named else home().joinpath(*usual)) / "mikas"
