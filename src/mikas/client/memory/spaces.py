"""The four memory spaces, byte by byte or in the largest blocks that the unit accepts (§3, rows
11–32). Every write passes the gate with the bytes before it, and is read back.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import ClassVar

from mikas import commands as c
from mikas import errors
from mikas.client.gate import Change, Gate
from mikas.client.limits import LimitsCache
from mikas.client.memory.writing import Attempts, SpaceWriter
from mikas.commands.base import check_byte, check_bytes, check_range
from mikas.commands.memory import ByteCommand, ReadBlock, WriteBlock, WriteByte
from mikas.i18n import Text, byte_count
from mikas.tester import Tester


def writing(count: int, where: str) -> Text:
    """Return the text for writing `count` bytes."""
    return Text("write {bytes} to {where}", "записать {bytes}, {where}").filled(
        bytes=byte_count(count), where=where
    )


@dataclass(frozen=True, slots=True)
class _Commands:
    """The command classes of one space."""

    read: type[ByteCommand]
    write: type[WriteByte]
    read_block: type[ReadBlock] | None = None
    write_block: type[WriteBlock] | None = None


_SPACES = {
    "ram": _Commands(c.ReadRamByte, c.WriteRamByte, c.ReadRamBlock, c.WriteRamBlock),
    "xram": _Commands(c.ReadXramByte, c.WriteXramByte, c.ReadXramBlock, c.WriteXramBlock),
    "code": _Commands(c.ReadCodeByte, c.WriteCodeByte, c.ReadCodeBlock, c.WriteCodeBlock),
    "sfr": _Commands(c.ReadSfr, c.WriteSfr),
}


_SMALL_BLOCK = 2
_UNREADABLE = Text(
    "Nothing was written: the bytes to be replaced can't be read first.",
    "Ничего не записано: заменяемые байты нельзя сначала прочитать.",
)


@dataclass(frozen=True, slots=True)
class Written:
    """The result of a write: the bytes before it, and those read back."""

    space: str
    """ram, xram, code or sfr."""
    address: int
    """The first address."""
    before: bytes
    """The bytes before."""
    after: bytes
    """The bytes read back."""


@dataclass(frozen=True, slots=True)
class Run:
    """Bytes to write from `address`; `before`: as many, as read from there."""

    address: int
    """The first address."""
    before: bytes
    data: bytes
    """The bytes to write."""


class MemorySpace:
    """One of the spaces, with addresses 0 … `last`. `timeout`: as of a method of `Ecu`."""

    def __init__(self, name: str, tester: Tester, gate: Gate, cache: LimitsCache) -> None:
        self.name = name
        """ram, xram, code or sfr."""
        self.last: int = c.Space(name).last
        """The highest address."""
        self._commands = _SPACES[name]
        self._tester = tester
        self._gate = gate
        self._cache = cache
        self._longest = 1  # block that this unit has returned
        self._lacks_bytes = False  # it refuses single bytes and returns a block of one
        self._writer = SpaceWriter(
            tester=tester,
            byte=self._commands.write,
            block=self._commands.write_block,
            read_block=self.read_block,
            largest=lambda: cache.limits().block(name),
        )

    def read(self, address: int, *, timeout: float | None = None) -> int:
        """Read the byte at `address`. Raises `AddressOutOfRange`, `NotSupported`."""
        with self._tester.within(timeout):
            return self._one(address)

    def _one(self, address: int) -> int:
        byte, block = self._commands.read(address), self._commands.read_block
        if block is not None and self._lacks_bytes:
            with suppress(errors.NotSupported):
                return self._tester.request(block(address, 1))[0]
        try:
            return self._tester.request(byte)
        except errors.NotSupported:
            if block is not None:  # a unit may lack the other form
                with suppress(errors.EcuRefused, errors.LineError):
                    (value,) = self._tester.request(block(address, 1))
                    self._lacks_bytes = True
                    return value
            raise

    def read_block(self, address: int, count: int, *, timeout: float | None = None) -> bytes:
        """Read `count` bytes from `address`. Raises `AddressOutOfRange`, `NotSupported`."""
        with self._tester.within(timeout):
            return b"".join(self.blocks(address, count))

    def blocks(self, address: int, count: int, largest: int | None = None) -> Iterator[bytes]:
        """Yield the bytes of `read_block` block by block, each of at most `largest` (1 … 255).

        Raises `AddressOutOfRange` and `UsageError` before the first request.
        """
        check_range(self.name, address, count)
        if largest is None:
            largest = c.LARGEST_BLOCK
        if not 1 <= largest <= c.LARGEST_BLOCK:
            raise errors.usage_error("a block has 1 to 255 bytes", "в блоке от 1 до 255 байт")
        return self._walk(address, address + count, largest)

    def _walk(self, address: int, end: int, largest: int) -> Iterator[bytes]:
        while address < end:
            data = self._some(address, min(largest, end - address))
            yield data
            address += len(data)

    def _some(self, address: int, count: int) -> bytes:
        """Read up to `count` bytes in one exchange; halve a block too long for the unit (D11).

        A limit is learnt only if a smaller block succeeds and the larger one fails again, so not
        from a lost response or an unreadable address.
        """
        wanted = count = min(count, self._cache.limits().block(self.name))
        refused = 0
        while self._commands.read_block and count > 1:
            try:
                data = self._block(address, count)
            except (errors.NotSupported, errors.NoResponse, errors.WrongLength):
                if count <= self._longest:
                    raise
                if not self._has_blocks(address, count):
                    break
                refused, count = count, count // 2
            else:
                if refused:
                    with suppress(errors.EcuRefused, errors.LineError):
                        data = self._block(address, refused)
                    self._learn(len(data), wanted)
                return data
        byte = self.read(address)  # raises if not even single bytes can be read
        self._learn(1, wanted)
        return bytes([byte])

    def _block(self, address: int, count: int) -> bytes:
        assert self._commands.read_block is not None
        command = self._commands.read_block(address, count)
        # A block that may be too long is repeated only once: a smaller one is the better attempt.
        data, _ = self._tester.exchange(command, retries=1 if count > self._longest else None)
        self._longest = max(self._longest, count)
        return data

    def _has_blocks(self, address: int, count: int) -> bool:
        """Whether the unit knows the block form."""
        if self._longest == 1 and count > _SMALL_BLOCK:
            with suppress(errors.EcuRefused, errors.LineError):
                self._block(address, _SMALL_BLOCK)
        return self._longest > 1

    def _learn(self, count: int, wanted: int) -> None:
        if count < wanted and self._commands.read_block:
            self._cache.limits().max_block[self.name] = count
            self._cache.keep()

    def write(self, address: int, value: int, *, timeout: float | None = None) -> Written:
        """Write one byte and read it back. Raises as `write_block`."""
        check_byte(self.name, value)
        return self.write_block(address, bytes([value]), timeout=timeout)

    def write_block(self, address: int, data: bytes, *, timeout: float | None = None) -> Written:
        """Write `data` from `address` in blocks and read it back, with one confirmation.

        Raises `AddressOutOfRange`, `NotConfirmed`, `WriteRefused`, `NotSupported`,
        `ReadBackDiffers`.
        """
        check_bytes(data)
        with self._tester.within(timeout):
            return self._write(address, bytes(data))

    def write_runs(self, runs: Sequence[Run], what: Text) -> Iterator[Written]:
        """Confirm `what` once, then write `runs` one by one; yield each with the bytes read back.

        Those may differ from the wanted ones: a cell that keeps another value ends nothing. Every
        run has its own journal entries. Raises as `write_block`, but no `ReadBackDiffers`.
        """
        for run in runs:
            check_range(self.name, run.address, len(run.data))
        if runs:
            first = runs[0]
            planned = self._writer.planned(first.address, first.data)
            self._gate.ask(Change.by(planned, what, name=self.name, address=first.address))
        return map(self._write_run, runs)

    def _write_run(self, run: Run) -> Written:
        try:
            return self._write(run.address, run.data, in_parts=True)
        except errors.ReadBackDiffers:  # a byte kept another value; those after it may be unsent
            now = self.read_block(run.address, len(run.data))
            for offset, (value, stored) in enumerate(zip(run.data, now, strict=True)):
                if value != stored:
                    with suppress(errors.ReadBackDiffers):
                        self._write(run.address + offset, bytes([value]), in_parts=True)
            after = self.read_block(run.address, len(run.data))
            return Written(self.name, run.address, run.before, after)

    def _write(self, address: int, data: bytes, *, in_parts: bool = False) -> Written:
        """Write and read back; `in_parts`: as confirmed before, whatever bytes are read back."""
        check_range(self.name, address, len(data))
        where = f"{self.name} {address:04X}"
        what = writing(len(data), where)
        self._gate.refuse_unasked(what, self._commands.write.SAFETY)
        try:
            before = self.read_block(address, len(data))
        except errors.NotSupported as error:
            error.advice = _UNREADABLE
            raise
        change = Change.by(
            self._writer.planned(address, data),
            what,
            before,
            data,
            name=self.name,
            address=address,
            old=_in_hex(before),
            new=_in_hex(data),
        )
        attempts = Attempts()

        def act() -> Written:
            try:
                self._writer.write(address, data, before, attempts)
                after = self.read_block(address, len(data))
                if not in_parts:
                    self._check(address, data, after)
            except errors.MikasError as error:
                standing = self._writer.standing(address, data, before)
                error.advice = Text(
                    f"{error.advice.en} {standing.en}", f"{error.advice.ru} {standing.ru}"
                )
                raise
            return Written(self.name, address, before, after)

        return self._gate.make(
            change,
            act,
            lambda written: written.after,
            lambda: attempts.names,
            approved=in_parts,
        )

    def _check(self, address: int, data: bytes, after: bytes) -> None:
        """Raise `ReadBackDiffers` with the bytes of `after` from the first to the last wrong."""
        wrong = [i for i, pair in enumerate(zip(data, after, strict=True)) if pair[0] != pair[1]]
        if wrong:
            first, end = wrong[0], wrong[-1] + 1
            raise errors.ReadBackDiffers(
                name=f"{self.name} {address + first:04X}",
                wanted=errors.hex_dump(data[first:end]),
                got=errors.hex_dump(after[first:end]),
            )


def _in_hex(data: bytes) -> Text:
    shown = errors.hex_dump(data)
    return Text(shown, shown)


class Memory:
    """`memory.ram`, `.xram`, `.code`, `.sfr`; or by name, `memory["ram"]`."""

    ram: MemorySpace
    """Internal RAM."""
    xram: MemorySpace
    """External RAM."""
    code: MemorySpace
    """Program memory."""
    sfr: MemorySpace
    """Special function registers."""

    NAMES: ClassVar[tuple[str, ...]] = tuple(_SPACES)
    """The names of the four spaces."""

    def __init__(self, tester: Tester, gate: Gate, cache: LimitsCache) -> None:
        self.ram, self.xram, self.code, self.sfr = (
            MemorySpace(name, tester, gate, cache) for name in _SPACES
        )

    def __getitem__(self, name: str) -> MemorySpace:
        if name not in _SPACES:
            known = ", ".join(_SPACES)
            raise errors.usage_error(
                f"there is no memory space “{name}”; there are {known}",
                f"области памяти «{name}» нет; есть {known}",
            )
        space: MemorySpace = getattr(self, name)
        return space
