"""The four memory spaces, byte by byte or in the largest blocks that the unit takes (§3, rows
11–32).

Reading never changes anything. Every write goes through the gate, which sees what was there before,
and is read back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from mikas import commands as c
from mikas.client.gate import Change, Gate, hexed
from mikas.client.limits import Limits
from mikas.commands.base import check_byte, check_range
from mikas.errors import (
    EcuRefused,
    LineError,
    NoResponse,
    NotSupported,
    ReadBackDiffers,
    WriteRefused,
    WrongLength,
)
from mikas.language import Text
from mikas.tester import Tester


@dataclass(frozen=True, slots=True)
class _Commands:
    """The command classes of one space."""

    last: int
    read: type[c.ReadRamByte | c.ReadXramByte | c.ReadCodeByte | c.ReadSfr]
    write: type[c.WriteRamByte | c.WriteXramByte | c.WriteCodeByte | c.WriteSfr]
    read_block: type[c.ReadRamBlock | c.ReadXramBlock | c.ReadCodeBlock] | None = None
    write_block: type[c.WriteRamBlock | c.WriteXramBlock | c.WriteCodeBlock] | None = None


_SPACES = {
    "ram": _Commands(0xFF, c.ReadRamByte, c.WriteRamByte, c.ReadRamBlock, c.WriteRamBlock),
    "xram": _Commands(0xFFFF, c.ReadXramByte, c.WriteXramByte, c.ReadXramBlock, c.WriteXramBlock),
    "code": _Commands(0xFFFF, c.ReadCodeByte, c.WriteCodeByte, c.ReadCodeBlock, c.WriteCodeBlock),
    "sfr": _Commands(0xFF, c.ReadSfr, c.WriteSfr),
}


_SMALL_BLOCK = 2


@dataclass(frozen=True, slots=True)
class Written:
    """What a write did: the bytes that were there, and those that were read back."""

    space: str
    address: int
    before: bytes
    after: bytes


class MemorySpace:
    """One of the spaces. Addresses are 0 … `last`."""

    def __init__(
        self,
        name: str,
        tester: Tester,
        gate: Gate,
        limits: Callable[[], Limits],
        learnt: Callable[[], None],
    ) -> None:
        self.name = name
        self._commands = _SPACES[name]
        self._tester = tester
        self._gate = gate
        self._limits = limits
        self._learnt = learnt

    @property
    def last(self) -> int:
        """The highest address."""
        return self._commands.last

    def read(self, address: int) -> int:
        """The byte at `address`. Raises `AddressOutOfRange`, `NotSupported`."""
        return self._tester.request(self._commands.read(address))

    def read_block(self, address: int, count: int) -> bytes:
        """`count` bytes from `address` on."""
        return b"".join(self.blocks(address, count))

    def blocks(self, address: int, count: int, largest: int | None = None) -> Iterator[bytes]:
        """`read_block`, block by block as they come, so that progress shows.

        `largest`: an upper bound for the blocks. Raises `AddressOutOfRange` before anything is
        sent.
        """
        check_range(self.name, self.last, address, count)
        end = address + count
        return self._walk(address, end, largest or c.LARGEST_BLOCK)

    def _walk(self, address: int, end: int, largest: int) -> Iterator[bytes]:
        while address < end:
            data = self._some(address, min(largest, end - address))
            yield data
            address += len(data)

    def _some(self, address: int, count: int) -> bytes:
        """Up to `count` bytes, in one exchange; halves what is too much for the unit (D11)."""
        block, limits = self._commands.read_block, self._limits()
        count = min(count, limits.block(self.name))
        while block and count > 1:
            try:
                return self._tester.request(block(address, count))
            except (NotSupported, NoResponse, WrongLength):
                if self._tester.has_answered(block.CODES[0]) or (
                    count > _SMALL_BLOCK and self._takes(block(address, _SMALL_BLOCK))
                ):
                    count //= 2
                else:
                    self.read(address)  # not even single bytes: then this says so
                    count = 1
                limits.max_block[self.name] = count
                self._learnt()
        return bytes([self.read(address)])

    def _takes(self, command: c.Command[bytes]) -> bool:
        """Whether the unit has the block form at all."""
        try:
            self._tester.request(command)
        except (EcuRefused, LineError):
            return False
        return True

    def write(self, address: int, value: int) -> Written:
        """Writes one byte and reads it back.

        Raises `NotConfirmed`, `WriteRefused`, `ReadBackDiffers`.
        """
        check_byte(self.name, value)
        return self.write_block(address, bytes([value]))

    def write_block(self, address: int, data: bytes) -> Written:
        """Writes `data` from `address` on, in blocks, and reads them back; one question for all."""
        check_range(self.name, self.last, address, len(data))
        before = self.read_block(address, len(data))
        where = f"{self.name} {address:04X}"
        change = Change(
            what=Text(
                f"write {len(data)} byte(s) to {where}", f"записать байтов: {len(data)}, {where}"
            ),
            safety=self._commands.write.SAFETY,
            command=self._commands.write.SOURCE_NAME,
            before=hexed(before),
            after=hexed(data),
        )

        def act() -> Written:
            self._send(address, data)
            after = self.read_block(address, len(data))
            if after != data:
                raise ReadBackDiffers(name=where, wanted=hexed(data), got=hexed(after))
            return Written(self.name, address, before, after)

        return self._gate.make(change, act, lambda written: hexed(written.after))

    def _send(self, address: int, data: bytes) -> None:
        while data:
            count = min(len(data), self._limits().block(self.name))
            part, data = data[:count], data[count:]
            if self._commands.write_block is None or count == 1:
                for offset, value in enumerate(part):
                    self._send_byte(address + offset, value)
            else:
                self._send_part(self._commands.write_block, address, part)
            address += count

    def _send_part(
        self,
        block: type[c.WriteRamBlock | c.WriteXramBlock | c.WriteCodeBlock],
        address: int,
        part: bytes,
    ) -> None:
        try:
            self._tester.request(block(address, part))
        except (WriteRefused, NotSupported):
            # It may only lack the block form: its bytes are the same change, already approved.
            for offset, value in enumerate(part):
                self._send_byte(address + offset, value)

    def _send_byte(self, address: int, value: int) -> None:
        answered = self._tester.request(self._commands.write(address, value))
        if answered != value:
            raise ReadBackDiffers(
                name=f"{self.name} {address:04X}", wanted=f"{value:02X}", got=f"{answered:02X}"
            )


class Memory:
    """`memory.ram`, `.xram`, `.code`, `.sfr`; or by name, `memory["ram"]`."""

    def __init__(
        self,
        tester: Tester,
        gate: Gate,
        limits: Callable[[], Limits],
        learnt: Callable[[], None],
    ) -> None:
        self.ram, self.xram, self.code, self.sfr = (
            MemorySpace(name, tester, gate, limits, learnt) for name in _SPACES
        )

    def __getitem__(self, name: str) -> MemorySpace:
        if name not in _SPACES:
            raise KeyError(name)
        space: MemorySpace = getattr(self, name)
        return space
