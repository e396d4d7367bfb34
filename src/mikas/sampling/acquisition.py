"""All of sampling behind one iterator: the sampler, derived channels, alarms.

    with closing(Acquisition(port, make_ecu, catalog, ["FREQ", "TWAT/10"]).run()) as events:
        for event in events: …

One thread runs it; every other method and property is for any thread.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from concurrent.futures import Future
from dataclasses import replace
from typing import TypeVar

from mikas.catalog import AlarmLimits, Catalog, Derived, Parameter
from mikas.client import Ecu
from mikas.client.polling import fixed_method
from mikas.errors import UsageError
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.alarms import Alarms, AlarmState, Value
from mikas.sampling.derived import DerivedChannels, number_of
from mikas.sampling.event_log import EventLogger
from mikas.sampling.events import (
    AlarmChanged,
    CycleFailed,
    Event,
    LineState,
    PlanChanged,
    Sampled,
    UnitFound,
)
from mikas.sampling.plan import Plan, Price, select
from mikas.sampling.sampler import Sampler

T = TypeVar("T")


class Acquisition:
    """Acquires the channels `names` of whatever unit is behind `plug`; none: all parameters.

    A name may be a parameter's, a code's (`0x1A`, `0x3F:2`) or a derived channel's, each with
    `/10` for every tenth cycle. `method`: auto is the fastest that works. `rate`: cycles a second
    at most. `strict`: as for `Sampler`. `limits`: alarms other than the catalog's, as for `Alarms`.

    Raises `UnknownParameter` and `UsageError` before anything is opened.
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
        limits: Mapping[str, AlarmLimits | None] | None = None,
    ) -> None:
        self._catalog = catalog
        self._limits = limits
        self._selection = select(catalog, names)
        self._derived = DerivedChannels(catalog, self._selection.derived)
        self._in_force = self._selection
        self._alarms = Alarms(catalog, limits)
        self._behind: deque[AlarmChanged] = deque()  # of the sample that was told last
        self._sampler = Sampler(
            port,
            make_ecu,
            self._selection.parameters,
            method=fixed_method(method),
            rate=rate,
            strict=strict,
            retry_refused=self._selection.explicit,
        )

    @property
    def channels(self) -> tuple[Parameter | Derived, ...]:
        """What was asked for, in that order."""
        return self._selection.channels

    @property
    def plan(self) -> Plan | None:
        """What is asked now, inputs of derived channels included; None before the beginning."""
        return self._sampler.plan

    @property
    def method(self) -> str | None:
        """The method in force."""
        plan = self.plan
        return None if plan is None else plan.method

    @property
    def state(self) -> LineState | None:
        """How far the way to the ECU is open; None before the beginning."""
        return self._sampler.state

    @property
    def ecu(self) -> Ecu | None:
        """The unit of now, or None; to look at its model or statistics, not to ask it (`call`)."""
        return self._sampler.ecu

    @property
    def alarms(self) -> Mapping[str, AlarmState]:
        """What is known of each channel that has limits, by name."""
        return self._alarms.current()

    @property
    def has_more(self) -> bool:
        """Whether the latest sample has alarms behind it, which come next and ask nothing."""
        return bool(self._behind)

    def run(self) -> Generator[Event, None, None]:
        """Events until `stop`, or until the iterator is closed. Raises as `Sampler.run` does."""
        self._behind.clear()
        log = EventLogger()
        for event in self._sampler.run():
            log.take(event)
            match event:
                case Sampled():
                    yield from self._with_derived(event)
                    continue
                case CycleFailed():  # what adds up goes on, if the next value is not too long after
                    self._alarms.update({}, event.time)
                case PlanChanged():
                    self._adopt_selection()
                case UnitFound(another=True):  # what was added up is that of the car before
                    self._derived = DerivedChannels(self._catalog, self._in_force.derived)
                    self._alarms = Alarms(self._catalog, self._limits)
                case _:
                    pass
            yield event

    def _with_derived(self, sampled: Sampled) -> Iterator[Event]:
        derived = self._derived.update(sampled.fresh, sampled.time)
        # What came in this cycle is fresh, however long the cycle lasts; only the rest has an age.
        fresh = {name: number_of(reading) for name, reading in sampled.fresh.items()}
        values: dict[str, Value] = {**sampled.stale, **fresh, **derived}
        self._behind.extend(self._alarms.update(values, sampled.time))
        yield replace(sampled, derived=derived)
        while self._behind:
            yield self._behind.popleft()

    def _adopt_selection(self) -> None:
        if self._in_force is not self._selection:
            self._in_force = self._selection
            before = self._derived
            self._derived = DerivedChannels(self._catalog, self._in_force.derived)
            asked = [wanted.parameter.name for wanted in self._in_force.parameters]
            self._derived.go_on_from(before, asked)

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """`job(ecu)` between two cycles, as `Sampler.call`."""
        return self._sampler.call(job)

    def reconfigure(
        self, names: Iterable[str], method: str = "auto", rate: float | None = None
    ) -> None:
        """Other channels from the next cycle on, told by `PlanChanged`.

        Raises `UnknownParameter` and `UsageError`, and then nothing changes.
        """
        selection = select(self._catalog, names)
        own = fixed_method(method)
        before, self._selection = self._selection, selection
        try:
            self._sampler.reconfigure(
                selection.parameters, own, rate, retry_refused=selection.explicit
            )
        except UsageError:
            self._selection = before
            raise

    def relearn(self) -> None:
        """Forgets what was learnt of the unit's methods and bounds; all is measured anew."""
        self._sampler.relearn()

    def stop(self) -> None:
        """Ends `run` within a second or two, whatever it waits for."""
        self._sampler.stop()

    def price(self, names: Iterable[str], method: str = "auto") -> Price:
        """What a cycle of `names` would cost; auto: by the best method, as far as is known.

        Raises `UnknownParameter` and `UsageError`.
        """
        return self._sampler.price(select(self._catalog, names).parameters, fixed_method(method))
