"""The loop that runs a plan, for as long as anybody listens.

It keeps the way to the ECU open without a hand on the keyboard: an adapter that was pulled out is
waited for and found again, a silent ECU is asked until it answers, a unit that comes back is
compared with the one before. It tells what happens as events; what becomes of them is not its
business.

Other threads' requests (`call`) go in between cycles, a stream is ended for them and begun again.
"""

from __future__ import annotations

import queue
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future
from typing import Any, TypeVar

from mikas.client import Ecu, Passport, Reading
from mikas.client.data import refused
from mikas.commands import Availability
from mikas.errors import (
    EchoOnly,
    EcuRefused,
    LineError,
    LinkLost,
    MikasError,
    NoConnection,
    NoEcho,
    NotAKLineAdapter,
)
from mikas.link import Link
from mikas.link.plug import Plug
from mikas.sampling.choosing import measure
from mikas.sampling.cycles import Cycles, cycles_of
from mikas.sampling.events import (
    Chosen,
    Dropped,
    Event,
    Gap,
    LineState,
    Sampled,
    StateChanged,
    UnitFound,
)
from mikas.sampling.plan import Method, Plan, Wanted

T = TypeVar("T")

_ATTEMPTS = 3
_PORT_LOOK = 1.0  # s between looks for an adapter that is not there


