"""The four memory spaces of the virtual unit: what is written is read back.

A power cycle restores RAM, XRAM and SFR; CODE keeps what was written. Unwritten cells hold a
pattern in which every byte value comes up and neighbours differ, so that a shifted or mixed-up
block is seen.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

SIZES = {"ram": 0x100, "xram": 0x10000, "code": 0x10000, "sfr": 0x100}


@cache  # a unit that gets its supply must not keep others on its event loop waiting
def pattern(space: str) -> bytes:
    """The contents of an untouched space: `37·low + 11·high + 101·space + 5`, modulo 256."""
    start = 101 * list(SIZES).index(space) + 5
    return bytes(
        (37 * (address & 0xFF) + 11 * (address >> 8) + start) & 0xFF
        for address in range(SIZES[space])
    )


class EcuMemory:
    """RAM, XRAM, CODE and SFR. Addresses are checked by the commands that carry them.

    `contents`: what stands there from the start, by space and address, over the pattern.
    """

    def __init__(self, contents: Mapping[str, Mapping[int, bytes]] | None = None) -> None:
        self._contents = contents or {}
        self._spaces = {space: self._fresh(space) for space in SIZES}

    def _fresh(self, space: str) -> bytearray:
        cells = bytearray(pattern(space))
        for address, data in self._contents.get(space, {}).items():
            cells[address : address + len(data)] = data
        return cells

    def read(self, space: str, address: int, count: int = 1) -> bytes:
        """`count` bytes from `address` on."""
        return bytes(self._spaces[space][address : address + count])

    def write(self, space: str, address: int, data: bytes) -> None:
        """Puts `data` at `address`."""
        self._spaces[space][address : address + len(data)] = data

    def power_cycle(self) -> None:
        """The supply went off and came back."""
        for space in ("ram", "xram", "sfr"):
            self._spaces[space] = self._fresh(space)
