"""Which method is the fastest on this unit and this adapter: found by trying (D10, D11, D12).

Most of §3 was never tried by its author, and an adapter that hands bytes over in lumps turns the
order of the methods round. So each one is measured for a moment, and what it takes beyond its bytes
is kept: from that, and from the prices of plans (§5), the best is known for any other plan as well.
What was measured with one kind of adapter says nothing of another.

What comes while measuring are samples like any others.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping
from dataclasses import dataclass
from itertools import count
from math import log2
from statistics import median

from mikas.client import Ecu, Reading
from mikas.client.limits import MethodTiming
from mikas.client.polling import STREAMS, FixedMethod
from mikas.commands import Availability
from mikas.errors import EcuRefused, LineError, MikasError, NoConnection, SyncLost
from mikas.sampling.cycles import PlanCycles
from mikas.sampling.identity_check import IdentityCheck
from mikas.sampling.plan import Plan

CANDIDATES: tuple[FixedMethod, ...] = ("stream", "list", "batch")
"""In the order of §5: what should be the fastest first."""
FALLBACK: FixedMethod = "single"
"""What is left where none of them works."""
WITH_OWN_COMMANDS: frozenset[FixedMethod] = frozenset({"stream", "list"})
"""Those with commands of their own, which a unit may lack (D10); the others are all 61."""

_SECONDS = 1.0
_CYCLES = 6  # at least; one that sets lists, learns limits or begins a stream is not counted
_PATIENCE = 3  # line errors in a row
_ACCIDENT = 8  # times as long as the usual cycle
_AMPLE = 1.05  # of a rate that is enough
_PROBES = 5


@dataclass(frozen=True, slots=True)
class TrialResult:
    """How a method did: cycles a second; 0 if it brought nothing, `refused` if it never will."""

    method: FixedMethod
    rate: float
    refused: bool = False


Trial = Generator[dict[str, Reading] | MikasError, None, TrialResult]


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


def run_trial(
    ecu: Ecu,
    plan: Plan,
    identity_check: IdentityCheck | None = None,
    aside: Callable[[Callable[[], None]], bool] = lambda _: False,
) -> Trial:
    """Runs `plan` for a second: gives what came, and what went wrong; returns how fast it was.

    `aside` may ask for something else between two cycles, after it has called what it is given;
    returns whether it did. Raises a `NoConnection` if the unit goes away meanwhile, `SyncLost` if
    another one comes.
    """
    cycles = PlanCycles(ecu, plan, identity_check)
    clock = ecu.tester.link.now
    turns = filter(plan.sends_in, count())  # an empty cycle says nothing of the method
    turn = next(turns)
    spans: list[float] = []  # of the cycles
    before: float | None = None  # when the latest ended, if nothing else was asked since
    free = False  # for other things: not before each cycle, or nothing would ever be measured
    failures = 0
    try:
        while len(spans) < _CYCLES or sum(spans) < _SECONDS:
            try:
                if free and aside(cycles.pause):
                    before, free = None, False
                fresh = cycles.run(turn)
            except (NoConnection, SyncLost):
                raise
            except LineError as error:
                free = True
                failures += 1
                if failures == _PATIENCE:
                    return TrialResult(plan.method, 0.0, refused=cycles.is_refusal(error))
                yield error
                continue
            except MikasError as error:  # refused, or nobody allowed it
                yield error
                return TrialResult(plan.method, 0.0, refused=isinstance(error, EcuRefused))
            if fresh or plan.method not in STREAMS:
                failures, now = 0, clock()
                if before is not None:
                    spans.append(now - before)
                    free = True
                before, turn = now, next(turns)
            yield fresh
    finally:
        ended = _ended(cycles)
    # What can't be ended as it should is not to be begun again.
    return TrialResult(plan.method, _rate(spans) if ended else 0.0)


def _ended(cycles: PlanCycles) -> bool:
    try:
        cycles.pause()
    except LineError:
        return False
    return True


def _rate(spans: list[float]) -> float:
    """One repeated request says nothing of the method."""
    accident = max(spans) > _ACCIDENT * median(spans)
    counted = sorted(spans)[:-1] if accident else spans
    return len(counted) / sum(counted)


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
