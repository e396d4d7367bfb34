"""The loop that connects, plans and samples, and yields events.

Any thread may change the request (`reconfigure`) or queue a job for the unit (`call`); jobs run
between two cycles and interrupt a stream.

A parameter that the unit refuses, also later, is dropped with a notice, and the others continue. If
a method fails while the unit still answers, the methods are measured again and it is replaced.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future
from typing import TypeVar

from mikas.client import Ecu
from mikas.client.polling import FixedMethod
from mikas.errors import LinkLost, MikasError, NoConnection, RecordingOver, SyncLost
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.context import SamplingContext, SamplingRequest
from mikas.sampling.events import Event, LineState, MethodChosen, PlanChanged
from mikas.sampling.jobs import JobQueue
from mikas.sampling.line_state import LineTrigger
from mikas.sampling.method_knowledge import CANDIDATES, FALLBACK, best_method
from mikas.sampling.method_trial import MethodTrials
from mikas.sampling.plan import Plan, PlannedParameter, Price
from mikas.sampling.plan_runner import PlanRunner
from mikas.sampling.supervisor import ConnectionSupervisor, UnitIdentity, is_same_unit
from mikas.sampling.unsupported import UnsupportedParameters

T = TypeVar("T")

_SHORT = 1.0  # s before the methods are tried again, if none works
_LONG = 10.0  # s before the parameters are requested again, if the unit refused all


class Sampler:
    """Samples `parameters` from the unit at `port`.

    `make_ecu` returns an unconnected `Ecu` on a link. `method` None: the fastest that works.
    `rate`: most cycles a second. `strict`: until the first sample, an obstacle (no port, no ECU, a
    bad line, a refused `method`) is raised; otherwise sampling waits. `retry_refused`: request
    parameters again that this unit refused in an earlier session.
    """

    def __init__(
        self,
        port: ReconnectingPort,
        make_ecu: Callable[[Link], Ecu],
        parameters: Sequence[PlannedParameter],
        *,
        method: FixedMethod | None = None,
        rate: float | None = None,
        strict: bool = False,
        retry_refused: bool = False,
    ) -> None:
        self._jobs = JobQueue(port.url)
        requested = SamplingRequest(tuple(parameters), method, rate, retry_refused)
        self._context = SamplingContext(requested, self._jobs, strict=strict)
        self._supervisor = ConnectionSupervisor(port, make_ecu, self._context)
        self._unsupported = UnsupportedParameters(self._context, self._supervisor.identity_check)
        self._trials = MethodTrials(self._context, self._supervisor.identity_check)
        self._unit: UnitIdentity | None = None
        self._plan: Plan | None = None
        self._reported: tuple[SamplingRequest, Plan] | None = None

    # Called from any thread

    @property
    def state(self) -> LineState | None:
        """The line's state; None before the start."""
        return self._supervisor.state

    @property
    def ecu(self) -> Ecu | None:
        """The present unit: its model and statistics may be read; requests go through `call`."""
        return self._supervisor.ecu

    @property
    def plan(self) -> Plan | None:
        """The present plan; None before the first."""
        return self._plan

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """Run `job(ecu)` between two cycles; the future has its result or its exception.

        Before `run` the job waits. While no ECU answers, it fails within seconds with the
        `NoConnection` or `LineError` of the next attempt; after the end of `run` with `LinkLost`.
        No cycle runs during a job: split long work into many jobs.
        """
        return self._jobs.submit(job)

    def reconfigure(
        self,
        parameters: Sequence[PlannedParameter],
        method: FixedMethod | None = None,
        rate: float | None = None,
        *,
        retry_refused: bool = False,
    ) -> None:
        """Change the request from the next cycle on; `PlanChanged` follows. Raises `UsageError`."""
        self._context.request = SamplingRequest(tuple(parameters), method, rate, retry_refused)

    def price(
        self, parameters: Sequence[PlannedParameter], method: FixedMethod | None = None
    ) -> Price:
        """Return the price of a cycle of `parameters`; method None: by the best known one."""
        return self._context.knowledge.price(Plan(tuple(parameters)), method)

    def relearn(self) -> None:
        """Forget the unit's methods and limits, saved ones included; measure them again."""
        self._context.relearn = True

    def stop(self) -> None:
        """End `run` within two seconds, also while it waits for an adapter."""
        self._context.stopped = True

    # The loop

    def run(self) -> Generator[Event, None, None]:
        """Yield events until `stop`, or until the iterator is closed; the line is left quiet.

        Raises `NotAKLineAdapter`, `NotSupported` if the unit refuses all parameters before the
        first sample, `RecordingOver` at the end of a replay, and the obstacles with `strict`.
        """
        self._context.stopped = self._context.has_sampled = False
        self._reported = None
        self._jobs.open()
        failure: MikasError | None = None
        try:
            while not self._context.stopped:
                link = yield from self._supervisor.open_port()
                if link is not None:
                    yield from self._use_link(link)
        except MikasError as error:
            failure = error
            raise
        finally:
            self._supervisor.end()
            self._jobs.close(failure)

    def _use_link(self, link: Link) -> Iterator[Event]:
        with link:
            try:
                while not self._context.stopped:
                    ecu = yield from self._supervisor.find_unit(link)
                    if ecu is not None:
                        yield from self._use_unit(ecu)
            except RecordingOver:
                raise  # a replay does not continue
            except LinkLost as error:
                yield from self._supervisor.port_lost(error, link.now())

    def _use_unit(self, ecu: Ecu) -> Iterator[Event]:
        """Sample from `ecu` until another unit answers or sampling is stopped."""
        unit = self._supervisor.unit
        if self._unit is None or unit is None or not is_same_unit(unit, self._unit):
            self._forget()
        self._unit = unit
        answers = True
        while answers and not self._context.stopped:
            try:
                yield from self._sample(ecu)
            except LinkLost:
                raise
            except (NoConnection, SyncLost) as error:
                answers = yield from self._supervisor.find_unit_again(ecu, error)

    def _forget(self) -> None:
        self._context.forget_unit()
        self._reported = None

    def _sample(self, ecu: Ecu) -> Iterator[Event]:
        context = self._context
        while not context.stopped:
            requested = context.request
            if context.relearn:
                context.relearn = False
                self._forget()
                ecu.forget_limits()
            if self._reported is None or self._reported[0] is not requested:
                context.start_request(requested)
            plan = yield from self._unsupported.supported_plan(ecu, requested)
            if not context.is_current(requested):
                continue
            if plan is None:
                yield from self._idle(ecu, requested, _LONG)
                context.refused.clear()
                continue
            yield from self._supervisor.process(LineTrigger.ACCEPTED, ecu.tester.link.now())
            method = yield from self._method(ecu, plan, requested)
            if not context.is_current(requested):
                continue
            if method is None:
                yield from self._idle(ecu, requested, _SHORT)
                continue
            plan = plan.with_method(method)
            yield from self._report_plan(ecu, requested, plan)
            runner = PlanRunner(
                ecu,
                plan,
                requested,
                context=context,
                unsupported=self._unsupported,
                identity_check=self._supervisor.identity_check,
            )
            yield from runner.events()

    def _method(
        self, ecu: Ecu, plan: Plan, requested: SamplingRequest
    ) -> Generator[Event, None, FixedMethod | None]:
        """Return the requested method, or the fastest, measured if necessary; None: none works."""
        context, knowledge, baud = self._context, self._context.knowledge, ecu.tester.link.baud
        if requested.method is not None and not knowledge.has_failed(requested.method):
            return requested.method
        knowledge.begin_trials(ecu)
        measured = False
        while context.is_current(requested) and (
            trial := knowledge.next_to_measure(plan, requested.rate, baud)
        ):
            if not measured:
                yield from self._report_plan(ecu, requested, plan)  # the method follows
            measured = True
            self._jobs.run(ecu)
            yield from self._trials.learn(ecu, plan.with_method(trial), requested)
        if measured:
            knowledge.save()
        rates = knowledge.rates(plan, baud)
        chosen = best_method(rates, requested.rate)
        if (
            context.is_current(requested)
            and chosen is not None
            and (measured or chosen != knowledge.method)
        ):
            knowledge.method = chosen
            ordered = {str(each): rates[each] for each in (*CANDIDATES, FALLBACK) if each in rates}
            yield MethodChosen(ecu.tester.link.now(), chosen, ordered, ecu.limits())
        return chosen

    def _report_plan(self, ecu: Ecu, requested: SamplingRequest, plan: Plan) -> Iterator[Event]:
        reported = self._reported
        if reported is None or reported[0] is not requested or reported[1] != plan:
            self._reported, self._plan = (requested, plan), plan
            self._context.forget_values_outside(plan)
            yield PlanChanged(ecu.tester.link.now(), plan)

    def _idle(self, ecu: Ecu, requested: SamplingRequest, seconds: float) -> Iterator[Event]:
        """Run only jobs for `seconds`, or until the request changes."""
        context, due = self._context, ecu.tester.link.now() + seconds
        yield from self._supervisor.process(LineTrigger.REFUSED, ecu.tester.link.now())
        while context.is_current(requested) and not context.wait_until_due(ecu, requested, due):
            self._jobs.run(ecu)
