"""Trials: a method runs for a second, and its rate is measured.

Sampling continues during a trial: readings are samples, jobs run between two cycles, and `stop`
works. A refusal may mean that the list is too long (D11), so the shortest list is tried next; if
that is refused too, the unit lacks the method.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import closing
from dataclasses import replace
from itertools import count
from statistics import median

from mikas.client import Ecu, Reading
from mikas.client.parameters.polling import STREAMS
from mikas.errors import EcuRefused, LineError, MikasError, NoConnection, ReadingSuspended, SyncLost
from mikas.sampling.events import CycleFailed, Event
from mikas.sampling.plan import Plan, datum_of
from mikas.sampling.running.context import SamplingContext
from mikas.sampling.running.method_knowledge import WITH_OWN_COMMANDS, TrialResult
from mikas.sampling.running.plan_runner import PlanCycles

_SECONDS = 1.0
_CYCLES = 6  # at least; one that sets lists, finds limits or begins a stream is not counted
_MOST_ERRORS = 3  # line errors in a row
_OUTLIER = 8  # times the usual cycle
_SHORTEST = 2  # data: distinct from a lone 01


def learn(context: SamplingContext, ecu: Ecu, plan: Plan) -> Iterator[Event]:
    """Record the rate of `plan` in `context.knowledge`, unless the request is replaced."""
    measured: TrialResult | None = None
    with closing(run_trial(context, ecu, plan)) as results:
        for result in results:
            match result:
                case TrialResult():
                    measured = result
                case MikasError():
                    yield CycleFailed(ecu.tester.link.now(), result)
                case fresh:
                    yield from context.sampled(fresh)
    if measured is None:
        return
    context.knowledge.record(measured, plan, ecu.tester.link.baud)
    if measured.refused and plan.method in WITH_OWN_COMMANDS:
        yield from _try_shortest(context, ecu, plan)


def _try_shortest(context: SamplingContext, ecu: Ecu, plan: Plan) -> Iterator[Event]:
    """Find out whether the unit refused the length of the list or the method."""
    short = yield from _shortest_answered(context, ecu, plan)
    if short is None:
        return  # the unit may refuse the parameters
    if len(plan.fast) > len(short.fast):
        context.jobs.run(ecu)
        if not _refused(context, ecu, short):
            return
        yield from _shortest_answered(context, ecu, plan)
    context.knowledge.record_missing(plan.method)


def _shortest_answered(
    context: SamplingContext, ecu: Ecu, plan: Plan
) -> Generator[Event, None, Plan | None]:
    """Run a cycle by 61; return the shortest plan of its readings, by `plan`'s method."""
    try:
        fresh = PlanCycles(ecu, plan.with_method("batch"), context.identity_check).run(0)
    except (NoConnection, SyncLost):
        raise
    except MikasError as error:
        yield CycleFailed(ecu.tester.link.now(), error)
        return None
    yield from context.sampled(fresh)
    size = min(_SHORTEST, context.knowledge.max_list)
    read = {datum_of(p.parameter): p for p in plan.parameters if p.parameter.name in fresh}
    short = tuple(replace(planned, divisor=1) for planned in list(read.values())[:size])
    return Plan(short, plan.method) if short else None


def _refused(context: SamplingContext, ecu: Ecu, short: Plan) -> bool:
    """Return whether the unit refuses `short`; False if the request is replaced meanwhile."""
    with closing(run_trial(context, ecu, short)) as results:
        for result in results:
            if isinstance(result, TrialResult):
                return result.refused
            if result and not isinstance(result, MikasError):
                break
    return False


def run_trial(
    context: SamplingContext, ecu: Ecu, plan: Plan
) -> Generator[dict[str, Reading] | MikasError | TrialResult, None, None]:
    """Run `plan` for a second: yield readings and errors, at last the rate.

    Without a rate if the request is replaced meanwhile. Raises a `NoConnection` if the unit stops
    answering, `SyncLost` if another unit answers.
    """
    cycles = PlanCycles(ecu, plan, context.identity_check)
    clock = ecu.tester.link.now
    numbers = filter(plan.sends_in, count())  # without empty cycles
    number = next(numbers)
    spans: list[float] = []  # of the cycles
    before: float | None = None  # the end of the latest cycle, if no job ran since
    free = False  # for jobs: not before each cycle, or no cycle would be measured
    failures = 0
    try:
        while len(spans) < _CYCLES or sum(spans) < _SECONDS:
            if not context.is_current:
                return
            try:
                if free and context.jobs:
                    cycles.poller.close()
                    context.jobs.run(ecu)
                    before, free = None, False
                fresh = cycles.run(number, goes_on=context.request.rate is None)
            except (NoConnection, SyncLost):
                raise
            except LineError as error:
                free = True
                failures += 1
                if isinstance(error, ReadingSuspended):
                    before = None
                if failures == _MOST_ERRORS:
                    refused = cycles.poller.is_refusal(error)
                    yield TrialResult(plan.method, 0.0, refused=refused)
                    return
                yield error
                continue
            except MikasError as error:  # refused, or not confirmed by the user
                yield error
                yield TrialResult(plan.method, 0.0, refused=isinstance(error, EcuRefused))
                return
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
    yield TrialResult(plan.method, _rate(spans) if ended else 0.0)


def _ended(cycles: PlanCycles) -> bool:
    try:
        cycles.poller.close()
    except LineError as error:
        return isinstance(error, ReadingSuspended)  # which says nothing of the unit
    return True


def _rate(spans: list[float]) -> float:
    """Return cycles a second, without a cycle made long by a repeated request."""
    has_outlier = max(spans) > _OUTLIER * median(spans)
    counted = sorted(spans)[:-1] if has_outlier else spans
    return len(counted) / sum(counted)
