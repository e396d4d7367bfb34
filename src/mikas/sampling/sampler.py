"""The loop that runs a plan, for as long as anybody listens.

It tells what happens as events; what becomes of them is not its business. What it wants may be
changed from any thread (`want`), and other threads' requests (`call`) go in between two cycles; a
stream is ended for them and begun again.

A unit may change its mind. A parameter that it refuses is dropped, with a notice, and the others go
on. A method that it no longer takes, while it still answers, is replaced: they are measured anew.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future
from typing import TypeVar

from mikas.client import Ecu
from mikas.client.methods import FixedMethod
from mikas.errors import LinkLost, MikasError, NoConnection, RecordingOver, SyncLost
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.choosing import CANDIDATES, LAST, best
from mikas.sampling.events import Event, LineState, MethodChosen, PlanChanged
from mikas.sampling.jobs import Jobs
from mikas.sampling.measuring import Measuring
from mikas.sampling.plan import Plan, Price, Wanted
from mikas.sampling.running import Running
from mikas.sampling.session import Session, Wish
from mikas.sampling.supervisor import ConnectionSupervisor, Unit, same
from mikas.sampling.unsupported import UnsupportedParameters

T = TypeVar("T")

_SHORT = 1.0  # s before methods of which none works are tried again
_LONG = 10.0  # s before a unit that refused everything is asked again


class Sampler:
    """Samples `wanted` from whatever unit is behind `plug`.

    `make_ecu` makes an `Ecu`, not yet connected, of a link. `method` None: the fastest that works.
    `rate`: cycles a second at most. `strict`: until the first sample, what is in the way is raised
    (no port, no ECU, a bad line, a `method` that the unit refuses) instead of waited out.
    `again`: parameters that this unit refused in an earlier session are asked once more.
    """

    def __init__(
        self,
        plug: ReconnectingPort,
        make_ecu: Callable[[Link], Ecu],
        wanted: Sequence[Wanted],
        *,
        method: FixedMethod | None = None,
        rate: float | None = None,
        strict: bool = False,
        again: bool = False,
    ) -> None:
        self._jobs = Jobs(plug.url)
        wish = Wish(tuple(wanted), method, rate, again)
        self._session = Session(wish, self._jobs, strict=strict)
        self._approach = ConnectionSupervisor(plug, make_ecu, self._session)
        self._refusals = UnsupportedParameters(self._session, self._approach.doubt)
        self._measuring = Measuring(self._session, self._approach.doubt)
        self._unit: Unit | None = None
        self._plan: Plan | None = None
        self._told: tuple[Wish, Plan] | None = None

    # For any thread

    @property
    def state(self) -> LineState | None:
        """How far the way to the ECU is open; None before the start."""
        return self._approach.state

    @property
    def ecu(self) -> Ecu | None:
        """The unit of now, for a look at its model and statistics; requests go through `call`."""
        return self._approach.ecu

    @property
    def plan(self) -> Plan | None:
        """The plan in force; None before the first."""
        return self._plan

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """`job(ecu)` between two cycles. What it raises is the future's.

        Before `run` it waits. While no ECU answers, it fails with the `NoConnection` or `LineError`
        of the next look at the line, within seconds; after the end of `run` with `LinkLost`.
        A job has the line to itself: what takes long should be many jobs.
        """
        return self._jobs.put(job)

    def want(
        self,
        wanted: Sequence[Wanted],
        method: FixedMethod | None = None,
        rate: float | None = None,
        *,
        again: bool = False,
    ) -> None:
        """Something else from the next cycle on; told by `PlanChanged`. Raises `UsageError`."""
        self._session.wish = Wish(tuple(wanted), method, rate, again)

    def price(self, wanted: Sequence[Wanted], method: FixedMethod | None = None) -> Price:
        """What a cycle of `wanted` would cost; method None: by the best, as far as is known."""
        return self._session.learning.price(Plan(tuple(wanted)), method)

    def relearn(self) -> None:
        """Forgets what was learnt of the unit, here and for later sessions; all is tried anew."""
        self._session.relearn = True

    def stop(self) -> None:
        """Ends `run` within a second or two, also while it waits for an adapter."""
        self._session.stopped = True

    # The loop

    def run(self) -> Generator[Event, None, None]:
        """Events until `stop`; closing the iterator stops too, and leaves the line quiet.

        Raises `NotAKLineAdapter`, `NotSupported` for a unit that gives nothing from the beginning,
        `RecordingOver` at the end of one that was played, and what `strict` says.
        """
        self._session.stopped = self._session.begun = False
        self._told = None
        self._jobs.open()
        failure: MikasError | None = None
        try:
            while not self._session.stopped:
                link = yield from self._approach.open()
                if link is not None:
                    yield from self._on(link)
        except MikasError as error:
            failure = error
            raise
        finally:
            self._approach.ecu = None
            self._jobs.close(failure)

    def _on(self, link: Link) -> Iterator[Event]:
        with link:
            try:
                while not self._session.stopped:
                    ecu = yield from self._approach.meet(link)
                    if ecu is not None:
                        yield from self._with(ecu)
            except RecordingOver:
                raise  # it won't come back
            except LinkLost as error:
                yield from self._approach.lost(error, link.now())

    def _with(self, ecu: Ecu) -> Iterator[Event]:
        """Samples from `ecu` until another unit is met, or nobody wants it any more."""
        unit = self._approach.unit
        if self._unit is None or unit is None or not same(unit, self._unit):
            self._forget()
        self._unit = unit
        there = True
        while there and not self._session.stopped:
            try:
                yield from self._sample(ecu)
            except LinkLost:
                raise
            except (NoConnection, SyncLost) as error:
                there = yield from self._approach.meet_again(ecu, error)

    def _forget(self) -> None:
        self._session.another_unit()
        self._told = None

    def _sample(self, ecu: Ecu) -> Iterator[Event]:
        session = self._session
        while not session.stopped:
            wish = session.wish
            if session.relearn:
                session.relearn = False
                self._forget()
                ecu.forget_limits()
            if self._told is None or self._told[0] is not wish:
                session.begin(wish)
            plan = yield from self._refusals.accepted(ecu, wish)
            if not session.is_current(wish):
                continue
            if plan is None:
                yield from self._idle(ecu, wish, _LONG)
                session.refused.clear()
                continue
            yield from self._approach.now_in(LineState.SAMPLING, ecu.tester.link.now())
            method = yield from self._method(ecu, plan, wish)
            if not session.is_current(wish):
                continue
            if method is None:
                yield from self._idle(ecu, wish, _SHORT)
                continue
            yield from self._tell(ecu, wish, plan.by(method))
            running = Running(
                ecu,
                plan.by(method),
                wish,
                session=session,
                refusals=self._refusals,
                doubt=self._approach.doubt,
            )
            yield from running.events()

    def _method(
        self, ecu: Ecu, plan: Plan, wish: Wish
    ) -> Generator[Event, None, FixedMethod | None]:
        """The one that is wanted or the best, measured if need be; None: nothing works."""
        session, learning, baud = self._session, self._session.learning, ecu.tester.link.baud
        if wish.method is not None and not learning.has_failed(wish.method):
            return wish.method
        learning.begin(ecu)
        measured = False
        while session.is_current(wish) and (
            trial := learning.next_to_measure(plan, wish.rate, baud)
        ):
            if not measured:
                yield from self._tell(ecu, wish, plan)  # by any method, so far
            measured = True
            self._jobs.run(ecu)
            yield from self._measuring.learn(ecu, plan.by(trial), wish)
        if measured:
            learning.keep()
        rates = learning.rates(plan, baud)
        chosen = best(rates, wish.rate)
        if (
            session.is_current(wish)
            and chosen is not None
            and (measured or chosen != learning.method)
        ):
            learning.method = chosen
            told = {str(each): rates[each] for each in (*CANDIDATES, LAST) if each in rates}
            yield MethodChosen(ecu.tester.link.now(), chosen, told)
        return chosen

    def _tell(self, ecu: Ecu, wish: Wish, plan: Plan) -> Iterator[Event]:
        if self._told is None or self._told[0] is not wish or self._told[1] != plan:
            self._told, self._plan = (wish, plan), plan
            self._session.keep_only(plan)
            yield PlanChanged(ecu.tester.link.now(), plan)

    def _idle(self, ecu: Ecu, wish: Wish, seconds: float) -> Iterator[Event]:
        """Nothing can be sampled: only jobs are done. It goes on when something else is wanted."""
        session, due = self._session, ecu.tester.link.now() + seconds
        yield from self._approach.now_in(LineState.ECU_ALIVE, ecu.tester.link.now())
        while session.is_current(wish) and not session.waited(ecu, wish, due):
            self._jobs.run(ecu)
