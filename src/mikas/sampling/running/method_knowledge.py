"""Timings of the methods on one unit and adapter, and the choice of the fastest (D10–D12).

The author of §3 never tried most of it, and an adapter that delivers bytes in lumps reverses the
order of the methods. So each method is measured for a second (`method_trial`). Its delay beyond its
bytes and the prices of plans (§5) give its rate for any other plan with this kind of adapter.

Saved timings of the unit and this kind of adapter are loaded; a choice by saved timings is compared
with the first cycles. A method that fails is measured again; after the second failure it is not
used any more.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import log2
from statistics import median

from mikas.client import Ecu
from mikas.client.limits import STARTING_LIST, MethodTiming
from mikas.client.parameters.polling import STREAMS, FixedMethod
from mikas.commands import Availability
from mikas.errors import LineError
from mikas.sampling.plan import Plan, Price

CANDIDATES: tuple[FixedMethod, ...] = ("stream", "list", "batch")
"""In the order of §5: the presumably fastest first."""
FALLBACK: FixedMethod = "single"
"""Used if none of `CANDIDATES` works."""
WITH_OWN_COMMANDS: frozenset[FixedMethod] = frozenset({"stream", "list"})
"""Methods with their own commands, which a unit may lack (D10); the others use 61."""
_AMPLE = 1.05  # times a sufficient rate
_PROBES = 5
_SLOWER = 0.75  # of the estimated rate; below, the adapter or the computer has changed
_CYCLES, _SECONDS = 6, 1.0  # after which an estimate is compared
_OFTEN = 2
_BAUD = 9600  # §1
_NEVER = MethodTiming(0, None)  # refused, however short the list is


class MethodKnowledge:
    """The methods of one unit; another unit gets a new one."""

    def __init__(self) -> None:
        self.method: FixedMethod | None = None
        """The choice reported last."""
        self.max_list = STARTING_LIST
        """The longest list that the unit accepts by 61, as known (D11)."""
        self._timings: dict[str, dict[str, MethodTiming]] = {}
        self._kind = ""
        self._ecu: Ecu | None = None
        self._confirmed: set[str] = set()  # kinds of adapter
        self._tried: set[FixedMethod] = set()
        self.failures: Counter[FixedMethod] = Counter()
        """How often a method has failed since it was requested; after twice it is not chosen."""

    def begin_trials(self, ecu: Ecu) -> None:
        """Identify the adapter if it may be another one; load the timings with its kind."""
        self._tried.clear()
        if ecu is self._ecu:
            return
        self._ecu = ecu
        try:
            self._kind = kind_of_adapter(ecu)
            kinds = ecu.limits().methods
        except LineError:
            self._kind, kinds = "", {}  # unknown on such a line
        # A command that the unit lacks is missing with every adapter.
        found = [each.items() for each in (*kinds.values(), *self._timings.values())]
        lacks = {name: timing for timings in found for name, timing in timings if timing == _NEVER}
        self._timings.setdefault(self._kind, lacks | kinds.get(self._kind, {}))

    @property
    def _known(self) -> dict[str, MethodTiming]:
        return self._timings.setdefault(self._kind, {})

    def next_to_measure(self, plan: Plan, enough: float | None, baud: int) -> FixedMethod | None:
        """Return the method to measure next; None: the known rates suffice."""
        rates = self.rates(plan, baud)
        good = best_method(rates, enough)
        if enough and good is not None and rates[good] >= enough and good in CANDIDATES:
            return None
        order = reversed(CANDIDATES) if enough else CANDIDATES
        untested = [method for method in order if method not in rates]
        if good is None:
            untested.append(FALLBACK)
        left = [method for method in untested if method not in self._tried]
        self._tried.update(left[:1])
        return left[0] if left else None

    def record(self, measured: TrialResult, plan: Plan, baud: int) -> None:
        """Record the result of a trial."""
        self._confirmed.add(self._kind)
        timing = timing_of(measured, plan, baud)
        if timing is not None:
            self._known[measured.method] = timing

    def record_missing(self, method: FixedMethod) -> None:
        """Record that the unit lacks `method`, however short the list is."""
        self._known[method] = _NEVER

    def save(self) -> None:
        """Save the timings for the next session."""
        if self._ecu is not None and self._kind:
            self._ecu.keep_timings(self._kind, self._known)

    def rates(self, plan: Plan, baud: int) -> dict[FixedMethod, float]:
        """Return cycles a second of every known method for `plan`."""
        rates = rates_of(plan, self._known, baud)
        return rates | {m: 0.0 for m, count in self.failures.items() if count >= _OFTEN}

    def price(
        self, plan: Plan, method: FixedMethod | None, first: frozenset[str] = frozenset()
    ) -> Price:
        """Return the price of a cycle with the measured delay, or with that of §5.

        `method` None: the fastest known one, else batch. `first`: as for `Plan.preferring`.
        """
        known = self._timings.get(self._kind, {})
        plan = replace(plan, max_list=self.max_list)
        if method is None:
            method = best_method(rates_of(plan, known, _BAUD)) or "batch"
        timing = known.get(method)
        by = plan.with_method(method).preferring(first)
        if timing is None or timing.delay is None:
            return by.price()
        return by.price(turn_round=timing.delay, pause=timing.delay)

    def record_failure(self, method: FixedMethod) -> None:
        """Count a failure of `method`; all methods are to be measured again."""
        self.failures[method] += 1
        self.invalidate()

    def invalidate(self) -> None:
        """Forget the rates with this kind of adapter; refusals of the unit stay."""
        known = self._known.items()
        self._timings[self._kind] = {
            name: timing
            for name, timing in known
            if timing.delay is None and name in WITH_OWN_COMMANDS
        }

    def rate_estimate(self, plan: Plan, baud: int) -> RateEstimate | None:
        """Return the rate to compare with the first cycles, for a choice by saved timings."""
        if self._kind in self._confirmed:
            return None
        rate = self.rates(plan, baud).get(plan.method, 0.0)
        return RateEstimate(rate) if rate else None

    def confirm(self) -> None:
        """The estimated rate was confirmed by the first cycles."""
        self._confirmed.add(self._kind)


class RateEstimate:
    """A rate by saved timings, compared with the first cycles."""

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._cycles = -1  # the first, which sets lists or begins the stream, is not counted
        self._seconds = 0.0

    def count(self, seconds: float, *, whole: bool) -> bool | None:
        """Count `seconds`, and a cycle if `whole`; return whether the rate is true, None: wait."""
        if self._cycles >= 0:
            self._seconds += seconds
        self._cycles += whole
        if self._cycles < _CYCLES or self._seconds < _SECONDS:
            return None
        return self._cycles >= _SLOWER * self._rate * self._seconds


@dataclass(frozen=True, slots=True)
class TrialResult:
    """The cycles a second of a method; 0 if it failed, `refused` if the unit lacks it."""

    method: FixedMethod
    rate: float
    refused: bool = False


def kind_of_adapter(ecu: Ecu) -> str:
    """Return the port's description with its delay in ms, rounded to a power of two.

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
    """Return the timing by `measured`, which applies to other plans too; None: failed."""
    codes = len(plan.with_method(measured.method).fast)
    if not measured.rate:
        return MethodTiming(codes, None) if measured.refused else None
    wire, responses = _cost(plan.with_method(measured.method), baud)
    return MethodTiming(codes, max(0.0, (1 / measured.rate - wire) / responses))


