"""The virtual unit's responses to requests: every row of §3, from body to body.

No wire and no delays: `ecu` transmits the responses. Not simulated: the effect of a jump (41), and
that writing CODE can stop a real unit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

from mikas import commands as c
from mikas.commands.base import Write
from mikas.commands.memory import ByteCommand, ReadBlock, WriteBlock, WriteByte
from mikas.virtual.memory import EcuMemory
from mikas.virtual.quirks import BadWrite, EcuQuirks, LongList, Unknown

ERASE_CELL = 0x0E

Stream = c.StreamCyclic | c.StreamAtStroke
Answer = bytes | Stream | None  # a body, a stream to begin, or silence


class Car(Protocol):
    """The source of a unit's data: the engine model, a fixed table, a recording."""

    codes: tuple[int, ...]
    faults: list[int]

    def size_of(self, code: int) -> int | None:
        """Return the size of the datum in bytes; None: no such parameter."""

    def raw(self, code: int, now: float) -> bytes:
        """Return the datum at `now`."""

    def write(self, code: int, data: bytes) -> bool:
        """Write a datum of the right size; False: it is read-only."""

    def powered(self, now: float) -> bool:
        """Return whether the unit has supply at `now`."""

    def next_change(self, after: float) -> float:
        """Return when `powered` changes next; infinity if never."""

    def next_stroke(self, stroke: int, after: float) -> float:
        """Return when the engine next reaches this stroke (D15); infinity if it stands."""

    def engine_speed(self, now: float) -> float:
        """Return the rpm that load the unit's program (D16); 0 if the data say nothing of it."""

    def power_cycle(self) -> None:
        """Forget volatile data: the supply went off."""


@dataclass(frozen=True, slots=True)
class Identity:
    """The unit's version, passports and number of parameters."""

    version_code: int = 0x0A
    passports: tuple[str, ...] = ("",) * 8  # three of the program, five of the data
    parameter_count: int | None = None  # None: as many as the car has codes


@dataclass(slots=True)
class Responder:
    """Answers requests for one unit."""

    car: Car
    identity: Identity = field(default_factory=Identity)
    quirks: EcuQuirks = field(default_factory=EcuQuirks)
    memory: EcuMemory = field(default_factory=EcuMemory)
    _list: tuple[c.Datum, ...] = ()
    _erase_armed: bool = False

    def power_cycle(self) -> None:
        """Forget volatile data: the supply went off."""
        self._list = ()
        self._erase_armed = False
        self.memory.power_cycle()
        self.car.power_cycle()

    def answer(self, body: bytes, now: float) -> Answer:
        """Return the response to the request `body` received at `now`."""
        if body != b"\x62\x0e\x00":
            self._erase_armed = False  # only two writes in a row erase
        if body[:1] and body[0] in self.quirks.missing:
            return self._unknown()
        if body == b"\x63":
            return self._data(self._list, now) if self._list else b"\x01"
        try:
            command = c.parse(body, self.size_of)
        except c.MalformedRequest:
            return self._bad_write() if body[:1] and body[0] in _WRITES else self._unknown()
        return self._perform(command, now)

    def size_of(self, code: int) -> int | None:
        """Return the size of a parameter's datum; None: the unit has no such parameter."""
        if code in self.quirks.lacking:
            return None
        return self.quirks.extra_sizes.get(code) or self.car.size_of(code)

    def response_of(self, stream: Stream, now: float) -> bytes:
        """Return one response of `stream`."""
        return self._data(stream.parameters[: self.quirks.longest_list(stream.code)], now)

    def _data(self, parameters: tuple[c.Datum, ...], now: float) -> bytes:
        return b"".join(self._raw(p.code, now) for p in parameters)

    def _raw(self, code: int, now: float) -> bytes:
        size = self.quirks.extra_sizes.get(code)
        return self.car.raw(code, now) if size is None else extra_datum(code, size)

    def _unknown(self) -> bytes | None:
        return self.quirks.unknown_body if self.quirks.unknown is Unknown.ERROR else None

    def _bad_write(self) -> bytes | None:
        return b"\x01" if self.quirks.bad_write is BadWrite.ERROR else None

    def _perform(self, command: c.Command[Any], now: float) -> Answer:
        match command:
            case c.StreamCyclic() | c.StreamAtStroke() | c.ReadParameters():
                longest = self.quirks.longest_list(command.code)
                too_long = len(command.parameters) > longest
                if too_long and self.quirks.long_list is LongList.SILENT:
                    return self._unknown()
                if isinstance(command, c.ReadParameters):
                    return self._data(command.parameters[:longest], now)
                return command
            case c.WriteList(parameters):
                if len(parameters) > self.quirks.longest_list(command.code):
                    return self._bad_write()
                self._list = parameters
                return b"\x00"
            case c.WriteParameter(parameter, data):
                written = self._write_parameter(parameter, data)
                return b"\x00" if written else self._bad_write()
            case c.ReadFaults():
                return command.respond(tuple(self.car.faults))
            case c.GoTo():
                return None
        return self._identify(command) or self._access_memory(command)

    def _identify(self, command: c.Command[Any]) -> bytes | None:
        match command:
            case c.Availability():
                return command.respond(self.identity.version_code)
            case c.ReadProgramPassport(part):
                return command.respond(self.identity.passports[part - 1])
            case c.ReadDataPassport(part):
                return command.respond(self.identity.passports[part + 2])
            case c.CountParameters():
                count = self.identity.parameter_count
                return command.respond(min(0xFF, self._count()) if count is None else count)
        return None

    def _count(self) -> int:
        return len({*self.car.codes, *self.quirks.extra_sizes} - self.quirks.lacking)

    def _write_parameter(self, code: int, data: bytes) -> bool:
        if code == ERASE_CELL:
            return self._erase(data)
        if code in self.quirks.extra_sizes:
            return False  # D17: read-only
        return self.size_of(code) == len(data) and self.car.write(code, data)

    def _erase(self, data: bytes) -> bool:
        """Return whether `data` is the first write of the erase, or the second that follows it."""
        erases = data == b"\x00" and self._erase_armed
        if erases:
            self.car.faults.clear()
        self._erase_armed = data == b"\x08"
        return erases or self._erase_armed

    def _access_memory(self, command: c.Command[Any]) -> bytes | None:
        memory, max_block = self.memory, self.quirks.max_block
        match command:
            case ReadBlock():
                if command.count > max_block:
                    return self._unknown()
                data = memory.read(command.SPACE, command.address, command.count)
                return command.respond(data, counted=self.quirks.counted_blocks or None)
            case WriteBlock():
                if len(command.data) > max_block:
                    return self._bad_write()
                memory.write(command.SPACE, command.address, command.data)
                return b"\x00"
            case WriteByte():
                memory.write(command.SPACE, command.address, bytes([command.value]))
                return command.respond(command.value)
            case ByteCommand():
                return command.respond(memory.read(command.SPACE, command.address)[0])
        raise AssertionError(f"{command.name.en} is not implemented")


def extra_datum(code: int, size: int) -> bytes:
    """Return the datum of an extra code, which never changes: `37·code + 11·byte + 5`."""
    return bytes((37 * code + 11 * byte + 5) & 0xFF for byte in range(size))


_WRITES = frozenset(
    code for command in c.ALL_COMMANDS if issubclass(command, Write) for code in command.CODES
)
