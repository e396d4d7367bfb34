"""Data by code, in as few requests as the unit takes (§3 rows 61, 63; D10, D11)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence

from mikas.client.asking import Asking, Got
from mikas.client.limits import Limits
from mikas.commands import Datum
from mikas.errors import LineError, NoResponse, NotSupported, WrongLength
from mikas.i18n import Text
from mikas.tester import Tester

__all__ = ["DataReader", "Got", "refused"]

_TOO_OFTEN = 3
_NOTHING_ELSE = 10  # times that all a code says is 01, before that counts as its refusal


class DataReader:
    """Reads any number of data, learning how many fit one request and which codes are refused.

    Only what was told twice is learnt, so a lost response leaves no trace: a list that got no
    answer is tried once more after its halves were answered, and a code that has answered before is
    not taken for an unknown one.
    """

    def __init__(
        self, tester: Tester, limits: Callable[[], Limits], learnt: Callable[[], None]
    ) -> None:
        self._limits = limits
        self._learnt = learnt
        self._asking = Asking(tester, limits, learnt)
        self._unclear: Counter[int] = Counter()  # 01 from these codes; nothing tells what it is
        self._too_long = 0  # how often one that it has answered before was too long, in a row

    def batch(self, wanted: Sequence[Datum], *, again: bool = False) -> dict[int, Got]:
        """`wanted`, of distinct codes, in the largest requests that the unit takes.

        A code that the unit refuses is missing from the result, and is not asked for another time
        unless `again` says so. Raises a `LineError`, a `NoConnection`, or `NotSupported` if the
        unit does not know 61 at all.
        """
        limits = self._limits()
        asked = self._to_ask(wanted, limits, again=again)
        return self._parts(asked, limits)

    def single(self, wanted: Sequence[Datum], *, again: bool = False) -> dict[int, Got]:
        """As `batch`, one request a code."""
        limits = self._limits()
        got: dict[int, Got] = {}
        for datum in self._to_ask(wanted, limits, again=again):
            got |= self._part([datum], limits)
        return got

    def refuses(self, codes: Iterable[int]) -> bool:
        """Whether the unit refuses every one of them, or all that it ever says is an 01 that may be
        a refusal.
        """
        refused = {*self._limits().refused}
        for code, times in self._unclear.items():
            if times >= _NOTHING_ELSE and not self._asking.knows(code):
                refused.add(code)
        return refused.issuperset(codes)

    def _to_ask(self, wanted: Sequence[Datum], limits: Limits, *, again: bool) -> list[Datum]:
        if again:
            for datum in wanted:
                del self._unclear[datum.code]
        if again and (known := {d.code for d in wanted}.intersection(limits.refused)):
            limits.refused = [code for code in limits.refused if code not in known]
            self._learnt()
        return [d for d in wanted if d.code not in limits.refused]

    def _parts(self, asked: list[Datum], limits: Limits) -> dict[int, Got]:
        got: dict[int, Got] = {}
        while asked:
            part, asked = asked[: limits.max_list], asked[limits.max_list :]
            got |= self._part(part, limits)
        return got

    def _half(self, part: list[Datum], limits: Limits) -> dict[int, Got]:
        if len(part) >= 2 * limits.max_list:
            return self._parts(part, limits)  # meanwhile it was learnt that this is too long
        return self._part(part, limits, halved=True)

    def _part(self, part: list[Datum], limits: Limits, *, halved: bool = False) -> dict[int, Got]:
        try:
            return self._request(part, halved=halved)
        except (NotSupported, NoResponse, WrongLength) as error:
            # Silent, short or refused (D11): too many at once, or one that it does not know.
            if not self._asking.works(part):
                raise  # no parameter is to blame
            if len(part) == 1:
                return self._refuse(part[0], limits, error)
        middle = (len(part) + 1) // 2
        got = self._half(part[:middle], limits) | self._half(part[middle:], limits)
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
        asking = self._asking
        if length <= asking.proven:
            self._too_long += 1
            if self._too_long < _TOO_OFTEN:
                return
            asking.proven = (length + 1) // 2
        self._too_long = 0
        limits.max_list = asking.proven
        self._learnt()

    def _refuse(
        self, datum: Datum, limits: Limits, error: NotSupported | NoResponse | WrongLength
    ) -> dict[int, Got]:
        if isinstance(error, WrongLength) or self._asking.knows(datum.code):
            raise error  # it knows the parameter: another size than asked, or a bad line
        if datum.code not in limits.refused:
            limits.refused.append(datum.code)
            self._learnt()
        return {}

    def _request(self, part: list[Datum], *, halved: bool = False) -> dict[int, Got]:
        got = self._asking.request(part, halved=halved)
        if len(part) == self._asking.proven:
            self._too_long = 0
        if not got:
            self._unclear[part[0].code] += 1
        return got


def refused(name: str, code: int) -> NotSupported:
    """The error for a parameter that was asked for by name and that the unit does not know."""
    named = Text(f"parameter {name} (61 {code:02X})", f"параметра {name} (61 {code:02X})")
    return NotSupported(command=named, request=bytes([0x61, code]))
