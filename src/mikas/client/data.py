"""Data by code, in as few requests as the unit takes (§3 rows 61, 63; D10, D11)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from mikas.client.limits import Limits
from mikas.commands import Datum, ReadParameters
from mikas.errors import EcuRefused, LineError, NoResponse, NotSupported, WrongLength
from mikas.language import Text
from mikas.tester import Reply, Tester

_ONE = b"\x01"
_RPM = Datum(0x29, 1)  # FREQ: what a unit that knows 61 at all has
_TOO_OFTEN = 3


@dataclass(frozen=True, slots=True)
class Got:
    """One datum and the time when the response that brought it began."""

    raw: bytes
    time: float


class DataReader:
    """Reads any number of data, learning how many fit one request and which codes are refused.

    Only what was told twice is learnt, so a lost response leaves no trace: a list that got no
    answer is tried once more after its halves were answered, and a code that has answered before is
    not taken for an unknown one.
    """

    def __init__(
        self, tester: Tester, limits: Callable[[], Limits], learnt: Callable[[], None]
    ) -> None:
        self._tester = tester
        self._limits = limits
        self._learnt = learnt
        self._sure: set[int] = set()  # codes that are known to have answered with a datum
        self._proven = 1  # the longest list that this unit has answered
        self._too_long = 0  # how often one that it has answered before was too long, in a row

    def batch(self, wanted: Sequence[Datum], *, again: bool = False) -> dict[int, Got]:
        """`wanted`, of distinct codes, in the largest requests that the unit takes.

        A code that the unit refuses is missing from the result, and is not asked for another time
        unless `again` says so. Raises a `LineError`, a `NoConnection`, or `NotSupported` if the
        unit does not know 61 at all.
        """
        limits = self._limits()
        asked = self._to_ask(wanted, limits, again=again)
        got: dict[int, Got] = {}
        while asked:
            part, asked = asked[: limits.max_list], asked[limits.max_list :]
            got |= self._part(part, limits)
        return got

    def single(self, wanted: Sequence[Datum], *, again: bool = False) -> dict[int, Got]:
        """As `batch`, one request a code."""
        limits = self._limits()
        got: dict[int, Got] = {}
        for datum in self._to_ask(wanted, limits, again=again):
            got |= self._part([datum], limits)
        return got

    def refuses(self, codes: Iterable[int]) -> bool:
        """Whether the unit is known to refuse every one of them."""
        return set(codes).issubset(self._limits().refused)

    def _to_ask(self, wanted: Sequence[Datum], limits: Limits, *, again: bool) -> list[Datum]:
        if again and (known := {d.code for d in wanted}.intersection(limits.refused)):
            limits.refused = [code for code in limits.refused if code not in known]
            self._learnt()
        return [d for d in wanted if d.code not in limits.refused]

    def _part(self, part: list[Datum], limits: Limits, *, halved: bool = False) -> dict[int, Got]:
        try:
            return self._request(part, doubt=halved)
        except (NotSupported, NoResponse, WrongLength) as error:
            # Silent, short or refused (D11): too many at once, or one that it does not know.
            if not self._works():
                raise  # no parameter is to blame
            if len(part) == 1:
                return self._refuse(part[0], limits, error)
        middle = (len(part) + 1) // 2
        got = self._part(part[:middle], limits, halved=True)
        got |= self._part(part[middle:], limits, halved=True)
        if len(got) == len(part) > 1:  # both halves came whole: was it the length?
            if len(part) <= limits.max_list:
                try:
                    return self._request(part)
                except (NotSupported, NoResponse, WrongLength):
                    pass  # yes
                except LineError:
                    return got  # no telling this time
            self._shorten(len(part), limits)
        return got

    def _shorten(self, length: int, limits: Limits) -> None:
        """A list of `length` is too long. One that was taken before has to fail again and again."""
        if length <= self._proven:
            self._too_long += 1
            if self._too_long < _TOO_OFTEN:
                return
            self._proven = (length + 1) // 2
        self._too_long = 0
        limits.max_list = self._proven
        self._learnt()

    def _refuse(
        self, datum: Datum, limits: Limits, error: NotSupported | NoResponse | WrongLength
    ) -> dict[int, Got]:
        if isinstance(error, WrongLength) or datum.code in self._sure:
            raise error  # it knows the parameter: another size than asked, or a bad line
        if datum.code not in limits.refused:
            limits.refused.append(datum.code)
            self._learnt()
        return {}

    def _works(self) -> bool:
        """Whether this unit has given any datum, or gives one now."""
        if not self._sure:
            with suppress(EcuRefused, LineError):
                self._request([_RPM])
        return bool(self._sure)

    def _request(self, part: list[Datum], *, doubt: bool = False) -> dict[int, Got]:
        """`doubt`: it was refused just now among others, so 01 may be a refusal again."""
        command = ReadParameters(tuple(part))
        retries = None
        if len(part) > self._proven:
            retries = 1  # it may be too long: the time for more is better spent on its halves
        elif len(part) == 1 and part[0].code not in self._sure:
            retries = max(1, self._tester.retries)
        data, reply = self._tester.exchange(command, retries=retries)
        if data == (_ONE,) and (doubt or part[0].code not in self._sure):
            return self._doubted(part[0], reply)
        if len(part) >= self._proven:
            self._proven, self._too_long = len(part), 0
        self._sure.update(d.code for d in part)
        return {d.code: Got(raw, reply.began) for d, raw in zip(part, data, strict=True)}

    def _doubted(self, datum: Datum, reply: Reply) -> dict[int, Got]:
        """01 to a request for one byte: a datum, or D10's refusal? Asked for twice at once, it
        shows.

        Raises `NotSupported` if it was the refusal; empty if there is no telling.
        """
        got = Got(_ONE, reply.began)
        try:
            data, reply = self._tester.exchange(ReadParameters((datum, datum)))
        except NotSupported:
            if self._takes_two() or datum == _RPM or not self._works():
                raise
            return {}  # it says 01 to two of anything
        except (NoResponse, WrongLength):
            # It takes one at a time, and does not say 01 to what it does not take.
            self._sure.add(datum.code)
            return {datum.code: got}
        self._proven = max(self._proven, 2)
        self._sure.add(datum.code)
        return {datum.code: Got(data[0], reply.began)}

    def _takes_two(self) -> bool:
        if self._proven == 1 and self._limits().max_list > 1:
            with suppress(EcuRefused, LineError):
                self._tester.exchange(ReadParameters((_RPM, _RPM)))
                self._proven = 2
        return self._proven > 1


def refused(name: str, code: int) -> NotSupported:
    """The error for a parameter that was asked for by name and that the unit does not know."""
    named = Text(f"parameter {name} (61 {code:02X})", f"параметра {name} (61 {code:02X})")
    return NotSupported(command=named, request=bytes([0x61, code]))