class Sampler:
    """Samples `wanted` from whatever unit is behind `plug`.

    `make_ecu` makes an `Ecu`, not yet connected, of a link. `method` None: the fastest that works.
    `rate`: cycles a second at most.
    """

    def __init__(
        self,
        plug: Plug,
        make_ecu: Callable[[Link], Ecu],
        wanted: Sequence[Wanted],
        *,
        method: Method | None = None,
        rate: float | None = None,
    ) -> None:
        self._plug = plug
        self._make_ecu = make_ecu
        self._wanted = tuple(wanted)
        self._method = method
        self._period = 1 / rate if rate else 0.0
        self._jobs: queue.SimpleQueue[tuple[Future[Any], Callable[[Ecu], Any]]] = (
            queue.SimpleQueue()
        )
        self._state: LineState | None = None
        self._unit: tuple[int, Passport] | None = None
        self._chosen: Method | None = method
        self._last: dict[str, Reading] = {}

    @property
    def state(self) -> LineState | None:
        """How far the way to the ECU is open; None before the start."""
        return self._state

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """`job(ecu)` between two cycles, from any thread. It waits while no ECU answers."""
        future: Future[T] = Future()
        self._jobs.put((future, job))
        return future

    def run(self) -> Iterator[Event]:
        """Events for ever; close the iterator to stop. Raises `NotAKLineAdapter`, `UsageError`."""
        while True:
            link = yield from self._open()
            with link:
                try:
                    yield from self._on(self._make_ecu(link))
                except LinkLost as error:
                    yield from self._now_in(LineState.NO_PORT, self._plug.now(), error)

    # The way to the ECU

    def _open(self) -> Generator[Event, None, Link]:
        while True:
            try:
                return self._plug.open()
            except NoConnection as error:
                yield from self._now_in(LineState.NO_PORT, self._plug.now(), error)
                self._plug.wait(_PORT_LOOK)

    def _on(self, ecu: Ecu) -> Iterator[Event]:
        yield from self._until(ecu, ecu.tester.connect)
        while True:
            yield from self._compare(ecu)
            try:
                yield from self._sample(ecu)
            except LinkLost:
                raise
            except NoConnection as error:
                yield Gap(ecu.tester.link.now(), error)
                yield from self._not_there(ecu, error)
                yield from self._until(ecu, lambda: ecu.tester.request(Availability()))

    def _until(self, ecu: Ecu, attempt: Callable[[], object]) -> Iterator[Event]:
        """Tries until it works; each attempt waits for the ECU by itself (D14)."""
        while True:
            try:
                attempt()
            except (LinkLost, NotAKLineAdapter):
                raise
            except (NoConnection, LineError) as error:
                yield from self._not_there(ecu, error)
            else:
                yield from self._now_in(LineState.ECU_ALIVE, ecu.tester.link.now())
                return

    def _not_there(self, ecu: Ecu, error: MikasError) -> Iterator[Event]:
        state = self._state or LineState.NO_ECHO
        if isinstance(error, NoEcho):
            state = LineState.NO_ECHO
        elif isinstance(error, EchoOnly):
            state = LineState.ECHO_ONLY
        yield from self._now_in(state, ecu.tester.link.now(), error)

    def _now_in(
        self, state: LineState, time: float, error: MikasError | None = None
    ) -> Iterator[Event]:
        if state is not self._state:
            self._state = state
            yield StateChanged(time, state, error)

    def _compare(self, ecu: Ecu) -> Iterator[Event]:
        unit = ecu.version_code, ecu.passport(again=True)
        another = self._unit is not None and unit != self._unit
        if another:
            self._chosen = self._method
            self._last.clear()
        self._unit = unit
        yield UnitFound(ecu.tester.link.now(), *unit, another)

    # Sampling

    def _sample(self, ecu: Ecu) -> Iterator[Event]:
        plan = yield from self._accepted(ecu)
        if self._chosen is None:
            found = list(measure(ecu, plan))
            self._chosen = max(found, key=lambda measured: measured.rate).method
            rates: dict[str, float] = {measured.method: measured.rate for measured in found}
            yield Chosen(ecu.tester.link.now(), self._chosen, rates)
        plan = plan.by(self._chosen)
        yield from self._now_in(LineState.SAMPLING, ecu.tester.link.now())
        cycles = cycles_of(ecu, plan)
        number = 0
        due = ecu.tester.link.now()
        try:
            while True:
                self._do_jobs(ecu, cycles)
                if self._period:
                    ecu.tester.wait(due)
                    due = max(due, ecu.tester.link.now() - self._period) + self._period
                yield from self._cycle(ecu, cycles, number)
                number += 1
        finally:
            cycles.close()

    def _cycle(self, ecu: Ecu, cycles: Cycles, number: int) -> Iterator[Event]:
        try:
            fresh = cycles.run(number)
        except (LineError, EcuRefused) as error:
            yield Gap(ecu.tester.link.now(), error)
            return
        if fresh:
            stale = {n: r for n, r in self._last.items() if n not in fresh}
            self._last.update(fresh)
            yield Sampled(min(r.time for r in fresh.values()), fresh, stale)

    def _accepted(self, ecu: Ecu) -> Generator[Event, None, Plan]:
        """The plan without what the unit refuses: a stream or a list would be refused as a whole.

        Raises `NotSupported` if it refuses everything.
        """
        plan = Plan(self._wanted, self._chosen or "batch")
        named = [wanted.parameter for wanted in self._wanted]
        for attempt in range(_ATTEMPTS):
            try:
                ecu.parameters.fetch(named)
                break
            except LineError as error:
                yield Gap(ecu.tester.link.now(), error)
                if attempt == _ATTEMPTS - 1:
                    return plan
        for parameter in named:
            if ecu.parameters.refuses([parameter]):
                yield Dropped(ecu.tester.link.now(), parameter.name)
        left = tuple(w for w in self._wanted if not ecu.parameters.refuses([w.parameter]))
        if not left:
            raise refused(named[0].name, named[0].code)
        return Plan(left, plan.method)

    def _do_jobs(self, ecu: Ecu, cycles: Cycles) -> None:
        if self._jobs.empty():
            return
        cycles.close()
        while True:
            try:
                future, job = self._jobs.get_nowait()
            except queue.Empty:
                return
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(job(ecu))
            except Exception as error:  # it is the caller's, whatever it is
                future.set_exception(error)
                if isinstance(error, NoConnection):
                    raise
