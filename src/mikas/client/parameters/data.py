"""Data by code, in as few requests as the unit takes (§3 rows 61, 63; D10, D11).

A refusal is the single byte `01`, so it is ambiguous only if one datum of one byte was requested.
A list with the code twice resolves it: the response has two data, or still one byte. That is done
when a lone code answers `01`, and directly from then on, as long as the datum is 01.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice

from mikas.catalog import Parameter
from mikas.client.limits import LimitsCache
from mikas.client.parameters.silence import SilenceCheck
from mikas.commands import Datum, ReadParameters
from mikas.errors import EcuRefused, LineError, NoResponse, NotSupported, WrongLength, usage_error
from mikas.i18n import Text
from mikas.tester import Reply, Tester

COMMON = (Datum(0x29, 1), Datum(0x2C, 1), Datum(0x1A, 1), Datum(0x1E, 1))
"""Parameters that most units have (FREQ, FREQX, TWAT, UACC); none is guaranteed."""

_ONE = b"\x01"
_PROBES = 8  # codes that are tried before 61 counts as unknown to the unit
_PAIR_TRIES = 3  # refusals of a pair after which the unit counts as accepting one code only
_TOO_OFTEN = 3  # failures in a row of a list length that worked before
_AMBIGUOUS = 10  # answers 01 of a code, and no other, that count as its refusal


@dataclass(frozen=True, slots=True)
class RawDatum:
    """One datum and the time when its response began."""

    raw: bytes
    time: float


class DataReader:
    """Reads any number of data; learns how many fit one request, and which codes are refused.

    A lost response teaches nothing: a list without a response is repeated after its halves were
    answered, a silent code is tested (`silence`), and one that has answered before does not become
    unknown.
    """

    def __init__(self, tester: Tester, cache: LimitsCache) -> None:
        self._tester = tester
        self._cache = cache
        self.requests: _Requests = _Requests(tester, cache)
        self._silence = SilenceCheck(tester)  # of the present reading
        self._ambiguous: Counter[int] = Counter()  # answers 01 by code: datum or refusal
        self._too_long = 0  # failures in a row of a list length that has worked before

    def read(
        self, wanted: Sequence[Datum], *, single: bool = False, again: bool = False
    ) -> dict[int, RawDatum]:
        """Read `wanted`, of distinct codes, in the largest requests that the unit accepts.

        `single`: one request for each code. The result lacks codes that the unit refuses; these are
        requested once more only with `again`. Raises a `LineError`, a `NoConnection`, or
        `NotSupported` if 61 is unknown.
        """
        self._silence = SilenceCheck(self._tester)
        return self._read_all(self._not_refused(wanted, again=again), single=single)

    def request_for(self, wanted: Sequence[Datum]) -> ReadParameters | None:
        """Return the one request that reads `wanted`; None: it takes more, or is not known yet."""
        if wanted[0].code not in self.requests.answered:
            return None
        part = self._not_refused(wanted)
        fits = 0 < len(part) <= self._cache.limits().max_list
        return self.requests.request_for(part) if fits else None

    def refuses(self, codes: Iterable[int]) -> bool:
        """Whether the unit refuses all `codes`, or answers them with ambiguous 01 only."""
        refused = {*self._cache.limits().refused}
        for code, times in self._ambiguous.items():
            if times >= _AMBIGUOUS and code not in self.requests.answered:
                refused.add(code)
        return refused.issuperset(codes)

    def _not_refused(self, wanted: Sequence[Datum], *, again: bool = False) -> list[Datum]:
        limits = self._cache.limits()
        if again:
            for datum in wanted:
                del self._ambiguous[datum.code]
        if again and (known := {d.code for d in wanted}.intersection(limits.refused)):
            limits.refused = [code for code in limits.refused if code not in known]
            self._cache.keep()
        return [d for d in wanted if d.code not in limits.refused]

    def _read_all(self, wanted: list[Datum], *, single: bool = False) -> dict[int, RawDatum]:
        found: dict[int, RawDatum] = {}
        while wanted:
            most = 1 if single else self._cache.limits().max_list
            part, wanted = wanted[:most], wanted[most:]
            found |= self._read(part)
        return found

    def _read_half(self, part: list[Datum]) -> dict[int, RawDatum]:
        if len(part) >= 2 * self._cache.limits().max_list:
            return self._read_all(part)  # the first half showed that this is too long
        return self._read(part, halved=True)

    def _read(self, part: list[Datum], *, halved: bool = False) -> dict[int, RawDatum]:
        try:
            return self._request(part, halved=halved)
        except (NotSupported, NoResponse, WrongLength) as error:
            # Silent, short or refused (D11): too many codes, or an unknown one.
            if not self.requests.answers_any(part):
                raise  # no code is answered
            if len(part) == 1:
                return self._read_doubtful(part[0], error)
        middle = (len(part) + 1) // 2
        found = self._read_half(part[:middle]) | self._read_half(part[middle:])
        if len(found) == len(part) > 1:  # both halves were answered: was the length the cause?
            if len(part) <= self._cache.limits().max_list:
                try:
                    return self._request(part)
                except (NotSupported, NoResponse, WrongLength):
                    pass  # yes
                except LineError:
                    return found  # unknown, on such a line
            self._shorten(len(part))
        return found

    def _shorten(self, length: int) -> None:
        """Lower the limit below `length`, after several failures if that length worked before."""
        requests = self.requests
        if length <= requests.longest_list:
            self._too_long += 1
            if self._too_long < _TOO_OFTEN:
                return
            requests.longest_list = (length + 1) // 2
        self._too_long = 0
        self._cache.limits().max_list = requests.longest_list
        self._cache.keep()

    def _read_doubtful(
        self, datum: Datum, error: NotSupported | NoResponse | WrongLength
    ) -> dict[int, RawDatum]:
        """Read `datum`, whose request failed with `error`; {} if the unit proves to refuse it."""
        while True:
            if isinstance(error, WrongLength) or datum.code in self.requests.answered:
                raise error  # the parameter is known: another size than requested, or a bad line
            latest = next(reversed(self.requests.answered.values()))  # there is one: `answers_any`
            if error.received or self._silence.is_unknown(datum, latest):
                break
            if self._silence.gives_up(datum):
                raise error
            try:
                return self._request([datum])
            except (NotSupported, NoResponse, WrongLength) as again:
                error = again
        if datum.code not in (refused := self._cache.limits().refused):
            refused.append(datum.code)
            self._cache.keep()
        return {}

    def _request(self, part: list[Datum], *, halved: bool = False) -> dict[int, RawDatum]:
        found = self.requests.send(part, halved=halved)
        if len(part) == self.requests.longest_list:
            self._too_long = 0
        if not found:
            self._ambiguous[part[0].code] += 1
        return found


class _Requests:
    """Sends single requests; keeps the facts about the unit that their responses show."""

    def __init__(self, tester: Tester, cache: LimitsCache) -> None:
        self.longest_list: int = 1  # that this unit has answered
        self.answered: dict[int, Datum] = {}  # codes that have answered with a datum, latest last
        self._tester = tester
        self._cache = cache
        self._ones: set[int] = set()  # those of them whose latest datum was 01
        self._silent: bool | None = None  # whether the unit refuses a pair by silence, not by 01

    def answers_any(self, wanted: Iterable[Datum]) -> bool:
        """Whether the unit has sent any datum, or sends one of `COMMON` or `wanted` now."""
        for datum in islice(dict.fromkeys((*COMMON, *wanted)), _PROBES):
            if self.answered:
                break
            with suppress(EcuRefused, LineError):
                command = ReadParameters((datum,))
                data, reply = self._tester.exchange(command, retries=0, trial=True)
                if data != (_ONE,):
                    self._record([datum], data, reply)
        return bool(self.answered)

    def request_for(self, part: Sequence[Datum]) -> ReadParameters:
        """Return the request that `send` would send."""
        return ReadParameters((part[0], part[0]) if self._is_sent_twice(part) else tuple(part))

    def _is_sent_twice(self, part: Sequence[Datum]) -> bool:
        return len(part) == 1 and part[0].code in self._ones and self.longest_list > 1

    def send(self, part: Sequence[Datum], *, halved: bool = False) -> dict[int, RawDatum]:
        """Request `part`; return its data by code, {} for an ambiguous 01.

        `halved`: `part` is half of a list without a response. Raises the tester's errors.
        """
        lone = part[0] if len(part) == 1 else None
        if lone and self._is_sent_twice(part):
            return self._send_twice(lone)
        retries = None
        if lone and lone.code not in self.answered:
            return self._send_untried(lone)
        if halved:
            retries = 0  # the list's retries were enough; other parameters wait
        elif len(part) > self.longest_list:
            retries = 1  # it may be too long: halving is the better attempt
        trial = len(part) > self.longest_list or part[0].code not in self.answered
        data, reply = self._tester.exchange(
            ReadParameters(tuple(part)), retries=retries, trial=trial
        )
        if lone and data == (_ONE,):
            return self._resolve_one(lone, reply)
        return self._record(part, data, reply)

    def _send_untried(self, datum: Datum) -> dict[int, RawDatum]:
        """Request a code that may be unknown: repeated after damage, but not after silence."""
        for left in reversed(range(1 + max(1, self._tester.retries))):
            try:
                data, reply = self._tester.exchange(ReadParameters((datum,)), retries=0, trial=True)
                break
            except LineError as error:
                if isinstance(error, NoResponse) or not left:
                    raise
        if data == (_ONE,):
            return self._resolve_one(datum, reply)
        return self._record([datum], data, reply)

    def send_once(self, part: Sequence[Datum]) -> dict[int, RawDatum]:
        """Request `part` without a repetition; return its data by code, {} for a lone 01.

        A failure teaches nothing. Raises a `LineError`, a `NoConnection`, or `NotSupported`.
        """
        data, reply = self._tester.exchange(ReadParameters(tuple(part)), retries=0, trial=True)
        return {} if data == (_ONE,) else self._record(part, data, reply)

    def _send_twice(self, datum: Datum, *, retries: int | None = None) -> dict[int, RawDatum]:
        pair = (datum, datum)
        return self._record(pair, *self._tester.exchange(ReadParameters(pair), retries=retries))

    def _record(
        self, requested: Sequence[Datum], data: Sequence[bytes], reply: Reply
    ) -> dict[int, RawDatum]:
        if len(requested) > 1:
            self._silent = None
        self.longest_list = max(self.longest_list, len(requested))
        found = {d.code: RawDatum(raw, reply.began) for d, raw in zip(requested, data, strict=True)}
        for datum in requested:
            self.answered.pop(datum.code, None)
            self.answered[datum.code] = datum
        ones = {code for code, each in found.items() if each.raw == _ONE}
        self._ones = (self._ones - found.keys()) | ones
        return found

    def _resolve_one(self, datum: Datum, reply: Reply) -> dict[int, RawDatum]:
        """Resolve an 01 to a request for one byte. Raises `NotSupported` for a refusal."""
        if self._silent is None:
            try:
                return self._send_twice(datum)
            except WrongLength as error:
                if error.fields["length"] != 1:
                    raise  # another transmitter's frame
                return self._record([datum], [_ONE], reply)  # one byte, not 01: it just changed
            except (NotSupported, NoResponse) as error:
                if self._accepts_two(datum):
                    raise
                self._silent = isinstance(error, NoResponse) and self._ignores_pair(datum)
        # A unit that refuses by silence does not refuse by 01.
        return self._record([datum], [_ONE], reply) if self._silent else {}

    def _ignores_pair(self, datum: Datum) -> bool:
        """Whether `datum` twice in one list is never answered; a response may have been lost."""
        for _ in range(_PAIR_TRIES):
            with suppress(NoResponse):
                with suppress(NotSupported, WrongLength):
                    self._send_twice(datum, retries=0)
                return False
        return True

    def _accepts_two(self, wanted: Datum) -> bool:
        """Whether the unit accepts two known codes in a list; learn if it does not."""
        limits = self._cache.limits()
        if self.longest_list > 1 or limits.max_list == 1:
            return self.longest_list > 1
        if not self.answers_any([wanted]):
            return True  # no code is known
        known = next(iter(self.answered.values()))
        for _ in range(_PAIR_TRIES):
            with suppress(NotSupported, NoResponse, WrongLength):
                self._send_twice(known, retries=0)
                return True
        limits.max_list = 1
        self._cache.keep()
        return False


def distinct(parameters: Sequence[Parameter]) -> tuple[Datum, ...]:
    """Return each code once: RXX, BITPOW and RDET share one byte (§5).

    Raises `UsageError` for a code with two sizes, whose data could not be separated.
    """
    sizes: dict[int, int] = {}
    for p in parameters:
        if sizes.setdefault(p.code, p.size) != p.size:
            raise usage_error(
                f"code 0x{p.code:02X} can't have {sizes[p.code]} and {p.size} bytes at once",
                f"у кода 0x{p.code:02X} не может быть {sizes[p.code]} и {p.size} байта сразу",
            )
    return tuple(Datum(code, size) for code, size in sizes.items())


def refused(name: str, code: int) -> NotSupported:
    """Return the error for a parameter that the user named and the unit does not know."""
    named = Text(f"parameter {name} (61 {code:02X})", f"параметра {name} (61 {code:02X})")
    return NotSupported(command=named, request=bytes([0x61, code]))
