"""Sampling as one iterator of events: the sampler, derived channels and alarms.

    with closing(Acquisition(port, make_ecu, catalog, ["FREQ", "TWAT/10"]).run()) as events:
        for event in events: …

One thread iterates; all other methods and properties may be used from any thread.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import closing

from mikas.catalog import AlarmLimits, Catalog
from mikas.client import Ecu, Reading
from mikas.client.identity import UnitIdentity
from mikas.link import Link
from mikas.link.reconnecting import ReconnectingPort
from mikas.sampling.alarms import Alarms, AlarmState, Value
from mikas.sampling.derived import DerivedChannels, DerivedValue, numbers_of
from mikas.sampling.events import (
    AlarmChanged,
    CycleFailed,
    Event,
    PlanChanged,
    Sampled,
    UnitFound,
)
from mikas.sampling.sampler import Sampler


class Acquisition(Sampler):
    """A sampler with derived channels and alarms; `limits` as for `Alarms`."""

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
        limits: Mapping[str, AlarmLimits | None] | None = None,
    ) -> None:
        super().__init__(
            port,
            make_ecu,
            catalog,
            names,
            method=method,
            rate=rate,
            strict=strict,
            before=before,
        )
        self._limits = limits
        self._adopted = self._context.request.selection  # that of the latest `PlanChanged`
        self._derived = DerivedChannels(catalog, self._adopted.derived)
        self._alarms = Alarms(catalog, limits)
        self._numbers: dict[str, float] = {}  # of the latest sample
        self._pending_alarms: deque[AlarmChanged] = deque()  # of it
        self._context.derive = self._derive

    @property
    def alarms(self) -> Mapping[str, AlarmState]:
        """The alarm state of each channel that has limits, by name."""
        return self._alarms.current()

    @property
    def has_more(self) -> bool:
        """Whether alarms of the latest sample come next; they need no request."""
        return bool(self._pending_alarms)

    def run(self) -> Generator[Event, None, None]:
        """Yield events as `Sampler.run`, each sample with its derived channels and its alarms."""
        self._pending_alarms.clear()
        with closing(super().run()) as events:  # Ctrl-C while it ends is not lost
            for event in events:
                if isinstance(event, Sampled):
                    yield from self._with_alarms(event)
                else:
                    yield from self._followed(event)

    def _followed(self, event: Event) -> Iterator[Event]:
        match event:
            case CycleFailed():  # accumulation continues unless the next value is late
                self._alarms.update({}, event.time)
            case PlanChanged():
                changed = self._adopt_selection(event.time)
                yield event
                yield from changed
                return
            case UnitFound(another=True):  # the totals are the previous car's
                self._derived = DerivedChannels(self._adopted.catalog, self._adopted.derived)
                self._alarms = Alarms(self._adopted.catalog, self._limits)
        yield event

    def _derive(self, fresh: Mapping[str, Reading], time: float) -> Mapping[str, DerivedValue]:
        self._numbers = numbers_of(fresh)
        return self._derived.update(fresh, time, self._numbers)

    def _with_alarms(self, sampled: Sampled) -> Iterator[Event]:
        # Values of this cycle are fresh, however long it lasts; only the others have an age.
        values: dict[str, Value] = {**sampled.stale, **self._numbers, **sampled.derived}
        self._pending_alarms.extend(self._alarms.update(values, sampled.time))
        yield sampled
        while self._pending_alarms:
            yield self._pending_alarms.popleft()

    def _adopt_selection(self, time: float) -> list[AlarmChanged]:
        """Compute the channels of the request; return the alarms that another catalog ends."""
        selection, before = self._context.request.selection, self._adopted
        if before is selection:
            return []
        self._adopted = selection
        derived = self._derived
        self._derived = DerivedChannels(selection.catalog, selection.derived)
        requested = [planned.parameter.name for planned in selection.parameters]
        self._derived.continue_from(derived, requested)
        if before.catalog is selection.catalog:
            return []
        alarms, self._alarms = self._alarms, Alarms(selection.catalog, self._limits)
        return self._alarms.continue_from(alarms, time)
