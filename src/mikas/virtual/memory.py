"""The four memory spaces of the virtual unit."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

SIZES = {"ram": 0x100, "xram": 0x10000, "code": 0x10000, "sfr": 0x100}


@cache  # computing it at power-on would delay other units on the event loop
def pattern(space: str) -> bytes:
    """Return the contents of an unwritten space: `37·low + 11·high + 101·space + 5`, modulo 256."""
    start = 101 * list(SIZES).index(space) + 5
    page = bytes((37 * low + start) & 0xFF for low in range(0x100))
    values = bytes(range(0x100)) * 2
    pages = (11 * high & 0xFF for high in range(SIZES[space] >> 8))
    return b"".join(page.translate(values[more : more + 0x100]) for more in pages)


class EcuMemory:
    """RAM, XRAM, CODE and SFR; the commands check the addresses.

    Written bytes are read back. A power cycle restores RAM, XRAM and SFR; CODE keeps what was
    written. Unwritten cells hold `contents` (by space and address), else a pattern in which every
    byte value occurs and neighbours differ, so a shifted or swapped block is noticed.
    """

    def __init__(self, contents: Mapping[str, Mapping[int, bytes]] | None = None) -> None:
        self._contents = contents or {}
        self._spaces = {space: self._initial(space) for space in SIZES}

    def _initial(self, space: str) -> bytearray:
        cells = bytearray(pattern(space))
        for address, data in self._contents.get(space, {}).items():
            cells[address : address + len(data)] = data
        return cells

    def read(self, space: str, address: int, count: int = 1) -> bytes:
        """Return `count` bytes from `address` on."""
        return bytes(self._spaces[space][address : address + count])

    def write(self, space: str, address: int, data: bytes) -> None:
        """Write `data` at `address`."""
        self._spaces[space][address : address + len(data)] = data

    def power_cycle(self) -> None:
        """Restore the spaces that do not survive the loss of supply."""
        for space in ("ram", "xram", "sfr"):
            self._spaces[space] = self._initial(space)
