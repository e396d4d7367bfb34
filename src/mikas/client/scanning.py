"""Which of the codes 00–FF the unit answers to 61, with the size and datum of each (§3, D10, D13).

The length of a response is the size of the datum. The same code twice in one request confirms it:
the response is twice as long, and a datum 01 differs from a refusal 01. A unit may take one code a
request, or answer several only; both are found out on the way. A code counts as silent after as
many requests without a response as the line requires, each followed by D13's `01`.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass
from enum import Enum

from mikas import errors
from mikas.commands import ReadUnknownSize
from mikas.tester import Tester

_ONE = b"\x01"
_FAILED_PAIRS = 3  # codes that answer alone but not twice in a request: the unit takes one only
_TRIED_AS_PAIRS = 8  # silent codes, before any datum, that are also requested twice in a request


class Answer(Enum):
    """The unit's answer to a code."""

    DATUM = "datum"
    """A value of one or more bytes."""
    REFUSED = "refused"
    """01 (D10), or an empty response (D5)."""
    SILENT = "silent"
    """No response (D10)."""
    UNCLEAR = "unclear"
    """01 that may be a datum, damage, or two readings of different sizes."""


@dataclass(frozen=True, slots=True)
class ScannedCode:
    """The answer to one code. `raw`: the datum, low byte first; `time`: as a `Reading`'s."""

    code: int
    """The code that was requested."""
    answer: Answer
    """The kind of answer."""
    raw: bytes = b""
    time: float = 0.0

    @property
    def size(self) -> int:
        """The bytes of the datum; 0 without one."""
        return len(self.raw)


