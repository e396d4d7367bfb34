"""A hex dump: sixteen bytes a line, with their characters in code page 866."""

from __future__ import annotations

from collections.abc import Iterator


def hexdump(data: bytes, address: int) -> Iterator[str]:
    """Yield lines like `0040  45 6A 8F …  Ej…`, each starting at a multiple of 16."""
    start = address - address % 16
    end = address + len(data)
    for line in range(start, end, 16):
        cells = [
            f"{data[at - address]:02X}" if address <= at < end else "  "
            for at in range(line, line + 16)
        ]
        shown = "".join(
            _character(data[at - address]) if address <= at < end else " "
            for at in range(line, line + 16)
        )
        yield f"{line:04X}  {' '.join(cells[:8])}  {' '.join(cells[8:])}  {shown.rstrip()}"


def _character(value: int) -> str:
    character = bytes([value]).decode("cp866")
    return character if character.isprintable() else "."
