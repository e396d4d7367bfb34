"""One plan on one unit, cycle after cycle, until something else is wanted or it has to be made
anew.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import suppress

from mikas.client import Ecu, Reading
from mikas.client.polling import STREAMS
from mikas.errors import EcuRefused, LineError, MikasError, NoConnection, SyncLost
from mikas.sampling.context import SamplingContext, SamplingRequest
from mikas.sampling.cycles import PlanCycles
from mikas.sampling.events import CycleFailed, Event
from mikas.sampling.identity_check import IdentityCheck
from mikas.sampling.plan import Plan
from mikas.sampling.reasons import explained
from mikas.sampling.unsupported import UnsupportedParameters

_BAD_LINE = 6  # failed cycles in a row after which another method may do better
_DOUBTS = 2  # of the unit's refusals in a row after which the method is given up


class PlanRunner:
    """Runs `plan`, which is made of `requested`."""

    def __init__(
        self,
        ecu: Ecu,
        plan: Plan,
        requested: SamplingRequest,
        *,
        context: SamplingContext,
        unsupported: UnsupportedParameters,
        identity_check: IdentityCheck,
    ) -> None:
        self._ecu = ecu
        self._plan = plan
        self._request = requested
        self._context = context
        self._unsupported = unsupported
        self._now = ecu.tester.link.now
        self._cycles = PlanCycles(ecu, plan, identity_check)
        self._streams = plan.method in STREAMS
        # Between one-off requests a stream is not begun again: it is asked once, by 61.
        self._between = (
            PlanCycles(ecu, plan.with_method("batch"), identity_check)
            if self._streams
            else self._cycles
        )
        knowledge, baud = context.knowledge, ecu.tester.link.baud
        self._promise = None if requested.method else knowledge.rate_estimate(plan, baud)
        self._length = plan.price(baud=baud).seconds  # of a cycle, until one was measured
        self._failures = 0  # in a row
        self._doubts = 0  # of these, those that may be the unit's answer
        self._worked = False
        self._over = False

    def events(self) -> Iterator[Event]:
        """What happens. Raises the `NoConnection` or `SyncLost` that ends it, and what `strict`
        says.
        """
        number = 0
        try:
            while not self._over and self._context.is_current(self._request):
                cycles = self._cycles
                if self._context.jobs:
                    yield from self._pause()
                    self._context.jobs.run(self._ecu)
                    cycles = self._between
                if not self._is_time_for(cycles):
                    continue
                yield from self._cycle(cycles, number)
                number += 1
        finally:
            with suppress(LineError):  # who comes next finds out how the line is
                self._cycles.pause()

    def _cycle(self, cycles: PlanCycles, number: int) -> Iterator[Event]:
        began = self._now()
        if not cycles.plan.sends_in(number):
            if cycles is self._cycles:
                self._context.schedule_empty_cycle(began, self._length)
            return
        try:
            fresh = cycles.run(number)
        except (NoConnection, SyncLost):
            raise
        except MikasError as error:
            yield CycleFailed(
                self._now(), explained(self._ecu, cycles.plan, error, worked=self._worked)
            )
            yield from self._after(error, cycles)
            return
        if cycles is self._cycles:
            self._length = self._now() - began
            self._hold_against_promise(began, whole=bool(fresh) or not self._streams)
        if fresh:
            yield from self._sampled(fresh)
        if len(fresh) < cycles.expected(number):
            wanted = self._plan.parameters
            self._over |= any(cycles.refuses(w.parameter) for w in wanted)

    def _sampled(self, fresh: dict[str, Reading]) -> Iterator[Event]:
        self._failures = self._doubts = 0
        self._worked = True
        sampled = self._context.sample_of(fresh)
        if self._context.is_due(sampled):
            yield sampled

    def _after(self, error: MikasError, cycles: PlanCycles) -> Iterator[Event]:
        """After `error`: is it the line, a parameter, or the method?"""
        strict = self._context.strict and not self._context.has_sampled
        if strict and self._request.method and not isinstance(error, LineError):
            raise error
        self._failures += 1
        if not isinstance(error, LineError | EcuRefused):
            self._doubts = _DOUBTS  # nobody allowed it
        elif cycles.is_refusal(error):
            self._doubts += 1
            weed = self._unsupported.drop_unsupported(
                self._ecu, self._plan, self._request, going=True
            )
            if (yield from weed) or not self._context.is_current(self._request):
                self._over = True
                return
        if self._doubts >= _DOUBTS:
            self._context.knowledge.record_failure(self._plan.method)
            self._over = True
        elif self._failures >= _BAD_LINE and self._request.method is None:
            self._context.knowledge.invalidate()
            self._over = True

    def _hold_against_promise(self, began: float, *, whole: bool) -> None:
        if self._promise is None:
            return
        kept = self._promise.count(self._now() - began, whole=whole)
        if kept is None:
            return
        self._promise = None
        if kept:
            self._context.knowledge.confirm()
        else:
            self._context.knowledge.invalidate()
            self._over = True

    def _is_time_for(self, cycles: PlanCycles) -> bool:
        """Waits for the next cycle's time; False: somebody wants something before. A stream keeps
        its own time, and what comes too early is left out.
        """
        if self._streams and cycles is self._cycles:
            return True
        return self._context.wait_until_due(self._ecu, self._request)

    def _pause(self) -> Generator[Event, None, None]:
        try:
            self._cycles.pause()
        except LineError as error:
            yield CycleFailed(self._now(), error)
