"""Where sigrok looks for a user's decoders.

It imports each folder in a folder of decoders as a Python module, and takes `Decoder` from it. So a
folder `mikas` with nothing but an `__init__.py` is a whole decoder.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path


def decoder_file(folder: Path | None = None) -> Path:
    """Return the path of the decoder in a folder of decoders; None: in the user's.

    That is SIGROKDECODE_DIR, else what GLib's `g_get_user_data_dir` gives, on macOS as on Linux.
    """
    return (folder or _decoders()) / "mikas" / "__init__.py"


def _decoders() -> Path:
    if named := os.environ.get("SIGROKDECODE_DIR", "").strip():
        return Path(named)
    data = os.environ.get("XDG_DATA_HOME", "").strip()
    if not data and sys.platform == "win32":
        data = os.environ.get("LOCALAPPDATA", "").strip() or "~/AppData/Local"
    return Path(data or "~/.local/share").expanduser() / "libsigrokdecode" / "decoders"
