"""Which method is the fastest on this unit and this adapter: found by trying (D10, D11, D12).

Most of §3 was never tried by its author, and an adapter that hands bytes over in lumps turns the
order of the methods round. So each one that works is measured for a moment, and the best is taken.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from mikas.client import Ecu
from mikas.errors import EcuRefused, LineError, MikasError
from mikas.sampling.cycles import cycles_of
from mikas.sampling.plan import Method, Plan

CANDIDATES: tuple[Method, ...] = ("stream", "list", "batch", "single")
"""In the order of §5: what should be the fastest first."""

_SECONDS = 1.0
_CYCLES = 6  # at least; the first one sets lists and learns limits, and is not counted


@dataclass(frozen=True, slots=True)
class Measured:
    """How a method did: cycles a second; 0 if the unit does not take it, or the line did not."""

    method: Method
    rate: float
    error: MikasError | None = None


def measure(ecu: Ecu, plan: Plan) -> Iterator[Measured]:
    """Each candidate in turn, a second each. `single` is only tried if nothing else works.

    Raises a `NoConnection` if the unit goes away meanwhile.
    """
    works = False
    for method in CANDIDATES:
        if method == "single" and works:
            return
        result = _try(ecu, plan.by(method))
        works = works or result.rate > 0
        yield result


def _try(ecu: Ecu, plan: Plan) -> Measured:
    cycles = cycles_of(ecu, plan)
    clock = ecu.tester.link.now
    try:
        try:
            cycles.run(0)
            began = clock()
            number = 0
            while number < _CYCLES or clock() - began < _SECONDS:
                number += 1
                cycles.run(number)
            seconds = clock() - began
        finally:
            cycles.close()
    except (EcuRefused, LineError) as error:
        return Measured(plan.method, 0.0, error)
    return Measured(plan.method, number / seconds)
