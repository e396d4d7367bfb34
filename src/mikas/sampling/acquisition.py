"""Sampling as one iterator of events: the sampler, derived channels and alarms.

    with closing(Acquisition(port, make_ecu, catalog, ["FREQ", "TWAT/10"]).run()) as events:
        for event in events: …

One thread iterates; all other methods and properties may be used from any thread.
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
from mikas.sampling.events import (
    AlarmChanged,
    CycleFailed,
    Event,
    LineState,
    PlanChanged,
    Sampled,
    UnitFound,
)
from mikas.sampling.gaps import EventLogger
from mikas.sampling.plan import Plan, Price, select
from mikas.sampling.sampler import Sampler

T = TypeVar("T")


class Acquisition:
    """Acquires the channels `names` of the unit at `port`; without names all parameters.

    A name is a parameter's, a code (`0x1A`, `0x3F:2`) or a derived channel's, each with `/10` for
    every tenth cycle. `method`: auto is the fastest that works. `rate`: most cycles a second.
    `strict` as for `Sampler`, `limits` as for `Alarms`.

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
        limits: Mapping[str, AlarmLimits | None] | None = None,
    ) -> None:
        self._catalog = catalog
        self._limits = limits
        self._selection = select(catalog, names)
        self._derived = DerivedChannels(catalog, self._selection.derived)
        self._adopted = self._selection  # that of the latest `PlanChanged`
        self._alarms = Alarms(catalog, limits)
        self._pending_alarms: deque[AlarmChanged] = deque()  # of the latest sample
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
        """The requested channels, in the requested order."""
        return self._selection.channels

    @property
    def plan(self) -> Plan | None:
        """The present plan, inputs of derived channels included; None before the start."""
        return self._sampler.plan

    @property
    def method(self) -> str | None:
        """The present method."""
        plan = self.plan
        return None if plan is None else plan.method

    @property
    def state(self) -> LineState | None:
        """The line's state; None before the start."""
        return self._sampler.state

    @property
    def ecu(self) -> Ecu | None:
        """The present unit or None: for its model and statistics; requests go through `call`."""
        return self._sampler.ecu

    @property
    def alarms(self) -> Mapping[str, AlarmState]:
        """The alarm state of each channel that has limits, by name."""
        return self._alarms.current()

    @property
    def has_more(self) -> bool:
        """Whether alarms of the latest sample come next; they need no request."""
        return bool(self._pending_alarms)

    def run(self) -> Generator[Event, None, None]:
        """Yield events until `stop`, or until the iterator is closed. Raises as `Sampler.run`."""
        self._pending_alarms.clear()
        log = EventLogger()
        for event in self._sampler.run():
            log.take(event)
            match event:
                case Sampled():
                    yield from self._with_derived(event)
                    continue
                case CycleFailed():  # accumulation continues unless the next value is late
                    self._alarms.update({}, event.time)
                case PlanChanged():
                    self._adopt_selection()
                case UnitFound(another=True):  # the totals are the previous car's
                    self._derived = DerivedChannels(self._catalog, self._adopted.derived)
                    self._alarms = Alarms(self._catalog, self._limits)
                case _:
                    pass
            yield event

    def _with_derived(self, sampled: Sampled) -> Iterator[Event]:
        derived = self._derived.update(sampled.fresh, sampled.time)
        # Values of this cycle are fresh, however long it lasts; only the others have an age.
        fresh = {name: number_of(reading) for name, reading in sampled.fresh.items()}
        values: dict[str, Value] = {**sampled.stale, **fresh, **derived}
        self._pending_alarms.extend(self._alarms.update(values, sampled.time))
        yield replace(sampled, derived=derived)
        while self._pending_alarms:
            yield self._pending_alarms.popleft()

    def _adopt_selection(self) -> None:
        if self._adopted is not self._selection:
            self._adopted = self._selection
            before = self._derived
            self._derived = DerivedChannels(self._catalog, self._adopted.derived)
            requested = [planned.parameter.name for planned in self._adopted.parameters]
            self._derived.continue_from(before, requested)

    def call(self, job: Callable[[Ecu], T]) -> Future[T]:
        """Run `job(ecu)` between two cycles, as `Sampler.call`."""
        return self._sampler.call(job)

    def reconfigure(
        self, names: Iterable[str], method: str = "auto", rate: float | None = None
    ) -> None:
        """Sample other channels from the next cycle on; `PlanChanged` follows.

        Raises `UnknownParameter` and `UsageError`, and then nothing changes.
        """
        selection = select(self._catalog, names)
        before, self._selection = self._selection, selection
        try:
            self._sampler.reconfigure(
                selection.parameters, fixed_method(method), rate, retry_refused=selection.explicit
            )
        except UsageError:
            self._selection = before
            raise

    def relearn(self) -> None:
        """Forget the unit's methods and limits; measure them again."""
        self._sampler.relearn()

    def stop(self) -> None:
        """End `run` within two seconds."""
        self._sampler.stop()

    def price(self, names: Iterable[str], method: str = "auto") -> Price:
        """Return the price of a cycle of `names`; auto: by the fastest known method.

        Raises `UnknownParameter` and `UsageError`.
        """
        return self._sampler.price(select(self._catalog, names).parameters, fixed_method(method))
