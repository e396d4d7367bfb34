"""Identity of the ECU: model, passports, number of parameters (§3, D10)."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from itertools import zip_longest
from typing import NamedTuple, TypeVar

from mikas import commands as c
from mikas.catalog import Model
from mikas.client.limits import Limits
from mikas.errors import LineError, NotSupported, SyncLost
from mikas.tester import Tester

T = TypeVar("T")

_KINDS = (c.ReadProgramPassport, c.ReadDataPassport)
_PASSPORTS = tuple(kind(part + 1) for kind in _KINDS for part in range(len(kind.CODES)))
_ATTEMPTS = 3  # that fail in a row, each repeated by the tester


@dataclass(frozen=True, slots=True)
class Passport:
    """Three pieces of the program's passport and five of the data's.

    An empty piece is not filled in; for None the unit does not know the command.
    """

    program: tuple[str | None, ...]
    """The three pieces of 51–53."""
    data: tuple[str | None, ...]
    """The five pieces of 54–58."""

    @property
    def pieces(self) -> tuple[str, ...]:
        """All eight pieces, "" for a missing one; they identify a unit."""
        return tuple(piece or "" for piece in (*self.program, *self.data))

    def contradicts(self, other: Passport) -> bool:
        """Whether both are of two units: noise can remove pieces, but not change them."""
        return any(own != others for own, others in self._in_both(other))

    def may_be(self, other: Passport) -> bool:
        """Whether both may be of one unit: a piece is known of both, or neither has any."""
        return not self.contradicts(other) and (bool(self._in_both(other)) or self == other)

    def _in_both(self, other: Passport) -> list[tuple[str, str]]:
        pairs = zip_longest((*self.program, *self.data), (*other.program, *other.data))
        return [(own, others) for own, others in pairs if own is not None and others is not None]

    def filled_from(self, other: Passport) -> Passport:
        """Return this passport with its missing pieces taken from `other`."""
        return Passport(_filled(self.program, other.program), _filled(self.data, other.data))


def _filled(
    pieces: tuple[str | None, ...], others: tuple[str | None, ...]
) -> tuple[str | None, ...]:
    pairs = zip_longest(pieces, others)
    return tuple(other if piece is None else piece for piece, other in pairs)


class UnitIdentity(NamedTuple):
    """What distinguishes units, live and in recordings; None: unknown."""

    version_code: int | None
    """The answer to 01."""
    passport: Passport | None
    """The passports, as far as they were read."""

    def contradicts(self, other: UnitIdentity) -> bool:
        """Whether both are certainly two units."""
        if self.version_code != other.version_code:
            return True
        own, others = self.passport, other.passport
        return own is not None and others is not None and own.contradicts(others)

    def may_be(self, other: UnitIdentity) -> bool:
        """Whether both may be one unit, as far as their passports are known."""
        own, others = self.passport, other.passport
        if own is None or others is None:
            return self == other
        return self.version_code == other.version_code and own.may_be(others)

    def filled_from(self, other: UnitIdentity) -> UnitIdentity:
        """Return this identity with the missing pieces of its passport taken from `other`."""
        if self.passport is None or other.passport is None:
            return self
        return self._replace(passport=self.passport.filled_from(other.passport))


@dataclass(frozen=True, slots=True)
class Info:
    """Description of a unit. `parameter_count`: None if the unit does not answer 60."""

    model: Model
    """The model of its version code."""
    version_code: int
    """The answer to 01."""
    passport: Passport
    """The passports (51–58)."""
    parameter_count: int | None
    echo: bool
    """Whether the adapter returns the sent bytes (D1)."""
    limits: Limits
    """The learnt limits."""
    pause: float
    """The seconds that a request keeps from the latest response (D14): as set, or as found."""


class PassportReader:
    """Reads the passports; after a `LineError`, only those that are still missing.

    All of them after a silence of a second, after which another unit may answer (D13). `latest`: as
    read last; `on_other` is called when they are no longer those of before.
    """

    def __init__(self, tester: Tester, on_other: Callable[[], None]) -> None:
        self.latest: Passport | None = None
        self._tester = tester
        self._on_other = on_other
        self._pieces: dict[int, str | None] = {}  # by command code
        self._valid_for = self._unit()

    def _unit(self) -> tuple[int | None, int]:
        return self._tester.version_code, self._tester.line.silences

    @property
    def so_far(self) -> Passport:
        """The pieces read by the steps that are under way; the others are missing."""
        program, data = (tuple(map(self._pieces.get, kind.CODES)) for kind in _KINDS)
        return Passport(program, data)

    def restart(self) -> None:
        """Read all again: since the latest step there may have been a pause without requests."""
        self._pieces.clear()

    def read(self) -> Passport:
        """Do all `steps`."""
        for _ in self.steps():
            pass
        assert self.latest is not None
        return self.latest

    def steps(self) -> Generator[None, None, Passport]:
        """Send eight requests, fewer if the unit refuses the first of a kind; yield after each.

        The line is free then. A piece lost on the line is requested again after the others; one
        that was read before and is missing in the end was lost too, and keeps its earlier value.
        After a `LineError` the next call continues: between both, requests are sent all the time.
        Raises the third `LineError` in a row, `SyncLost`, or a `NoConnection`.
        """
        pieces, code, failures = self._pieces, 0, 0
        while missing := self._missing():
            command = next((each for each in missing if each.code > code), missing[0])
            code = command.code
            try:
                piece = _request_if_known(self._tester, command)
            except SyncLost:
                raise
            except LineError:
                failures += 1
                if failures == _ATTEMPTS:
                    raise
            else:
                failures = 0
                self._missing()
                if piece is None and pieces.keys().isdisjoint(command.CODES):
                    pieces |= dict.fromkeys(command.CODES)  # it knows no other of the kind
                pieces[code] = piece
            yield
        program, data = (tuple(pieces[code] for code in kind.CODES) for kind in _KINDS)
        pieces.clear()
        before, found = self.latest, Passport(program, data)
        if before is not None and before.may_be(found):
            found = found.filled_from(before)
        self.latest = found
        if before is not None and before != found:
            self._on_other()
        return found

    def _missing(self) -> list[c.ReadProgramPassport | c.ReadDataPassport]:
        """Return the requests to come; forget pieces that may be another unit's."""
        if self._valid_for != self._unit():
            self._valid_for = self._unit()
            self._pieces.clear()
        return [each for each in _PASSPORTS if each.code not in self._pieces]


def _request_if_known(tester: Tester, command: c.Command[T]) -> T | None:
    try:
        return tester.request(command)
    except NotSupported:
        return None


def count_parameters(tester: Tester) -> int | None:
    """Send 60; None if unknown. A count of 1 is D10's `01`: no unit has a single parameter."""
    count = _request_if_known(tester, c.CountParameters())
    return None if count == 1 else count
