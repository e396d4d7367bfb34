"""Sampling as one iterator of events: the loop that connects, plans and samples.

    with closing(Acquisition(port, make_ecu, catalog, ["FREQ", "TWAT/10"]).run()) as events:
        for event in events: …

One thread iterates; all other methods and properties may be used from any thread: to change the
request (`reconfigure`), to queue a job for the unit (`call`). Jobs run between two cycles and
interrupt a stream.

A parameter that the unit refuses, also later, is dropped with a notice, and the others continue; it
is requested again after a reconnection. If a method fails while the unit still answers, the methods
are measured again and it is replaced.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future
from typing import TypeVar

from mikas import errors
from mikas.catalog import Catalog, Derived, Parameter
from mikas.client import Ecu
from mikas.client.identity import UnitIdentity
from mikas.client.parameters.polling import FixedMethod, fixed_method
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.events import Event, MethodChosen
from mikas.sampling.jobs import JobQueue
from mikas.sampling.line_state import LineTrigger
from mikas.sampling.plan import Plan, Price, Selection, select
from mikas.sampling.running import method_trial
from mikas.sampling.running.context import SamplingContext, SamplingRequest
from mikas.sampling.running.method_knowledge import CANDIDATES, FALLBACK, best_method
from mikas.sampling.running.plan_runner import PlanRunner
from mikas.sampling.running.unsupported import UnsupportedParameters
from mikas.sampling.supervisor import ConnectionSupervisor

T = TypeVar("T")

_SHORT = 1.0  # s before the methods are tried again, if none works
_LONG = 10.0  # s before the parameters are requested again, if the unit refused all


class Acquisition:
    """Samples the channels `names` of the unit at `port`; without names all parameters. Each sample
    has its derived channels and is followed by its alarms.

    A name is a parameter's, a code (`0x1A`, `0x3F:2`) or a derived channel's, each with `/10` for
    every tenth cycle; a named parameter is requested again if this unit refused it in an earlier
    session. `make_ecu` returns an unconnected `Ecu` on a link. `method`: auto is the fastest that
    works. `rate`: most cycles a second. `strict`: until the first sample, an obstacle (no port, no
    ECU, a bad line, a refused `method`) is raised; otherwise sampling waits.
    `before`: the unit of an earlier connection; without, the first unit is sampled at once, before
    its passports are known. `moved`: that unit was at a port where no other is, so this is another.

    Raises `UnknownParameter` and `UsageError` before it opens the port.
    """

    def __init__(
        self,
        port: ReconnectingPort,
        make_ecu: Callable[[Link], Ecu],
        catalog: Catalog,
        names: Iterable[str] = (),
        *,
        method: str = "auto",
        rate: float | None = None,
        strict: bool = False,
        before: UnitIdentity | None = None,
        moved: bool = False,
    ) -> None:
        self._catalog = catalog
        request = self._request(names, method, rate)
        self._context = SamplingContext(request, JobQueue(port.url), strict=strict)
        self._make_ecu = make_ecu
        self.port = port
        self._supervisor = ConnectionSupervisor(
            port, self._create_ecu, self._context, before, moved=moved
        )
        self._unsupported = UnsupportedParameters(self._context)

    def _create_ecu(self, link: Link) -> Ecu:
        ecu = self._make_ecu(link)
        ecu.use_catalog(self._catalog)
        return ecu

    def _request(self, names: Iterable[str], method: str, rate: float | None) -> SamplingRequest:
        selection = select(self._catalog, names)
        if not selection.parameters:
            listed = ", ".join(channel.name for channel in selection.channels)
            raise errors.usage_error(
                f"{listed}: instruments alone give it; name a parameter of the unit as well",
                f"{listed}: это дают только приборы; назовите и какой-нибудь параметр блока",
            )
        return SamplingRequest(selection, fixed_method(method), rate)

    # Called from any thread

    @property
    def selection(self) -> Selection:
        """The requested channels, with their parameters and the catalog that defines them."""
        return self._context.latest.selection

    @property
    def channels(self) -> tuple[Parameter | Derived, ...]:
        """The requested channels, in the requested order."""
        return self._context.latest.selection.channels

    @property
    def ecu(self) -> Ecu | None:
        """The present unit: its model and statistics may be read; requests go through `call`."""
        return self._supervisor.ecu

    @property
    def plan(self) -> Plan | None:
        """The present plan, inputs of derived channels included; None before the first."""
        return self._context.plan

    @property
    def unended(self) -> errors.LineNotQuiet | None:
        """The error of a stream that the unit did not end (D12) when `run` was closed."""
        return self._context.unended

    @property
    def has_more(self) -> bool:
        """Whether alarms of the latest sample come next; they need no request."""
        return bool(self._context.pending_alarms)

    @property
    def method(self) -> str | None:
        """The present method."""
        return None if self.plan is None else self.plan.method

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """Run `job(ecu)` between two cycles; the future has its result or its exception.

        Before `run` the job waits. While no ECU answers, it fails within seconds with the
        `NoConnection` or `LineError` of the next attempt; after the end of `run` with `LinkClosed`.
        No cycle runs during a job: split long work into many jobs.
        """
        return self._context.jobs.submit(job)

    def reconfigure(
        self,
        names: Iterable[str],
        method: str = "auto",
        rate: float | None = None,
        *,
        catalog: Catalog | None = None,
    ) -> None:
        """Sample other channels from the next cycle on, or by another catalog; `PlanChanged`
        follows.

        If the same data are requested, sampling goes on without a pause: only limits, or derived
        channels of parameters that are sampled anyway, have changed. Raises `UnknownParameter` and
        `UsageError`, and then nothing changes.
        """
        before = self._catalog
        self._catalog = catalog or before
        try:
            self._context.latest = self._request(names, method, rate)
        except errors.UsageError:
            self._catalog = before
            raise

    def prefer(self, names: Iterable[str]) -> None:
        """Let these channels come first where each channel costs time; none: all are equal.

        The same channels are sampled as before. A stream or a list goes on as it is; in a plan of
        requests the divisors change between two cycles. Raises `UnknownParameter`, `UsageError`.
        """
        self._context.first = self._parameters_of(names)

    def price(self, names: Iterable[str], method: str = "auto", first: Iterable[str] = ()) -> Price:
        """Return the price of a cycle of `names`; auto: by the fastest known method.

        `first`: those that come first, as for `prefer`. Raises `UnknownParameter`, `UsageError`.
        """
        plan = Plan(select(self._catalog, names).parameters)
        preferred = self._parameters_of(first)
        return self._context.knowledge.price(plan, fixed_method(method), preferred)

    def _parameters_of(self, names: Iterable[str]) -> frozenset[str]:
        """Return the parameters of `names`: themselves, and the inputs of derived channels."""
        wanted = tuple(names)
        if not wanted:
            return frozenset()
        return frozenset(it.parameter.name for it in select(self._catalog, wanted).parameters)

    def relearn(self) -> None:
        """Forget the unit's methods and limits, saved ones included; measure them again."""
        self._context.relearn = True

    def stop(self) -> None:
        """End `run` within two seconds, also while it waits for an adapter."""
        self._context.stopped = True

    def refuse_jobs(self) -> None:
        """Fail the jobs that wait, and all until the next `run`, with `LinkClosed`."""
        self._context.jobs.close()

    # The loop

    def run(self) -> Generator[Event, None, None]:
        """Yield events until `stop`, or until the iterator is closed; the line is left quiet.

        Raises `NotAKLineAdapter`, `NotSupported` if the unit refuses all parameters before the
        first sample, `RecordingOver` at the end of a replay, and the obstacles with `strict`.
        """
        self._context.start_run()
        self._context.jobs.open()
        failure: errors.MikasError | None = None
        try:
            while not self._context.stopped:
                link = yield from self._supervisor.open_port()
                if link is not None:
                    yield from self._use_link(link)
        except errors.MikasError as error:
            failure = error
            raise
        finally:
            self._supervisor.end_run()
            self._context.jobs.close(failure)

    def _use_link(self, link: Link) -> Iterator[Event]:
        with link:
            try:
                while not self._context.stopped:
                    ecu = yield from self._supervisor.find_unit(link)
                    if ecu is not None:
                        yield from self._use_unit(ecu)
            except errors.RecordingOver:
                raise  # a replay does not continue
            except errors.LinkLost as error:
                yield from self._supervisor.port_lost(error, link.now())

    def _use_unit(self, ecu: Ecu) -> Iterator[Event]:
        """Sample from `ecu` until another unit answers or sampling is stopped."""
        answers = True
        while answers and not self._context.stopped:
            self._unsupported.dropped.reconnected()
            try:
                yield from self._sample(ecu)
            except errors.LinkLost:
                raise
            except (errors.NoConnection, errors.SyncLost) as error:
                answers = yield from self._supervisor.find_unit_again(ecu, error)

    def _sample(self, ecu: Ecu) -> Iterator[Event]:
        context = self._context
        context.answered = frozenset()
        while not context.stopped:
            if context.relearn:
                context.relearn = False
                context.forget_unit()
                ecu.forget_limits()
            if not context.is_reported or context.request is not context.latest:
                context.start_request()
                ecu.use_catalog(context.request.selection.catalog)
            plan = yield from self._unsupported.supported_plan(ecu)
            if not context.is_current:
                continue
            if plan is None:
                yield from self._idle(ecu, _LONG)
                context.refused.clear()
                continue
            yield from self._supervisor.process(LineTrigger.ACCEPTED, ecu.tester.link.now())
            method = yield from self._method(ecu, plan)
            if not context.is_current:
                continue
            if method is None:
                yield from self._idle(ecu, _SHORT)
                continue
            runner = PlanRunner(ecu, plan.with_method(method), context, self._unsupported)
            while (yield from runner.events()):  # without a request in between
                runner = PlanRunner(ecu, runner.whole, context, self._unsupported)
            if context.is_current:  # the plan has failed, or a dropped parameter is due
                context.answered = frozenset()

    def _method(self, ecu: Ecu, plan: Plan) -> Generator[Event, None, FixedMethod | None]:
        """Return the requested method, or the fastest, measured if necessary; None: none works."""
        context, knowledge, baud = self._context, self._context.knowledge, ecu.tester.link.baud
        requested = context.request
        if requested.method is not None and not knowledge.failures[requested.method]:
            return requested.method
        knowledge.begin_trials(ecu)
        measured = False
        while context.is_current and (
            trial := knowledge.next_to_measure(plan, requested.rate, baud)
        ):
            if not measured:
                yield from context.report_plan(plan, ecu.tester.link.now())  # the method follows
            measured = True
            self._context.jobs.run(ecu)
            yield from method_trial.learn(context, ecu, plan.with_method(trial))
        if measured:
            knowledge.save()
        rates = knowledge.rates(plan, baud)
        chosen = best_method(rates, requested.rate)
        if context.is_current and chosen is not None and (measured or chosen != knowledge.method):
            knowledge.method = chosen
            ordered = {str(each): rates[each] for each in (*CANDIDATES, FALLBACK) if each in rates}
            yield MethodChosen(ecu.tester.link.now(), chosen, ordered, ecu.limits())
        return chosen

    def _idle(self, ecu: Ecu, seconds: float) -> Iterator[Event]:
        """Run only jobs for `seconds`, or until the request changes."""
        context, due = self._context, ecu.tester.link.now() + seconds
        yield from self._supervisor.process(LineTrigger.REFUSED, ecu.tester.link.now())
        while context.is_current and not context.wait_until_due(ecu, due):
            self._context.jobs.run(ecu)
