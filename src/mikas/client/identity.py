"""Identity of the ECU: model, passports, number of parameters (§3, D10)."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import TypeVar

from mikas import commands as c
from mikas.catalog import Model
from mikas.client.limits import Limits
from mikas.errors import NotSupported
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


def read_passport_in_steps(tester: Tester) -> Generator[None, None, Passport]:
    """Read the passports: eight requests, fewer if the unit refuses the first of a kind.

    Yields after each request, when the line is free.
    """
    program = yield from _pieces(tester, c.ReadProgramPassport)
    data = yield from _pieces(tester, c.ReadDataPassport)
    return Passport(program, data)


def _pieces(
    tester: Tester, kind: type[c.ReadProgramPassport | c.ReadDataPassport]
) -> Generator[None, None, tuple[str | None, ...]]:
    pieces: list[str | None] = []
    for part in range(1, len(kind.CODES) + 1):
        if pieces == [None]:
            break
        pieces.append(_request_if_known(tester, kind(part)))
        yield
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
