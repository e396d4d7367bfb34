"""Data by code, in as few requests as the unit takes (§3 rows 61, 63; D10, D11)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from mikas.client.limits import Limits
from mikas.commands import Datum, ReadParameters
from mikas.errors import LineError, NoResponse, NotSupported, WrongLength
from mikas.language import Text
from mikas.tester import Reply, Tester

_ONE = b"\x01"


@dataclass(frozen=True, slots=True)
class Got:
    """One datum and the time when the response that brought it began."""

    raw: bytes
    time: float


class DataReader:
    """Reads any number of data, learning how many fit one request."""

    def __init__(
        self, tester: Tester, limits: Callable[[], Limits], learnt: Callable[[], None]
    ) -> None:
        self._tester = tester
        self._limits = limits
        self._learnt = learnt
        self._sure: set[int] = set()  # one-byte codes whose 01 is known to be a datum
        self._proven = 1  # the longest list that this unit has answered

    def batch(self, wanted: Sequence[Datum]) -> dict[int, Got]:
        """`wanted`, distinct, in the largest requests that the unit takes.

        A code that the unit refuses is missing from the result, and is remembered as refused.
        Raises a `LineError` or a `NoConnection`.
        """
        limits = self._limits()
        asked = [d for d in wanted if d.code not in limits.refused]
        got: dict[int, Got] = {}
        while asked:
            part, asked = asked[: limits.max_list], asked[limits.max_list :]
            got |= self._part(part, limits)
        return got

    def single(self, wanted: Sequence[Datum]) -> dict[int, Got]:
        """As `batch`, one request a code."""
        limits = self._limits()
        got: dict[int, Got] = {}
        for datum in wanted:
            if datum.code not in limits.refused:
                got |= self._part([datum], limits)
        return got

    def _part(self, part: list[Datum], limits: Limits) -> dict[int, Got]:
        try:
            return self._request(part)
        except (NotSupported, NoResponse, WrongLength) as error:
            # Silent, short or refused (D11): too many at once, or one that it does not know.
            if len(part) == 1:
                return self._refuse(part[0], limits, error)
        middle = (len(part) + 1) // 2
        known = len(limits.refused)
        got = self._part(part[:middle], limits) | self._part(part[middle:], limits)
        if len(limits.refused) == known and self._proven <= middle < limits.max_list:
            limits.max_list = middle  # both halves came whole: it was the length
            self._learnt()
        return got

    def _refuse(
        self, datum: Datum, limits: Limits, error: NotSupported | NoResponse | WrongLength
    ) -> dict[int, Got]:
        if isinstance(error, WrongLength):
            raise error  # it knows the parameter, and gives another size than asked
        if not self._alive():
            raise error
        limits.refused.append(datum.code)
        self._learnt()
        return {}

    def _alive(self) -> bool:
        """Whether 61 works at all: else no parameter is to blame."""
        return self._tester.has_answered(ReadParameters.CODES[0])

    def _request(self, part: list[Datum]) -> dict[int, Got]:
        command = ReadParameters(tuple(part))
        # A list that may be too long is repeated once, lest a lost response is taken for a limit.
        retries = None if len(part) <= self._proven else 1
        data, reply = self._tester.exchange(command, retries=retries)
        self._proven = max(self._proven, len(part))
        if len(part) == 1 and data[0] == _ONE:
            return self._surely(part[0], reply)
        return {d.code: Got(raw, reply.began) for d, raw in zip(part, data, strict=True)}

    def _surely(self, datum: Datum, reply: Reply) -> dict[int, Got]:
        """01 to a request for one byte: a datum, or D10's refusal? Asked for twice at once, it
        shows.

        Raises `NotSupported` if it was the refusal.
        """
        got = Got(_ONE, reply.began)
        if datum.code not in self._sure:
            try:
                data, reply = self._tester.exchange(ReadParameters((datum, datum)), retries=0)
            except NotSupported:
                raise
            except LineError:
                return {datum.code: got}  # a unit that takes one at a time; so it was the datum
            self._sure.add(datum.code)
            got = Got(data[0], reply.began)
        return {datum.code: got}


def refused(name: str, code: int) -> NotSupported:
    """The error for a parameter that was asked for by name and that the unit does not know."""
    named = Text(f"parameter {name} (61 {code:02X})", f"параметра {name} (61 {code:02X})")
    return NotSupported(command=named, request=bytes([0x61, code]))
