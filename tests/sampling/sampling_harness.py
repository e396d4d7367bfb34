"""A sampler on simulated time, over a port that can be pulled out and put back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from mikas.client import Confirm, Ecu
from mikas.client.limits import LimitsStore
from mikas.errors import PortNotFound
from mikas.link import Chunk, Link
from mikas.link.base import WireCount
from mikas.link.virtual import VirtualLink
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import Event, MethodChosen, Sampled
from mikas.sampling.plan import PlannedParameter
from mikas.tester import Tester
from mikas.virtual.bus import Bus
from protocol_codes import SECTION_4
from virtual_harness import DATA

SAMPLES = 40


class SimulatedPlug:
    """A socket for virtual units. `bus` may be exchanged: another car."""

    def __init__(self, bus: Bus) -> None:
        self.bus = bus
        self.url = "sim:"
        self.plugged_in = True
        self.link: WatchedLink | None = None
        self.wire = WireCount()
        self.date: Callable[[], float] | None = None
        """The computer's date; None: it is not watched."""
        self._now = 0.0
        self._at: list[tuple[float, Callable[[], object]]] = []

    def open(self) -> VirtualLink:
        if not self.plugged_in:
            raise PortNotFound(url="sim:", found="")
        self.link = WatchedLink(self)
        return self.link

    def now(self) -> float:
        return max(self._now, VirtualLink.now(self.link) if self.link else 0.0)

    def wait(self, seconds: float) -> None:
        self._now = self.now() + seconds
        self.bus.advance(self._now)
        self.look()

    def dated(self) -> tuple[float, float] | None:
        return None if self.date is None else (self.now(), self.date())

    stood_still = 0.0

    def slept(self, seconds: float) -> None:
        self.wait(seconds)

    def at(self, time: float, happens: Callable[[], object]) -> None:
        """At this time, or soon after, while the sampler is at work."""
        self._at.append((time, happens))

    def look(self) -> None:
        now = self.now()
        for time, happens in [each for each in self._at if each[0] <= now]:
            self._at.remove((time, happens))
            happens()

    def pull(self) -> None:
        self.plugged_in = False
        assert self.link is not None
        self.link.unplug()

    def unsupply(self) -> None:
        """The plug is out of the car's socket; the adapter has no 12 V."""
        self.bus.adapter.kind = replace(self.bus.adapter.kind, supplied=False)

    def mend(self) -> None:
        self.plugged_in = True
        self.bus.adapter.kind = replace(self.bus.adapter.kind, supplied=True)


class WatchedLink(VirtualLink):
    """Lets happen what is to happen."""

    def __init__(self, plug: SimulatedPlug) -> None:
        super().__init__(plug.bus, start=plug.now())
        self._plug = plug

    def read(self, deadline: float) -> Chunk:
        self._plug.look()
        return super().read(deadline)


def wishes(*words: str) -> list[PlannedParameter]:
    """Return `FREQ`, `TWAT/10` as wanted parameters; without words, all of §4."""
    wanted = []
    for word in words:
        name, _, every = word.partition("/")
        wanted.append(PlannedParameter(SECTION_4.parameter(name), int(every or 1)))
    return wanted or [PlannedParameter(parameter) for parameter in SECTION_4.parameters]


def ecu_factory(
    state: Path | None = None, confirm: Confirm | None = None, **settings: object
) -> Callable[[Link], Ecu]:
    """What makes units; with `state`, of which something is kept."""
    store = LimitsStore(state) if state else None
    return lambda link: Ecu(Tester(link, **settings), SECTION_4, confirm=confirm, store=store)


def make_sampler(
    plug: SimulatedPlug,
    *words: str,
    state: Path | None = None,
    confirm: Confirm | None = None,
    **settings: object,
) -> Acquisition:
    return Acquisition(plug, ecu_factory(state, confirm), SECTION_4, words, **settings)


def take(
    events: Iterator[Event], until: Callable[[list[Event]], bool], most: int = 5000
) -> list[Event]:
    """Events until `until` says enough; more than `most` is a loop that never ends."""
    taken: list[Event] = []
    for event in events:
        taken.append(event)
        if until(taken):
            return taken
        assert len(taken) < most
    return taken


def of(kind: type, events: list[Event]) -> list:
    return [event for event in events if isinstance(event, kind)]


def enough(events: list[Event]) -> bool:
    return len(of(Sampled, events)) >= SAMPLES


def settled(events: list[Event]) -> bool:
    """Enough samples with what was chosen."""
    chosen = [at for at, event in enumerate(events) if isinstance(event, MethodChosen)]
    return bool(chosen) and enough(events[chosen[-1] :])


def run(bus: Bus, *words: str, **settings: object) -> list[Event]:
    """The events of a sampler until there are enough samples."""
    until = settled if settings.get("method", "auto") == "auto" else enough
    with closing(make_sampler(SimulatedPlug(bus), *words, **settings).run()) as events:
        return take(events, until)


def assert_values_are_the_units(events: list[Event]) -> None:
    for sample in of(Sampled, events):
        for reading in sample.fresh.values():
            assert reading.raw == DATA[reading.parameter.code], reading.name
