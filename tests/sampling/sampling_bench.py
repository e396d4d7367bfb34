"""A sampler on simulated time, over a port that can be pulled out and put back."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from mikas.catalog import shipped
from mikas.client import Ecu
from mikas.errors import PortNotFound
from mikas.link.virtual import VirtualLink
from mikas.sampling.events import Event
from mikas.sampling.plan import Wanted
from mikas.sampling.sampler import Sampler
from mikas.tester import Tester
from mikas.virtual.bus import Bus


class SimulatedPlug:
    """A socket for virtual units. `bus` may be exchanged: another car."""

    def __init__(self, bus: Bus) -> None:
        self.bus = bus
        self.url = "sim:"
        self.plugged_in = True
        self.link: VirtualLink | None = None
        self._now = 0.0

    def open(self) -> VirtualLink:
        if not self.plugged_in:
            raise PortNotFound(url="sim:", found="")
        self.link = VirtualLink(self.bus, start=self.now())
        return self.link

    def now(self) -> float:
        return max(self._now, self.link.now() if self.link else 0.0)

    def wait(self, seconds: float) -> None:
        self._now = self.now() + seconds
        self.bus.advance(self._now)

    def pull(self) -> None:
        self.plugged_in = False
        assert self.link is not None
        self.link.unplug()


def wishes(*words: str) -> list[Wanted]:
    """`FREQ`, `TWAT/10`; none: everything."""
    wanted = []
    for word in words:
        name, _, every = word.partition("/")
        wanted.append(Wanted(shipped().parameter(name), int(every or 1)))
    return wanted or [Wanted(parameter) for parameter in shipped().parameters]


def make_sampler(plug: SimulatedPlug, *words: str, **settings: object) -> Sampler:
    return Sampler(plug, lambda link: Ecu(Tester(link), shipped()), wishes(*words), **settings)


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
