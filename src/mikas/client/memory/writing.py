"""Writing to one memory space, in the form that the unit has (§3, rows 12–16, 22–26, 32; D8).

A unit may lack the single bytes (12, 14, 16) or the blocks (22, 24, 26), and may accept shorter
blocks than it sends. What it refuses by `01` or by silence (D10, D17) is tried in the other form.
After silence or a damaged answer, reading back shows whether the bytes were written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field

from mikas import commands as c
from mikas import errors
from mikas.commands.memory import WriteBlock, WriteByte
from mikas.i18n import Text
from mikas.tester import Tester

_LACKS_BLOCKS = 2  # writes in which blocks were refused, perhaps only by a bad line
_SFR_ONLY = Text(
    "An SFR is written by this command only: there is no block form.",
    "SFR записывается только этой командой: блочной формы у неё нет.",
)
_NOTHING_READ = Text(
    "The bytes could not be read back, so which of them were written is unknown; the journal has "
    "the bytes before.",
    "Прочитать байты после этого не удалось, и неизвестно, какие из них записаны; прежние байты "
    "есть в журнале.",
)
_ALL = Text("Read back: all bytes are as wanted.", "Проверено чтением: все байты такие, как нужно.")
_NONE = Text("Read back: nothing was changed.", "Проверено чтением: ничего не изменено.")


@dataclass(slots=True)
class Attempts:
    """The commands of one write, in order. `accepted`: those that have written bytes."""

    sent: list[WriteByte | WriteBlock] = field(default_factory=list)
    accepted: list[WriteByte | WriteBlock] = field(default_factory=list)

    @property
    def names(self) -> str:
        """The source's names of the accepted commands; of all, if none was accepted."""
        return ", ".join(dict.fromkeys(c.SOURCE_NAME for c in self.accepted or self.sent))


