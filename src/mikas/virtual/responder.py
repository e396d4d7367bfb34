"""The virtual unit's responses to requests: every row of §3, from body to body.

It knows no wire and no time to wait: `ecu` decides when. Not simulated: what a jump
(41) would do, and that writing CODE can stop a real unit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

from mikas import commands as c
from mikas.virtual.memory import EcuMemory
from mikas.virtual.quirks import EcuQuirks, LongList, Unknown

ERASE_CELL = 0x0E

Stream = c.StreamCyclic | c.StreamAtStroke
Answer = bytes | Stream | None  # a body, a stream to begin, or silence


class Car(Protocol):
    """The source of a unit's data: the engine model, a fixed table, a recording."""

    codes: tuple[int, ...]
    faults: list[int]

    def size_of(self, code: int) -> int | None:
        """Bytes of the parameter's datum; None: there is no such parameter."""

    def raw(self, code: int, now: float) -> bytes:
        """The parameter's datum at `now`."""

    def write(self, code: int, data: bytes) -> bool:
        """Write a datum of the right size; False: it is read-only."""

    def powered(self, now: float) -> bool:
        """Whether the unit has supply at `now`."""

    def next_change(self, after: float) -> float:
        """When `powered` changes next; infinity if never."""

    def next_stroke(self, stroke: int, after: float) -> float:
        """When the engine next reaches this stroke (D15); infinity if it stands."""

    def power_cycle(self) -> None:
        """The supply went off: forgets what does not survive that."""


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
        """Forgets what does not survive the supply going off."""
        self._list = ()
        self._erase_armed = False
        self.memory.power_cycle()
        self.car.power_cycle()

    def answer(self, body: bytes, now: float) -> Answer:
        """Return the response to the request `body` that came at `now`."""
        if body != b"\x62\x0e\x00":
            self._erase_armed = False  # only two writes in a row erase
        if body[:1] and body[0] in self.quirks.missing:
            return self._unknown()
        if body == b"\x63":
            return self.data(self._list, now) if self._list else b"\x01"
        try:
            command = c.parse(body, self.car.size_of)
        except c.MalformedRequest:
            return self._unknown()
        return self._perform(command, now)

    def data(self, parameters: tuple[c.Datum, ...], now: float) -> bytes | None:
        """Return the data of `parameters`, or the response to too long a list (D11)."""
        if len(parameters) > self.quirks.max_list:
            if self.quirks.long_list is LongList.SILENT:
                return self._unknown()
            parameters = parameters[: self.quirks.max_list]
        return b"".join(self.car.raw(p.code, now) for p in parameters)

    def _unknown(self) -> bytes | None:
        return b"\x01" if self.quirks.unknown is Unknown.ERROR else None

    def _perform(self, command: c.Command[Any], now: float) -> Answer:
        match command:
            case c.StreamCyclic() | c.StreamAtStroke():
                too_long = len(command.parameters) > self.quirks.max_list
                if too_long and self.quirks.long_list is LongList.SILENT:
                    return self._unknown()
                return command
            case c.ReadParameters(parameters):
                return self.data(parameters, now)
            case c.WriteList(parameters):
                if len(parameters) > self.quirks.max_list:
                    return b"\x01"
                self._list = parameters
                return b"\x00"
            case c.WriteParameter(parameter, data):
                return b"\x00" if self._write_parameter(parameter, data) else b"\x01"
            case c.ReadFaults():
                return command.respond(tuple(self.car.faults))
            case c.GoTo():
                return None
        if type(command) in _IDENTITY:
            return self._identify(command)
        return self._access_memory(command)

    def _identify(self, command: c.Command[Any]) -> bytes:
        match command:
            case c.ReadProgramPassport(part):
                return command.respond(self.identity.passports[part - 1])
            case c.ReadDataPassport(part):
                return command.respond(self.identity.passports[part + 2])
            case c.CountParameters():
                count = self.identity.parameter_count
                return command.respond(min(0xFF, len(self.car.codes)) if count is None else count)
            case _:
                return command.respond(self.identity.version_code)

    def _write_parameter(self, code: int, data: bytes) -> bool:
        if code == ERASE_CELL:
            return self._erase(data)
        return self.car.size_of(code) == len(data) and self.car.write(code, data)

    def _erase(self, data: bytes) -> bool:
        if data == b"\x00" and self._erase_armed:
            self.car.faults.clear()
        self._erase_armed = data == b"\x08"
        return data in (b"\x08", b"\x00")

    def _access_memory(self, command: c.Command[Any]) -> bytes | None:
        memory, largest = self.memory, self.quirks.max_block
        match command:
            case (
                c.ReadRamBlock(address, n)
                | c.ReadXramBlock(address, n)
                | c.ReadCodeBlock(address, n)
            ):
                if n > largest:
                    return self._unknown()
                counted = self.quirks.counted_blocks or isinstance(command, c.ReadRamBlock)
                return command.respond(memory.read(command.SPACE, address, n), counted=counted)
            case (
                c.WriteRamBlock(address, data)
                | c.WriteXramBlock(address, data)
                | c.WriteCodeBlock(address, data)
            ):
                if len(data) > largest:
                    return b"\x01"
                memory.write(command.SPACE, address, data)
                return b"\x00"
            case (
                c.WriteRamByte(address, value)
                | c.WriteXramByte(address, value)
                | c.WriteCodeByte(address, value)
                | c.WriteSfr(address, value)
            ):
                memory.write(command.SPACE, address, bytes([value]))
                return command.respond(value)
            case (
                c.ReadRamByte(address)
                | c.ReadXramByte(address)
                | c.ReadCodeByte(address)
                | c.ReadSfr(address)
            ):
                return command.respond(memory.read(command.SPACE, address)[0])
        raise AssertionError(f"{command.name} has no answer")  # a bug: a class was added without


_IDENTITY = (c.Availability, c.ReadProgramPassport, c.ReadDataPassport, c.CountParameters)
