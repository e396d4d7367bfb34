"""Where Wireshark looks for a user's Lua plugins."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Final

NAME: Final = "mikas.lua"


def plugin_file() -> Path:
    """Return the path of the dissector among this user's plugins of Wireshark."""
    if sys.platform == "win32":
        roaming = os.environ.get("APPDATA") or Path.home() / "AppData" / "Roaming"
        return Path(roaming) / "Wireshark" / "plugins" / NAME
    return Path.home() / ".local" / "lib" / "wireshark" / "plugins" / NAME