def rates_of(
    plan: Plan, timings: Mapping[str, MethodTiming], baud: int
) -> dict[FixedMethod, float]:
    """Return cycles a second of each method whose timing is known for `plan`."""
    rates: dict[FixedMethod, float] = {}
    for method in (*CANDIDATES, FALLBACK):
        by = plan.with_method(method)
        timing, codes = timings.get(method), len(by.fast)
        if timing is None or (
            timing.delay is None and codes < timing.codes and codes <= plan.max_list
        ):
            continue  # the unit may accept a shorter list than the refused one
        wire, responses = _cost(by, baud)
        rates[method] = 0.0 if timing.delay is None else 1 / (wire + responses * timing.delay)
    return rates


def best_method(
    rates: Mapping[FixedMethod, float], enough: float | None = None
) -> FixedMethod | None:
    """Return the fastest method, or the simplest that reaches the rate `enough`; None: none."""
    working = {method: rate for method, rate in rates.items() if rate > 0}
    if enough is not None:
        for method in reversed(CANDIDATES):
            if working.get(method, 0.0) >= enough * _AMPLE:
                return method
    return max(working, key=lambda method: working[method], default=None)


def _cost(plan: Plan, baud: int) -> tuple[float, float]:
    """Return the seconds on the wire and the number of responses of a cycle with requests."""
    price = plan.price(baud=baud, turn_round=0.0)
    return price.seconds, 1.0 if plan.method in STREAMS else price.requests / plan.busy_share
