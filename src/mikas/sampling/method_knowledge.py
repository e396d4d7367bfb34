"""What is known of one unit's methods while it is sampled, and the choice between them.

It begins with what was kept for the unit and this kind of adapter; a choice made of that alone is
held against what the first cycles show. A method that let its user down is measured again, and
after the second time not used any more.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import log2
from statistics import median

from mikas.client import Ecu
from mikas.client.limits import STARTING_LIST, MethodTiming
from mikas.client.polling import STREAMS, FixedMethod
from mikas.commands import Availability
from mikas.errors import LineError
from mikas.sampling.plan import Plan, Price

CANDIDATES: tuple[FixedMethod, ...] = ("stream", "list", "batch")
"""In the order of §5: what should be the fastest first."""
FALLBACK: FixedMethod = "single"
"""What is left where none of them works."""
WITH_OWN_COMMANDS: frozenset[FixedMethod] = frozenset({"stream", "list"})
"""Those with commands of their own, which a unit may lack (D10); the others are all 61."""
_AMPLE = 1.05  # of a rate that is enough
_PROBES = 5
_SLOWER = 0.75  # of what was promised: then it is another adapter, or another system
_CYCLES, _SECONDS = 6, 1.0  # that a promise is held against
_OFTEN = 2
_BAUD = 9600  # §1
_NEVER = MethodTiming(0, None)  # refused, however short the list is


class MethodKnowledge:
    """Of one unit; a new one for another unit."""

    def __init__(self) -> None:
        self.method: FixedMethod | None = None
        """The choice that was told last."""
        self.max_list = STARTING_LIST
        """The longest list that the unit is asked for by 61, as far as is known (D11)."""
        self._paces: dict[str, dict[str, MethodTiming]] = {}
        self._kind = ""
        self._ecu: Ecu | None = None
        self._proved: set[str] = set()  # kinds of adapter
        self._tried: set[FixedMethod] = set()
        self._blamed: Counter[FixedMethod] = Counter()

    def begin_trials(self, ecu: Ecu) -> None:
        """Looks at the adapter, if it may be another one; recalls what is known with such."""
        self._tried.clear()
        if ecu is self._ecu:
            return
        self._ecu = ecu
        try:
            self._kind = kind_of_adapter(ecu)
            kinds = ecu.limits().methods
        except LineError:
            self._kind, kinds = "", {}  # no telling on such a line
        # What the unit does not know it knows with no adapter.
        found = [each.items() for each in (*kinds.values(), *self._paces.values())]
        lacks = {name: pace for paces in found for name, pace in paces if pace == _NEVER}
        self._paces.setdefault(self._kind, lacks | kinds.get(self._kind, {}))

    @property
    def _known(self) -> dict[str, MethodTiming]:
        return self._paces.setdefault(self._kind, {})

    def next_to_measure(self, plan: Plan, enough: float | None, baud: int) -> FixedMethod | None:
        """The method to be tried next; None: enough is known."""
        rates = self.rates(plan, baud)
        good = best_method(rates, enough)
        if enough and good is not None and rates[good] >= enough and good in CANDIDATES:
            return None
        left = untested(rates, enough, without=self._tried)
        if not left and good is None and FALLBACK not in self._tried:
            left = [FALLBACK]
        if left:
            self._tried.add(left[0])
            return left[0]
        return None

    def record(self, measured: TrialResult, plan: Plan, baud: int) -> None:
        """What was measured just now."""
        self._proved.add(self._kind)
        pace = timing_of(measured, plan, baud)
        if pace is not None:
            self._known[measured.method] = pace

    def record_missing(self, method: FixedMethod) -> None:
        """The unit does not know it, however short the list is."""
        self._known[method] = _NEVER

    def save(self) -> None:
        """For the next context."""
        if self._ecu is not None and self._kind:
            self._ecu.keep_timings(self._kind, self._known)

    def rates(self, plan: Plan, baud: int) -> dict[FixedMethod, float]:
        """Cycles a second of every candidate that is known for such a plan."""
        rates = rates_of(plan, self._known, baud)
        return rates | {m: 0.0 for m, count in self._blamed.items() if count >= _OFTEN}

    def price(self, plan: Plan, method: FixedMethod | None) -> Price:
        """What a cycle would cost, with the delays that were measured; §5's where none was.

        `method` None: the best of those that are known, or batch.
        """
        known = self._paces.get(self._kind, {})
        plan = replace(plan, max_list=self.max_list)
        if method is None:
            method = best_method(rates_of(plan, known, _BAUD)) or "batch"
        pace = known.get(method)
        by = plan.with_method(method)
        if pace is None or pace.delay is None:
            return by.price()
        return by.price(turn_round=pace.delay, pause=pace.delay)

    def record_failure(self, method: FixedMethod) -> None:
        """It worked, or should have, and does not: what works is to be measured anew."""
        self._blamed[method] += 1
        self.invalidate()

    def has_failed(self, method: FixedMethod) -> bool:
        """Whether it has let its user down before."""
        return self._blamed[method] > 0

    def reset_failures(self, method: FixedMethod) -> None:
        """It is wanted once more."""
        del self._blamed[method]

    def invalidate(self) -> None:
        """The rates known of this kind of adapter are not so; what the unit refuses it refuses."""
        known = self._known.items()
        self._paces[self._kind] = {
            name: pace for name, pace in known if pace.delay is None and name in WITH_OWN_COMMANDS
        }

    def rate_estimate(self, plan: Plan, baud: int) -> RateEstimate | None:
        """What the first cycles have to show, if the choice was made from memory."""
        if self._kind in self._proved:
            return None
        rate = self.rates(plan, baud).get(plan.method, 0.0)
        return RateEstimate(rate) if rate else None

    def confirm(self) -> None:
        """The promise was kept."""
        self._proved.add(self._kind)


class RateEstimate:
    """A rate that the first cycles are held against."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._cycles = -1  # the first sets lists or begins the stream, and is not counted
        self._seconds = 0.0

    def count(self, seconds: float, *, whole: bool) -> bool | None:
        """`seconds` went by, in which a cycle ended if `whole`. Whether it was kept; None: wait."""
        if self._cycles >= 0:
            self._seconds += seconds
        self._cycles += whole
        if self._cycles < _CYCLES or self._seconds < _SECONDS:
            return None
        return self._cycles >= _SLOWER * self._rate * self._seconds


