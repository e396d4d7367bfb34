"""Telnet as bytes: RFC 854 with binary transmission (RFC 856). Opens nothing, knows no option.

`IAC` (FF) begins a command; a data byte FF is sent twice. Without binary transmission a carriage
return is followed by NUL or LF. Two kinds of servers do otherwise, and are understood where their
bytes have one meaning only:

- One that does not double FF: `IAC` before a byte that is no command can't come from any other.
  From then on FF is data, except before the subnegotiation of the one option in use.
- One that agrees to binary transmission and sends CR NUL all the same: the first CR shows it, as in
  this protocol no frame follows another one at once with NUL. The first CR without NUL refutes it.

Where this goes wrong, a frame has a byte too few, and does not fit its request; no value is wrong.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Final, TypeAlias

IAC: Final = 0xFF
SE: Final = 0xF0
SB: Final = 0xFA
_FIRST_COMMAND: Final = 0xEC  # EOF, the lowest that is assigned
_CR: Final = 0x0D
_NUL: Final = 0x00
MOST_SUBNEGOTIATION: Final = 1024  # bytes; the longest in use is a signature


class Verb(IntEnum):
    """Who does, or shall do, an option."""

    WILL = 0xFB
    WONT = 0xFC
    DO = 0xFD
    DONT = 0xFE


@dataclass(frozen=True, slots=True)
class Negotiation:
    """`IAC WILL 2C`."""

    verb: Verb
    option: int


@dataclass(frozen=True, slots=True)
class Subnegotiation:
    """`IAC SB 2C 65 00 00 25 80 IAC SE`: `data` are the bytes after the option."""

    option: int
    data: bytes


Event: TypeAlias = Negotiation | Subnegotiation


class _State(Enum):
    DATA = "data"
    IAC = "after IAC"
    VERB = "after IAC WILL, WONT, DO or DONT"
    SUB = "inside a subnegotiation"
    SUB_IAC = "after IAC inside a subnegotiation"


class TelnetDecoder:
    """Splits what a server sends into data and events, whatever the pieces.

    `spoken`: whether anything of Telnet came. `doubles_ff`: whether the server doubles FF, as far
    as is known. `option`: the one whose subnegotiations are understood from a server that does not.
    """

    def __init__(self, option: int) -> None:
        self.spoken: bool = False
        self.doubles_ff: bool = True
        self._option = option
        self._state = _State.DATA
        self._verb = Verb.DONT
        self._sub = bytearray()
        self._held = b""  # bytes after which FF is data or a command, of a server that mixes both
        self._after_cr = False
        self._cr_nul: bool | None = None  # whether a NUL follows each CR; None: not known yet

    def feed(self, received: bytes) -> tuple[bytes, list[Event]]:
        """Return the data in `received`, and what the server says between them."""
        data = bytearray()
        events: list[Event] = []
        for byte in received:
            match self._state:
                case _State.DATA:
                    self._in_data(byte, data)
                case _State.IAC:
                    self._after_iac(byte, data)
                case _State.VERB:
                    self.spoken = True
                    events.append(Negotiation(self._verb, byte))
                    self._state = _State.DATA
                case _State.SUB if byte == IAC:
                    self._state = _State.SUB_IAC
                case _State.SUB:
                    self._in_subnegotiation(byte)
                case _State.SUB_IAC if byte == SE:
                    self._state = _State.DATA
                    if self._sub:
                        events.append(Subnegotiation(self._sub[0], bytes(self._sub[1:])))
                case _State.SUB_IAC:
                    self._state = _State.SUB
                    self._in_subnegotiation(byte)
        return bytes(data), events

    def _in_data(self, byte: int, data: bytearray) -> None:
        if byte == IAC and self.doubles_ff:
            self._state = _State.IAC
        elif self._held or (byte == IAC and not self.doubles_ff):
            self._maybe_subnegotiation(byte, data)
        else:
            self._take(byte, data)

    def _maybe_subnegotiation(self, byte: int, data: bytearray) -> None:
        """Of a server that does not double FF: only `IAC SB` and the option in use are no data."""
        wanted = bytes([IAC, SB, self._option])
        self._held += bytes([byte])
        if self._held == wanted:
            self._held = b""
            self._sub = bytearray([self._option])
            self._state = _State.SUB
        while self._held and not wanted.startswith(self._held):
            self._take(self._held[0], data)
            self._held = self._held[1:]

    def _after_iac(self, byte: int, data: bytearray) -> None:
        self._state = _State.DATA
        if byte == IAC:
            self._take(IAC, data)
        elif byte == SB:
            self.spoken = True
            self._sub.clear()
            self._state = _State.SUB
        elif Verb.WILL <= byte <= Verb.DONT:
            self._verb = Verb(byte)
            self._state = _State.VERB
        elif byte < _FIRST_COMMAND:
            self.doubles_ff = False
            self._take(IAC, data)
            self._take(byte, data)
        else:
            self.spoken = True

    def _in_subnegotiation(self, byte: int) -> None:
        self._sub.append(byte)
        if len(self._sub) > MOST_SUBNEGOTIATION:  # it was none
            self._state = _State.DATA

    def _take(self, byte: int, data: bytearray) -> None:
        if self._after_cr:
            self._after_cr = False
            if self._cr_nul is not False and byte == _NUL:
                self._cr_nul = True
                return
            self._cr_nul = False
        self._after_cr = byte == _CR and self._cr_nul is not False
        data.append(byte)


def escaped(data: bytes, *, binary: bool = True) -> bytes:
    """Return `data` as they are sent; not `binary`: the server takes lines of text only."""
    data = data.replace(b"\xff", b"\xff\xff")
    return data if binary else data.replace(b"\r", b"\r\0")


def negotiation(verb: Verb, option: int) -> bytes:
    """Return `IAC verb option`."""
    return bytes([IAC, verb, option])


def subnegotiation(option: int, data: bytes) -> bytes:
    """Return `IAC SB option data IAC SE`."""
    return bytes([IAC, SB, option]) + escaped(data) + bytes([IAC, SE])