class Scan:
    """One scan of `codes`. `known`: those to request first, so that the way of asking is known
    early. `once`: an answer 01 is taken at its first scan, as another scan had the code before.
    """

    def __init__(
        self,
        tester: Tester,
        known: Sequence[int] = (),
        codes: Iterable[int] = range(0x100),
        *,
        once: bool = False,
    ) -> None:
        self._tester = tester
        self._once = once
        self._order = tuple(dict.fromkeys((*known, *codes)))
        self._pairs: bool | None = None  # whether the unit answers a code twice in one request
        self._failed_pairs = 0
        self._only_several = False  # whether it answers several codes only
        self._lone_works = False  # whether it has answered a lone code by anything but 01
        self._count = dict.fromkeys(Answer, 0)
        self._troubles = tester.statistics.failed

    def codes(self) -> Generator[ScannedCode, None, None]:
        """Yield the answer to each code; an unclear one is requested, and comes, again at the end.

        Raises `NoConnection`, `SyncLost`, `LineNotQuiet`.
        """
        unclear: dict[int, ScannedCode] = {}
        for code in self._order:
            found = self._examine(code)
            self._count[found.answer] += 1
            if found.answer is Answer.UNCLEAR:
                unclear[code] = found
            yield found
        for code, before in unclear.items():
            found = before if self._once and before.raw == _ONE else self._examine(code)
            if found.raw == _ONE and found.answer is Answer.UNCLEAR:
                found = ScannedCode(code, self._meaning_of_one(), _ONE, found.time)
            yield found

    def _examine(self, code: int) -> ScannedCode:
        if self._only_several:
            return self._several(code)
        lone = self._ask(code, 1)
        if lone.raw == _ONE:
            return self._resolve_one(code, lone)
        if lone.answer is Answer.DATUM:
            self._lone_works = True
            return self._confirmed(code, lone)
        tried = self._count[Answer.SILENT]
        if lone.answer is Answer.SILENT and not self._has_data and tried < _TRIED_AS_PAIRS:
            return self._several(code)
        return lone

    @property
    def _has_data(self) -> bool:
        return bool(self._count[Answer.DATUM])

    def _confirmed(self, code: int, lone: ScannedCode) -> ScannedCode:
        """Confirm a datum by a second reading of the same size, in one request if possible."""
        pair = self._pair(lone)
        if pair.answer is Answer.DATUM:
            return pair
        again = self._ask(code, 1)
        if again.size == lone.size:
            return lone if again.raw == _ONE else again  # 01 alone may be a refusal
        return ScannedCode(code, Answer.UNCLEAR)

    def _resolve_one(self, code: int, lone: ScannedCode) -> ScannedCode:
        """Distinguish a datum 01 from a refusal (D10)."""
        pair = self._pair(lone)
        if pair.answer is Answer.DATUM:
            pair = self._pair(lone)  # a stray 00 before a refusal keeps its sum (§2.1)
            if pair.answer is Answer.DATUM:
                return pair
        if pair.answer is Answer.REFUSED and self._pairs:
            return pair
        if pair.answer is Answer.UNCLEAR and not self._lone_works:
            several = self._several(code)  # a lone code may be refused by 01
            if several.answer is Answer.DATUM:
                return several
        again = self._ask(code, 1)
        if again.size == 1 and again.raw != _ONE:
            return again  # no refusal changes
        unclear = again.raw == _ONE and not self._pairs
        return ScannedCode(code, Answer.UNCLEAR, _ONE if unclear else b"", lone.time)

    def _meaning_of_one(self) -> Answer:
        """Return what 01 means in a unit that takes one code a request.

        A unit that refuses by silence does not refuse by 01, and the other way round (D10).
        """
        if not self._has_data and not self._count[Answer.SILENT]:
            return Answer.REFUSED  # every code is answered by 01
        if self._count[Answer.SILENT] > self._count[Answer.UNCLEAR]:
            return Answer.DATUM
        return Answer.UNCLEAR

    def _pair(self, lone: ScannedCode) -> ScannedCode:
        """Request a code twice in one request; a datum of another size than `lone` is unclear."""
        unclear = ScannedCode(lone.code, Answer.UNCLEAR)
        if self._pairs is False:
            return unclear
        pair = self._ask(lone.code, 2)
        if pair.answer is Answer.DATUM and pair.size == lone.size:
            self._pairs = True
            return pair
        if not self._pairs and (pair.answer is not Answer.REFUSED or lone.raw != _ONE):
            self._failed_pairs += 1
            if self._failed_pairs >= _FAILED_PAIRS:
                self._pairs = False
        return unclear if pair.answer is Answer.DATUM else pair

    def _several(self, code: int) -> ScannedCode:
        """Request a code twice and three times in a request, for a unit that needs several."""
        pair = self._ask(code, 2)
        if pair.answer is not Answer.DATUM:
            return pair
        three = self._ask(code, 3)
        if three.size != pair.size:
            return ScannedCode(code, Answer.UNCLEAR)
        self._only_several = True
        return three

    def _ask(self, code: int, times: int) -> ScannedCode:
        """Request `code`, listed `times` times; fewer data are an unclear answer."""
        command = ReadUnknownSize.of(code, times)
        retries = self._tester.retries
        if self._tester.statistics.failed == self._troubles:
            retries = min(1, retries)  # the line has lost nothing: a second silence is meant
        try:
            try:
                data, reply = self._tester.exchange(command, retries=retries, trial=True)
            except (errors.EchoOnly, errors.NoEcho):
                # Among hundreds of D13's `01` a bad line may lose two.
                data, reply = self._tester.exchange(command, retries=retries, trial=True)
        except errors.NotSupported as error:
            return ScannedCode(code, Answer.REFUSED if error.received else Answer.SILENT)
        except errors.NoResponse:
            return ScannedCode(code, Answer.SILENT)
        except (errors.SyncLost, errors.LineNotQuiet):
            raise
        except errors.LineError:
            return ScannedCode(code, Answer.UNCLEAR)
        if len(data) not in (0, times):  # the unit has answered only some of the codes
            return ScannedCode(code, Answer.UNCLEAR)
        if not data:
            return ScannedCode(code, Answer.REFUSED)
        return ScannedCode(code, Answer.DATUM, data[-1], reply.began)