@dataclass(frozen=True, slots=True)
class TrialResult:
    """How a method did: cycles a second; 0 if it brought nothing, `refused` if it never will."""

    method: FixedMethod
    rate: float
    refused: bool = False


def kind_of_adapter(ecu: Ecu) -> str:
    """What is behind the port, and about how long its answers are held up, to a factor of two.

    Raises a `LineError` or a `NoConnection`.
    """
    tester, link = ecu.tester, ecu.tester.link
    delays = []
    for _ in range(_PROBES):
        began = link.now()
        _, reply = tester.exchange(Availability())
        wire = (len(reply.wire) + 3) * link.byte_time  # and 01 FF 0D
        delays.append(link.now() - began - wire)
    ms = 2 ** max(0, round(log2(max(median(delays), 1e-6) * 1000)))
    return f"{link.description}, {ms} ms"


def timing_of(measured: TrialResult, plan: Plan, baud: int) -> MethodTiming | None:
    """What `measured` says of other plans too; None: nothing."""
    codes = len(plan.with_method(measured.method).fast)
    if not measured.rate:
        return MethodTiming(codes, None) if measured.refused else None
    wire, responses = _cost(plan.with_method(measured.method), baud)
    return MethodTiming(codes, max(0.0, (1 / measured.rate - wire) / responses))


def rates_of(plan: Plan, paces: Mapping[str, MethodTiming], baud: int) -> dict[FixedMethod, float]:
    """Cycles a second by each candidate of which anything is known for such a plan."""
    rates: dict[FixedMethod, float] = {}
    for method in (*CANDIDATES, FALLBACK):
        by = plan.with_method(method)
        pace, codes = paces.get(method), len(by.fast)
        if pace is None or (pace.delay is None and codes < pace.codes and codes <= plan.max_list):
            continue  # a shorter list than the one that was refused may be taken
        wire, responses = _cost(by, baud)
        rates[method] = 0.0 if pace.delay is None else 1 / (wire + responses * pace.delay)
    return rates


def best_method(
    rates: Mapping[FixedMethod, float], enough: float | None = None
) -> FixedMethod | None:
    """The fastest; of those that give a rate that is `enough`, the one that does least to the unit.

    None: none works.
    """
    working = {method: rate for method, rate in rates.items() if rate > 0}
    if enough is not None:
        for method in reversed(CANDIDATES):
            if working.get(method, 0.0) >= enough * _AMPLE:
                return method
    return max(working, key=lambda method: working[method], default=None)


def untested(
    known: Iterable[FixedMethod], enough: float | None, without: Iterable[FixedMethod] = ()
) -> list[FixedMethod]:
    """The candidates of which nothing is known, in the order of trying."""
    skipped = {*known, *without}
    order = reversed(CANDIDATES) if enough else CANDIDATES
    return [method for method in order if method not in skipped]


def _cost(plan: Plan, baud: int) -> tuple[float, float]:
    """Seconds on the wire, and responses, of a cycle that asks for anything."""
    price = plan.price(baud=baud, turn_round=0.0)
    return price.seconds, 1.0 if plan.method in STREAMS else price.requests / plan.busy_share
