"""python -m tools.docs.generated: writes the generated files of the repository."""

from __future__ import annotations

import sys

from tools.docs.generated.writing import files
from tools.docs.pages import ROOT


def main() -> int:
    """Write the files that have changed; return the exit status."""
    for file, text in files():
        path = ROOT / file
        if not path.is_file() or path.read_text("utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8", newline="\n")
            print(file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
