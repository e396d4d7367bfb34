"""The scripts of the shells, as a shell or a Debian package takes them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Final

_NAMES: Final[Mapping[str, str]] = {
    "bash": "mikas.bash",
    "zsh": "_mikas",
    "fish": "mikas.fish",
    "powershell": "mikas.ps1",
}
SHELLS: Final = tuple(_NAMES)


def script(shell: str) -> str:
    """Return the script of one of `SHELLS`."""
    return Path(__file__).with_name(_NAMES[shell]).read_text("utf-8")
