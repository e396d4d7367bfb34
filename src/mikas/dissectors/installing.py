"""The folders in which a user's programs look for decoders, and putting one there.

Only a file of our own is replaced: its first line says so.
"""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from pathlib import Path

from mikas.errors import UsageError, naming_file
from mikas.home import expanded, home
from mikas.i18n import Text
from mikas.saving import save

_PROC = Path("/proc")
_PATIENCE = 10  # s for the list of programs
_NOT_OURS = Text(
    "{file} was not written by mikas, so it is left as it is",
    "{file} создан не программой mikas, поэтому остаётся как есть",
)
_MOVE_IT = Text(
    "Move or remove that file, then try again.",
    "Переместите или удалите этот файл и повторите.",
)


def plugin_file() -> Path:
    """Return the path of the dissector among this user's Lua plugins of Wireshark."""
    if sys.platform == "win32":
        roaming = os.environ.get("APPDATA") or home() / "AppData" / "Roaming"
        return Path(roaming) / "Wireshark" / "plugins" / "mikas.lua"
    return home() / ".local" / "lib" / "wireshark" / "plugins" / "mikas.lua"


def decoder_file(folder: Path | None = None) -> Path:
    """Return the path of the decoder in a folder of sigrok's decoders; None: in the user's.

    That is SIGROKDECODE_DIR, else what GLib's `g_get_user_data_dir` gives, on macOS as on Linux.
    sigrok imports each folder there as a Python module, and takes `Decoder` from it. So a folder
    `mikas` with nothing but an `__init__.py` is a whole decoder.
    """
    return (folder or _decoders()) / "mikas" / "__init__.py"


def _decoders() -> Path:
    if named := os.environ.get("SIGROKDECODE_DIR", "").strip():
        return Path(named)
    data = os.environ.get("XDG_DATA_HOME", "").strip()
    if not data and sys.platform == "win32":
        data = os.environ.get("LOCALAPPDATA", "").strip() or "~/AppData/Local"
    return expanded(data or "~/.local/share") / "libsigrokdecode" / "decoders"


def install(file: Path, text: str, mark: str) -> bool:
    """Write `text`, which begins with `mark`, to `file`; return whether it differed.

    UsageError: another file of that name, which does not begin with `mark`; or the system's reason.
    """
    with naming_file(file):
        present = _text_in(file) if file.exists() else None
        if present == text:
            return False
        if present is not None and not present.startswith(mark):
            raise UsageError(problem=_NOT_OURS.filled(file=file), advice=_MOVE_IT)
        file.parent.mkdir(parents=True, exist_ok=True)
        save(file, text)
    return True


def _text_in(file: Path) -> str:
    """Return the text of a file; of a folder or a pipe, which is not ours, none."""
    return file.read_text("utf-8", "replace") if file.is_file() else ""


def is_running(program: str) -> bool:
    """Return whether a program of this name runs; False where the system does not say."""
    wanted = program.lower()
    return any(name.lower().removesuffix(".exe") == wanted for name in _running())


def _running() -> list[str]:
    """Return the names of the programs that run."""
    try:
        if _PROC.is_dir():
            return [_name(each) for each in _PROC.iterdir() if each.name.isdecimal()]
        if sys.platform == "win32":
            rows = csv.reader(_printed("tasklist", "/fo", "csv", "/nh").splitlines())
            return [row[0] for row in rows if row]
        return [Path(each).name for each in _printed("ps", "-A", "-o", "comm=").splitlines()]
    except (OSError, subprocess.SubprocessError):
        return []


def _name(process: Path) -> str:
    try:
        return (process / "comm").read_text("utf-8", "replace").strip()
    except OSError:  # it has ended
        return ""


def _printed(*command: str) -> str:
    result = subprocess.run(
        command, capture_output=True, check=True, text=True, errors="replace", timeout=_PATIENCE
    )
    return result.stdout
