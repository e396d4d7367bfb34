"""Identity of the ECU: passports, and a trial of every harmless command (§3, D10)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

from mikas import commands as c
from mikas.catalog import Model
from mikas.client.data import COMMON
from mikas.client.limits import Limits
from mikas.errors import EcuRefused, LineError, NoResponse, NotSupported
from mikas.tester import Tester

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Passport:
    """Three pieces of the program's passport and five of the data's.

    An empty piece is not filled in; for None the unit does not know the command.
    """

    program: tuple[str | None, ...]
    data: tuple[str | None, ...]

    @property
    def pieces(self) -> tuple[str, ...]:
        """All eight pieces, "" for a missing one; they identify a unit."""
        return tuple(piece or "" for piece in (*self.program, *self.data))

    def may_be(self, other: Passport) -> bool:
        """Whether both may be of one unit: noise can remove pieces, but not change them."""
        pairs = zip((*self.program, *self.data), (*other.program, *other.data), strict=True)
        both = [(own, others) for own, others in pairs if own is not None and others is not None]
        return all(own == others for own, others in both) and (bool(both) or self == other)

    def filled_from(self, other: Passport) -> Passport:
        """Return this passport with its missing pieces taken from `other`."""
        return Passport(_filled(self.program, other.program), _filled(self.data, other.data))


def _filled(
    pieces: tuple[str | None, ...], others: tuple[str | None, ...]
) -> tuple[str | None, ...]:
    pairs = zip(pieces, others, strict=True)
    return tuple(other if piece is None else piece for piece, other in pairs)


@dataclass(frozen=True, slots=True)
class Info:
    """Description of a unit. `parameter_count`: None if the unit does not answer 60."""

    model: Model
    version_code: int
    passport: Passport
    parameter_count: int | None
    echo: bool
    limits: Limits


def read_passport(tester: Tester) -> Passport:
    """Read the passports: eight requests, fewer if the unit refuses the first of a kind."""
    return Passport(_pieces(tester, c.ReadProgramPassport), _pieces(tester, c.ReadDataPassport))


def _pieces(
    tester: Tester, kind: type[c.ReadProgramPassport | c.ReadDataPassport]
) -> tuple[str | None, ...]:
    pieces: list[str | None] = []
    for part in range(1, len(kind.CODES) + 1):
        if pieces == [None]:
            break
        pieces.append(_request_if_known(tester, kind(part)))
    return tuple(pieces + [None] * (len(kind.CODES) - len(pieces)))


def _request_if_known(tester: Tester, command: c.Command[T]) -> T | None:
    try:
        return tester.request(command)
    except NotSupported:
        return None


def count_parameters(tester: Tester) -> int | None:
    """Send 60; None if unknown. A count of 1 is D10's `01`: no unit has a single parameter."""
    count = _request_if_known(tester, c.CountParameters())
    return None if count == 1 else count


@dataclass(frozen=True, slots=True)
class Support:
    """Whether the unit knows a command. `known` None: not tried, or uncertain."""

    command: type[c.Command[Any]]
    known: bool | None

    @property
    def name(self) -> str:
        """The source's name and the first code."""
        return f"{self.command.SOURCE_NAME} ({self.command.CODES[0]:02X})"


def try_commands(tester: Tester) -> Iterator[Support]:
    """Try every command of §3 that changes nothing. Raises `NoConnection` if the unit is gone."""
    datum = COMMON[0]  # replaced by the first that the unit knows

    def parameters() -> object:
        nonlocal datum
        for common in COMMON:
            for wanted in ((common, common), (common,)):  # some units accept one code only
                with suppress(EcuRefused, NoResponse):
                    if tester.request(c.ReadParameters(wanted)) != (b"\x01",):
                        datum = common
                        return True
        return None

    def stream() -> object:
        with tester.stream(c.StreamCyclic((datum, datum))) as responses:
            return next(responses)

    trials: dict[type[c.Command[Any]], Callable[[], object]] = {
        c.Availability: lambda: tester.request(c.Availability()),
        c.ReadFaults: lambda: tester.request(c.ReadFaults()),
        c.ReadRamByte: lambda: tester.request(c.ReadRamByte(0)),
        c.ReadXramByte: lambda: tester.request(c.ReadXramByte(0)),
        c.ReadCodeByte: lambda: tester.request(c.ReadCodeByte(0)),
        c.ReadRamBlock: lambda: tester.request(c.ReadRamBlock(0, 2)),
        c.ReadXramBlock: lambda: tester.request(c.ReadXramBlock(0, 2)),
        c.ReadCodeBlock: lambda: tester.request(c.ReadCodeBlock(0, 2)),
        c.ReadSfr: lambda: tester.request(c.ReadSfr(0x81)),
        c.ReadProgramPassport: lambda: tester.request(c.ReadProgramPassport(1)),
        c.ReadDataPassport: lambda: tester.request(c.ReadDataPassport(1)),
        c.CountParameters: lambda: count_parameters(tester),
        c.ReadParameters: parameters,
        c.StreamCyclic: stream,
    }
    for command in c.ALL_COMMANDS:
        trial = trials.get(command)
        yield Support(command, None if trial is None else _works(trial))


def _works(trial: Callable[[], object]) -> bool | None:
    try:
        return trial() is not None
    except (EcuRefused, NoResponse):
        return False
    except LineError:
        return None
