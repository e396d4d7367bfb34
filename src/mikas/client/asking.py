"""One request for data, and what the unit says by `01`: a datum, or that it refuses (§3 row 61;
D10).

A refusal is one byte, so it can be taken for a datum only where a single one of one byte was asked
for. Asked for twice at once, it shows: two data, or still one byte. This is done whenever an `01`
comes to a lone code, and from then on at once, for as long as the datum is 01.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice

from mikas.client.limits import Limits
from mikas.commands import Datum, ReadParameters
from mikas.errors import EcuRefused, LineError, NoResponse, NotSupported, WrongLength
from mikas.tester import Reply, Tester

COMMON = (Datum(0x29, 1), Datum(0x2C, 1), Datum(0x1A, 1), Datum(0x1E, 1))
"""What most units have (FREQ, FREQX, TWAT, UACC), though nothing promises any of them."""

_ONE = b"\x01"
_PROBES = 8  # codes that are tried before it is 61 that the unit does not know
_TOLD = 3  # times that a unit has to show that two are too many


@dataclass(frozen=True, slots=True)
class Got:
    """One datum and the time when the response that brought it began."""

    raw: bytes
    time: float


class Asking:
    """Sends single requests, and remembers what the answers tell of this unit."""

    def __init__(
        self, tester: Tester, limits: Callable[[], Limits], learnt: Callable[[], None]
    ) -> None:
        self.proven = 1
        """The longest list that this unit has answered."""
        self._tester = tester
        self._limits = limits
        self._learnt = learnt
        self._known: dict[int, Datum] = {}  # what is known to have answered with a datum
        self._ones: set[int] = set()  # codes of these whose latest datum was 01
        self._silent: bool | None = None  # of one that takes no two: to what it does not take

    def knows(self, code: int) -> bool:
        """Whether this code is known to have answered with a datum."""
        return code in self._known

    def works(self, wanted: Iterable[Datum]) -> bool:
        """Whether this unit has given any datum, or gives one now, of what is common or wanted."""
        for datum in islice(dict.fromkeys((*COMMON, *wanted)), _PROBES):
            if self._known:
                break
            with suppress(EcuRefused, LineError):
                command = ReadParameters((datum,))
                data, reply = self._tester.exchange(command, retries=0, trial=True)
                if data != (_ONE,):
                    self._taken([datum], data, reply)
        return bool(self._known)

    def request(self, part: Sequence[Datum], *, halved: bool = False) -> dict[int, Got]:
        """The data of `part` by code; empty if there is no telling whether it was one.

        `halved`: it is part of a list that got no answer. Raises what the tester does.
        """
        lone = part[0] if len(part) == 1 else None
        if lone and lone.code in self._ones and self.proven > 1:
            return self._twice(lone)
        retries = None
        if lone and lone.code not in self._known:
            retries = max(1, self._tester.retries)
        elif halved:
            retries = 0  # its list was silent often enough; others wait while this one is
        elif len(part) > self.proven:
            retries = 1  # it may be too long: the time for more is better spent on its halves
        trial = len(part) > self.proven or part[0].code not in self._known
        data, reply = self._tester.exchange(
            ReadParameters(tuple(part)), retries=retries, trial=trial
        )
        if lone and data == (_ONE,):
            return self._doubted(lone, reply)
        return self._taken(part, data, reply)

    def _twice(self, datum: Datum, *, retries: int | None = None) -> dict[int, Got]:
        asked = (datum, datum)
        return self._taken(asked, *self._tester.exchange(ReadParameters(asked), retries=retries))

    def _taken(self, asked: Sequence[Datum], data: Sequence[bytes], reply: Reply) -> dict[int, Got]:
        if len(asked) > 1:
            self._silent = None
        self.proven = max(self.proven, len(asked))
        got = {d.code: Got(raw, reply.began) for d, raw in zip(asked, data, strict=True)}
        self._known |= {datum.code: datum for datum in asked}
        ones = {code for code, each in got.items() if each.raw == _ONE}
        self._ones = (self._ones - got.keys()) | ones
        return got

    def _doubted(self, datum: Datum, reply: Reply) -> dict[int, Got]:
        """01 to a request for one byte. Raises `NotSupported` if it was the refusal."""
        if self._silent is None:
            try:
                return self._twice(datum)
            except WrongLength:
                return self._taken([datum], [_ONE], reply)  # one, and no 01: it has just changed
            except (NotSupported, NoResponse) as error:
                if self._takes_two(datum):
                    raise
                self._silent = isinstance(error, NoResponse)
        # A unit that is silent to what it does not take does not say 01 to that.
        return self._taken([datum], [_ONE], reply) if self._silent else {}

    def _takes_two(self, wanted: Datum) -> bool:
        """Whether the unit takes two of what it knows; learnt, if it does not."""
        limits = self._limits()
        if self.proven > 1 or limits.max_list == 1:
            return self.proven > 1
        if not self.works([wanted]):
            return True  # there is nothing that it knows
        known = next(iter(self._known.values()))
        for _ in range(_TOLD):
            with suppress(NotSupported, NoResponse, WrongLength):
                self._twice(known, retries=0)
                return True
        limits.max_list = 1
        self._learnt()
        return False
