"""Trials: a method runs for a second, and its rate is measured.

Sampling continues during a trial: readings are samples, jobs run between two cycles, and `stop`
works. A refusal may mean that the list is too long (D11), so the shortest list is tried next; if
that is refused too, the unit lacks the method.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from dataclasses import replace
from itertools import count
from statistics import median

from mikas.client import Ecu, Reading
from mikas.client.polling import STREAMS
from mikas.errors import EcuRefused, LineError, MikasError, NoConnection, SyncLost
from mikas.sampling.context import SamplingContext, SamplingRequest
from mikas.sampling.events import CycleFailed, Event
from mikas.sampling.method_knowledge import WITH_OWN_COMMANDS, TrialResult
from mikas.sampling.plan import Plan, datum_of
from mikas.sampling.plan_runner import PlanCycles
from mikas.sampling.supervisor import IdentityCheck

_SECONDS = 1.0
_CYCLES = 6  # at least; one that sets lists, finds limits or begins a stream is not counted
_MOST_ERRORS = 3  # line errors in a row
_OUTLIER = 8  # times the usual cycle
Trial = Generator[dict[str, Reading] | MikasError, None, TrialResult]
_SHORTEST = 2  # data: distinct from a lone 01


class MethodTrials:
    """Measures methods and records the results in `context.knowledge`."""

    def __init__(self, context: SamplingContext, identity_check: IdentityCheck) -> None:
        self._context = context
        self._identity_check = identity_check

    def learn(self, ecu: Ecu, plan: Plan, requested: SamplingRequest) -> Iterator[Event]:
        """Measure the rate of `plan`, unless `requested` is replaced meanwhile."""
        measured = yield from self._try(ecu, plan, requested)
        if measured is None:
            return
        self._context.knowledge.record(measured, plan, ecu.tester.link.baud)
        if measured.refused and plan.method in WITH_OWN_COMMANDS:
            yield from self._try_shortest(ecu, plan, requested)

    def _try(
        self, ecu: Ecu, plan: Plan, requested: SamplingRequest
    ) -> Generator[Event, None, TrialResult | None]:
        context, link = self._context, ecu.tester.link

        def run_pending(pause: Callable[[], None]) -> bool:
            if not context.jobs:
                return False
            pause()
            context.jobs.run(ecu)
            return True

        with closing(run_trial(ecu, plan, self._identity_check, run_pending)) as trial:
            while context.is_current(requested):
                try:
                    result = next(trial)
                except StopIteration as end:
                    measured: TrialResult = end.value
                    return measured
                if isinstance(result, MikasError):
                    yield CycleFailed(link.now(), result)
                else:
                    yield from self._sampled(result)
        return None

    def _try_shortest(self, ecu: Ecu, plan: Plan, requested: SamplingRequest) -> Iterator[Event]:
        """Find out whether the unit refused the length of the list or the method."""
        short = yield from self._shortest_answered(ecu, plan)
        if short is None:
            return  # the unit may refuse the parameters
        if len(plan.fast) > len(short.fast):
            self._context.jobs.run(ecu)
            if not self._refused(ecu, short, requested):
                return
            yield from self._shortest_answered(ecu, plan)
        self._context.knowledge.record_missing(plan.method)

    def _shortest_answered(self, ecu: Ecu, plan: Plan) -> Generator[Event, None, Plan | None]:
        """Run a cycle by 61; return the shortest plan of its readings, by `plan`'s method."""
        context, now = self._context, ecu.tester.link.now
        try:
            fresh = PlanCycles(ecu, plan.with_method("batch"), self._identity_check).run(0)
        except (NoConnection, SyncLost):
            raise
        except MikasError as error:
            yield CycleFailed(now(), error)
            return None
        yield from self._sampled(fresh)
        size = min(_SHORTEST, context.knowledge.max_list)
        read = {datum_of(p.parameter): p for p in plan.parameters if p.parameter.name in fresh}
        short = tuple(replace(planned, divisor=1) for planned in list(read.values())[:size])
        return Plan(short, plan.method) if short else None

    def _sampled(self, fresh: dict[str, Reading]) -> Iterator[Event]:
        if fresh and self._context.is_due(sampled := self._context.sample_of(fresh)):
            yield sampled

    def _refused(self, ecu: Ecu, short: Plan, requested: SamplingRequest) -> bool:
        """Return whether the unit refuses `short`; False if `requested` is replaced meanwhile."""
        with closing(run_trial(ecu, short, self._identity_check)) as trial:
            while self._context.is_current(requested):
                try:
                    result = next(trial)
                except StopIteration as end:
                    return bool(end.value.refused)
                if result and not isinstance(result, MikasError):
                    break
        return False


def run_trial(
    ecu: Ecu,
    plan: Plan,
    identity_check: IdentityCheck | None = None,
    run_pending: Callable[[Callable[[], None]], bool] = lambda _: False,
) -> Trial:
    """Run `plan` for a second: yield readings and errors, return the rate.

    `run_pending` calls its argument, a pause, before it runs jobs, and returns whether it ran any.
    Raises a `NoConnection` if the unit stops answering, `SyncLost` if another unit answers.
    """
    cycles = PlanCycles(ecu, plan, identity_check)
    clock = ecu.tester.link.now
    numbers = filter(plan.sends_in, count())  # without empty cycles
    number = next(numbers)
    spans: list[float] = []  # of the cycles
    before: float | None = None  # the end of the latest cycle, if no job ran since
    free = False  # for jobs: not before each cycle, or no cycle would be measured
    failures = 0
    try:
        while len(spans) < _CYCLES or sum(spans) < _SECONDS:
            try:
                if free and run_pending(cycles.pause):
                    before, free = None, False
                fresh = cycles.run(number)
            except (NoConnection, SyncLost):
                raise
            except LineError as error:
                free = True
                failures += 1
                if failures == _MOST_ERRORS:
                    return TrialResult(plan.method, 0.0, refused=cycles.is_refusal(error))
                yield error
                continue
            except MikasError as error:  # refused, or not confirmed by the user
                yield error
                return TrialResult(plan.method, 0.0, refused=isinstance(error, EcuRefused))
            if fresh or plan.method not in STREAMS:
                failures, now = 0, clock()
                if before is not None:
                    spans.append(now - before)
                    free = True
                before, number = now, next(numbers)
            yield fresh
    finally:
        ended = _ended(cycles)
    # A method that cannot be ended properly must not be chosen.
    return TrialResult(plan.method, _rate(spans) if ended else 0.0)


def _ended(cycles: PlanCycles) -> bool:
    try:
        cycles.pause()
    except LineError:
        return False
    return True


def _rate(spans: list[float]) -> float:
    """Return cycles a second, without a cycle made long by a repeated request."""
    has_outlier = max(spans) > _OUTLIER * median(spans)
    counted = sorted(spans)[:-1] if has_outlier else spans
    return len(counted) / sum(counted)