@dataclass(slots=True, eq=False, kw_only=True)
class SpaceWriter:
    """Writes to one space; remembers the form that this unit accepts.

    `block` None: the space has none. `read_block` reads back; `largest` returns the longest block
    that the unit can send (D11).
    """

    tester: Tester
    byte: type[WriteByte]
    block: type[WriteBlock] | None
    read_block: Callable[[int, int], bytes]
    largest: Callable[[], int]
    _longest: int = 0  # block that this unit has accepted
    _most: int = c.LARGEST_BLOCK  # a longer one was refused
    _without_blocks: int = 0  # writes that took single bytes after a block was refused

    def planned(self, address: int, data: bytes) -> WriteByte | WriteBlock:
        """Return the command that `write` sends first."""
        return next(self._ways(address, data[: self._count(data)]))

    def write(self, address: int, data: bytes, before: bytes, attempts: Attempts) -> None:
        """Write `data` from `address`, where `before` was read; list the commands in `attempts`.

        Raises `WriteRefused`, `NotSupported`, `ReadBackDiffers`, a `LineError` or a `NoConnection`;
        some of the bytes may be written then.
        """
        if not self._longest and self._without_blocks < _LACKS_BLOCKS:
            self._most = c.LARGEST_BLOCK
        done = 0
        while done < len(data):
            done += self._some(address + done, data[done:], before[done:], attempts)

    def _count(self, data: bytes) -> int:
        return min(len(data), self._most, self.largest())

    def _some(self, address: int, data: bytes, before: bytes, attempts: Attempts) -> int:
        """Write the first bytes of `data` in one exchange; return how many."""
        count = self._count(data)
        refused: dict[WriteByte | WriteBlock, errors.MikasError] = {}
        for command in self._ways(address, data[:count]):
            size = len(_bytes_of(command))
            attempts.sent.append(command)
            try:
                self._send(command, before[:size])
            except (errors.WriteRefused, errors.NotSupported, errors.NoResponse) as error:
                if isinstance(error, errors.NoResponse) and not self._may_be_too_long(command):
                    raise
                refused[command] = error
                continue
            attempts.accepted.append(command)
            if isinstance(command, WriteBlock):
                self._longest = max(self._longest, size)
            if size < count:
                self._most = count // 2 if self._longest else 1
                self._without_blocks += not self._longest
            return size
        first = next(iter(refused.values()))
        first.advice = self._advice(list(refused))
        raise first

    def _ways(self, address: int, data: bytes) -> Iterator[WriteByte | WriteBlock]:
        """Yield the commands that write all of `data`, or its first byte; the best one first."""
        byte = self.byte(address, data[0])
        if self.block is None:
            yield byte
            return
        if len(data) > 1:
            yield self.block(address, data)
        block = self.block(address, data[:1])
        lacks_bytes = self._longest and not self.tester.has_answered(byte.code)
        yield from (block, byte) if lacks_bytes else (byte, block)

    def _may_be_too_long(self, command: WriteByte | WriteBlock) -> bool:
        return isinstance(command, WriteBlock) and len(command.data) > self._longest

    def _send(self, command: WriteByte | WriteBlock, before: bytes) -> None:
        """Send `command`, again if the line failed and nothing was written; `before`: as read.

        The bytes at that place decide: an answer alone does not show whether they were written.
        """
        wanted = _bytes_of(command)
        repetitions = 0
        while True:
            try:
                got = self._request(command)
            except (errors.LineError, errors.NotSupported) as error:
                if isinstance(error, errors.ReadingSuspended) and not error.is_short:
                    raise  # perhaps another unit answers by now
                if isinstance(error, errors.NotSupported) and error.received:
                    raise  # refused by 01 (D10)
                known = self.tester.has_answered(command.code)
                now = self._stored(command.address, len(wanted))
                if now == wanted and (known or wanted != before):
                    return  # only the answer was lost
                again = known and now == before and not self._may_be_too_long(command)
                if self.block is None or not again or repetitions == self.tester.retries:
                    raise  # an SFR is never written twice: that may act twice
                repetitions += 1
            else:
                if got is not None and got != wanted[0]:
                    raise errors.ReadBackDiffers(
                        name=f"{command.SPACE} {command.address:04X}",
                        wanted=errors.hex_dump(wanted),
                        got=f"{got:02X}",
                    )
                return

    def _request(self, command: WriteByte | WriteBlock) -> int | None:
        """Send `command`; return the byte that its answer repeats, None for a block."""
        if isinstance(command, WriteBlock):
            self.tester.request(command)
            return None
        return self.tester.request(command)

    def _stored(self, address: int, count: int) -> bytes | None:
        with suppress(errors.MikasError):
            return self.read_block(address, count)
        return None

    def _advice(self, refused: list[WriteByte | WriteBlock]) -> Text:
        if self.block is None:
            return _SFR_ONLY
        names = ", ".join(dict.fromkeys(command.name.en for command in refused))
        return Text(f"Tried without success: {names}.", f"Безуспешно испробованы: {names}.")

    def standing(self, address: int, data: bytes, before: bytes) -> Text:
        """Read back after a failed write; return which bytes the unit has now."""
        now = self._stored(address, len(data))
        if now is None:
            return _NOTHING_READ
        if now == before:
            return _NONE
        if now == data:
            return _ALL
        done = next(i for i, pair in enumerate(zip(now, data, strict=True)) if pair[0] != pair[1])
        if now[done:] == before[done:]:
            last = address + done - 1
            en = f"the first {done} of {len(data)} bytes ({address:04X}–{last:04X}) are new, the "
            ru = f"новые — первые {done} из {len(data)} ({address:04X}–{last:04X}), "
            found = Text(f"{en}others are as before", f"{ru}остальные прежние")
        else:
            found = Text(errors.hex_dump(now), errors.hex_dump(now, "байт"))
        return Text(
            f"Some of the bytes were written. Read back: {found.en}. The journal has the bytes "
            "before.",
            f"Часть байтов записана. Проверено чтением: {found.ru}. Прежние байты есть в журнале.",
        )


def _bytes_of(command: WriteByte | WriteBlock) -> bytes:
    return command.data if isinstance(command, WriteBlock) else bytes([command.value])
