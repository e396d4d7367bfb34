"""One plan on one unit, cycle after cycle, until the request changes or the plan fails."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

from mikas import errors
from mikas.catalog import Parameter
from mikas.client import Ecu, Reading
from mikas.client.parameters.polling import STREAMS, Poller, Turn, create_poller
from mikas.commands import Datum
from mikas.sampling.events import CycleFailed, Event
from mikas.sampling.plan import Plan, datum_of
from mikas.sampling.running.context import IdentityCheck, SamplingContext
from mikas.sampling.running.unsupported import UnsupportedParameters, explained

_BAD_LINE = 6  # failed cycles in a row after which another method may do better
_MOST_CYCLES = 1000  # whose requests are kept
_REFUSALS = 2  # refusals by the unit in a row after which the method is given up


class _Turns(NamedTuple):
    """The requests of one cycle, and the least number of readings if all are answered."""

    turns: tuple[Turn, ...]
    expected: int


class PlanCycles:
    """Runs `plan` on `ecu`, cycle by cycle.

    Between two cycles the line is free, except during a stream, which `poller.close` ends (D12).
    """

    def __init__(self, ecu: Ecu, plan: Plan, identity_check: IdentityCheck) -> None:
        self.ecu = ecu
        self.plan: Plan = plan
        self._identity_check = identity_check
        self._parameters = _parameters_of(plan)
        self._streams = plan.method in STREAMS
        self.poller: Poller = create_poller(ecu.parameters, plan.method, self._named(plan.fast))
        self._cycles: dict[int, _Turns] = {}  # by number within the plan's period
        if plan.method == "list":
            ecu.forget_list()  # the unit may have lost its supply since

    def use(self, plan: Plan) -> None:
        """Decode by `plan`, which sends the same requests in the same cycles; a stream goes on."""
        self.plan = plan
        self._parameters = _parameters_of(plan)
        self._cycles.clear()
        self.poller.use(self._named(plan.fast))

    def _named(self, data: tuple[Datum, ...]) -> list[Parameter]:
        return [parameter for datum in data for parameter in self._parameters[datum]]

    def expected(self, number: int) -> int:
        """Return the least number of readings of cycle `number` if all requests are answered."""
        return self._of(number).expected

    def run(self, number: int, *, goes_on: bool = False) -> dict[str, Reading]:
        """Run cycle `number` (from 0) and return its readings by name.

        `goes_on`: the next cycle follows at once, so its first request is sent meanwhile. Empty if
        none is due, or before a stream's first response. Raises a `LineError`, a `NoConnection`, or
        an `EcuRefused` if the unit refuses the method; `SyncLost` also if another unit may answer.
        """
        then = self._of(number + 1).turns[:1] if goes_on else ()
        try:
            fresh = self._read(self._of(number).turns, *then)
        except errors.NoResponse:
            if self._streams:
                self._identity_check.suspect()
            raise
        except errors.ReadingSuspended:
            self._identity_check.suspect()
            raise
        if fresh:
            self._identity_check.check(self.ecu, self.poller.close)
        return fresh

    def _read(self, turns: tuple[Turn, ...], then: Turn | None = None) -> dict[str, Reading]:
        """Run a cycle. Raises `ReadingSuspended`, once, also for a time before this cycle.

        Its readings could be of both sides of that time.
        """
        line = self.ecu.tester.line
        try:
            fresh = self.poller.cycle(turns, then)
        finally:
            suspension, line.suspension = line.suspension, None
        if suspension is not None:
            raise suspension
        return fresh

    def _of(self, number: int) -> _Turns:
        """Return the requests of cycle `number`, made once for all cycles that are alike."""
        place = number % self.plan.period
        if place not in self._cycles:
            if len(self._cycles) == _MOST_CYCLES:
                self._cycles.clear()
            wanted = self.ecu.parameters.wanted
            turns = [Turn(wanted(self._named(it))) for it in self.plan.requests(number)]
            if listed := self.plan.reads_list(number):
                turns.append(Turn(wanted(self._named(self.plan.fast)), listed=True))
            expected = 0  # a stream's response has all readings, or is damaged
            if not self._streams:
                counted = turns[-1:] if listed else turns if self.plan.method != "list" else []
                expected = sum(len(turn.wanted.parameters) for turn in counted)
            self._cycles[place] = _Turns(tuple(turns), expected)
        return self._cycles[place]


def _parameters_of(plan: Plan) -> dict[Datum, list[Parameter]]:
    """Return the parameters of `plan` by their datum, which some share."""
    parameters: dict[Datum, list[Parameter]] = {}
    for planned in plan.parameters:
        sharing = parameters.setdefault(datum_of(planned.parameter), [])
        if planned.parameter not in sharing:
            sharing.append(planned.parameter)
    return parameters


@dataclass(eq=False)
class PlanRunner:
    """Runs `whole`, the plan of the context's request, with those preferred that come first.

    A later request for the same data is served without a pause, and `whole` is its plan then.
    """

    ecu: Ecu
    whole: Plan
    context: SamplingContext
    unsupported: UnsupportedParameters

    def __post_init__(self) -> None:
        ecu, context = self.ecu, self.context
        self._first = context.first
        self._plan = plan = self._preferring_first()
        self._now = ecu.tester.link.now
        self._cycles = self._between = PlanCycles(ecu, plan, context.identity_check)
        self._streams = plan.method in STREAMS
        if self._streams:  # between two jobs a cycle by 61 replaces the stream
            self._between = PlanCycles(ecu, plan.with_method("batch"), context.identity_check)
        knowledge, baud = context.knowledge, ecu.tester.link.baud
        self._estimate = None if context.request.method else knowledge.rate_estimate(plan, baud)
        self._length = plan.price(baud=baud).seconds  # of a cycle, by price until measured
        self._failures = 0  # in a row
        self._refusals = 0  # of these, possible refusals by the unit
        self._worked = False
        self._over = False

    def _preferring_first(self) -> Plan:
        """Return the plan with those preferred, unless all reach the requested rate anyway."""
        whole, rate, baud = self.whole, self.context.request.rate, self.ecu.tester.link.baud
        if rate is not None:
            known = self.context.knowledge.rates(whole, baud)
            if known.get(whole.method, whole.price(baud=baud).rate) >= rate:
                return whole
        return whole.preferring(self._first)

    def events(self) -> Generator[Event, None, bool]:
        """Yield events until the plan ends; return whether others come first, by another plan.

        They begin with the plan, and another follows if a later request needs no other plan.

        Raises `NoConnection` and `SyncLost`; with `strict` also the requested method's refusal.
        """
        number, goes_on = 0, False
        yield from self.context.report_plan(self._plan, self._now())
        self.context.unended = None
        try:
            while True:
                yield from self._follow_request()
                if self._is_over():
                    return False
                others = self.context.first is not self._first
                if others and not goes_on:  # else a cycle has begun
                    self._first = self.context.first
                    if self._preferring_first() != self._plan:
                        return True
                cycles = self._cycles
                if self.context.jobs:
                    yield from self._pause()
                    self.context.jobs.run(self.ecu)
                    cycles = self._between
                if not self._is_time_for(cycles):
                    continue
                goes_on = cycles is self._cycles and self._goes_on and not others
                yield from self._cycle(cycles, number, goes_on=goes_on)
                number += 1
        finally:
            with suppress(errors.LineError):  # the next exchange finds the line's fault
                self._close()

    def _follow_request(self) -> Iterator[Event]:
        """Serve the latest request from here on if it needs the same data in the same cycles."""
        context, latest = self.context, self.context.latest
        if context.request is latest or not context.goes_on_with(latest, self.whole.method):
            return
        left = self.unsupported.remaining(latest)
        whole = None if left is None else left.with_method(self.whole.method)
        if whole is None or not whole.reads_as(self.whole):
            return
        before, self.whole = self.whole, whole
        plan = self._preferring_first()
        if not plan.reads_as(self._plan):
            self.whole = before
            return
        self._plan, context.request, context.is_reported = plan, latest, False
        self.ecu.use_catalog(latest.selection.catalog)
        self._cycles.use(plan)
        if self._between is not self._cycles:
            self._between.use(plan.with_method("batch"))
        yield from context.report_plan(plan, self._now())

    def _is_over(self) -> bool:
        return (
            self._over
            or not self.context.is_current
            or (not self._failures and self.unsupported.dropped.is_due(self._now()))
        )

    @property
    def _goes_on(self) -> bool:
        """Whether the next cycle follows at once."""
        context = self.context
        return context.request.rate is None and not context.jobs and context.is_current

    def _close(self) -> None:
        try:
            self._cycles.poller.close()
        except errors.LineNotQuiet as error:
            self.context.unended = error  # there may be no next exchange (D12)
            raise

    def _cycle(self, cycles: PlanCycles, number: int, *, goes_on: bool) -> Iterator[Event]:
        began = self._now()
        if not cycles.plan.sends_in(number):
            if cycles is self._cycles:
                self.context.schedule_empty_cycle(began, self._length)
            return
        try:
            fresh = cycles.run(number, goes_on=goes_on)
        except (errors.NoConnection, errors.SyncLost):
            raise
        except errors.MikasError as error:
            yield CycleFailed(
                self._now(), explained(self.ecu, cycles.plan, error, worked=self._worked)
            )
            yield from self._handle_failure(error, cycles)
            return
        if cycles is self._cycles:
            self._length = self._now() - began
            self._compare_with_estimate(began, whole=bool(fresh) or not self._streams)
        if fresh:
            self._failures = self._refusals = 0
            self._worked = True
            yield from self.context.sampled(fresh)
        if len(fresh) < cycles.expected(number):
            refuses = cycles.ecu.parameters.refuses
            self._over |= any(refuses([p.parameter]) for p in self._plan.parameters)

    def _handle_failure(self, error: errors.MikasError, cycles: PlanCycles) -> Iterator[Event]:
        """Find whether the line, a parameter or the method causes `error`."""
        strict = self.context.strict and not self.context.has_sampled
        if strict and self.context.request.method and not isinstance(error, errors.LineError):
            raise error
        self._failures += 1
        if not isinstance(error, errors.LineError | errors.EcuRefused):
            self._refusals = _REFUSALS  # not confirmed by the user
        elif cycles.poller.is_refusal(error):
            self._refusals += 1
            dropping = self.unsupported.drop_unsupported(self.ecu, self._plan, going=True)
            if (yield from dropping) or not self.context.is_current:
                self._over = True
                return
        if self._refusals >= _REFUSALS:
            self.context.knowledge.record_failure(self._plan.method)
            self._over = True
        elif self._failures >= _BAD_LINE and self.context.request.method is None:
            self.context.knowledge.invalidate()
            self._over = True

    def _compare_with_estimate(self, began: float, *, whole: bool) -> None:
        if self._estimate is None:
            return
        confirmed = self._estimate.count(self._now() - began, whole=whole)
        if confirmed is None:
            return
        self._estimate = None
        if confirmed:
            self.context.knowledge.confirm()
        else:
            self.context.knowledge.invalidate()
            self._over = True

    def _is_time_for(self, cycles: PlanCycles) -> bool:
        """Wait for the next cycle, but not of a stream; False: a job or a request came first."""
        if self._streams and cycles is self._cycles:
            return True
        return self.context.wait_until_due(self.ecu)

    def _pause(self) -> Generator[Event, None, None]:
        try:
            self._cycles.poller.close()
        except errors.LineError as error:
            yield CycleFailed(self._now(), error)
