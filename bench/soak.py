"""A campaign over a very bad line on simulated time: is any value wrong? `make soak`.

python -m bench.soak --exchanges 1000000 --seed 1

40 % of the responses are in trouble (every line fault of the virtual ECU), all bytes stall about
once a second (D14), the ignition goes off and the adapter is pulled out now and then. The unit's
data are random and change four times a second, so a value of another code, or of another moment,
is found. Each method of sampling has its share of the exchanges. The same seed gives the same
figures. Exit status 1 if a value is wrong, another unit is reported, or time runs back; what is
lost is counted, and is no mistake on such a line.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass
from random import Random
from time import perf_counter
from typing import Final

from bench.soak_car import Outages, SoakCar
from mikas.catalog import shipped
from mikas.client import Ecu
from mikas.client.parameters.polling import FixedMethod
from mikas.errors import PortNotFound
from mikas.link import Chunk
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.virtual import VirtualLink
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import CycleFailed, Event, ParameterDropped, Sampled, UnitFound
from mikas.tester import Tester
from mikas.virtual.bus import Bus, Stalls
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector, LineFault, Sent
from mikas.virtual.responder import Identity, Responder

METHODS: Final[tuple[FixedMethod, ...]] = ("single", "batch", "list", "stream")
NAMES: Final = ("FREQ", "INJ", "UOZ", "UACC/2", "TWAT/3", "RCOK/5")
IN_TROUBLE: Final = 0.4  # of all responses
_RATE: Final = 1 - (1 - IN_TROUBLE) ** (1 / len(LineFault))  # of each fault; they are tried in turn

_HOLE: Final = 10.0  # s without a value, while unit and cable are there


class CountingInjector(FaultInjector):
    """Counts the responses, those in trouble in `count`."""

    responses = 0

    def respond(self, wire: bytes) -> list[Sent]:
        self.responses += 1
        return super().respond(wire)


class Plug:
    """The adapter in its socket, from which it is pulled now and then; and the clock."""

    def __init__(self, bus: Bus, pulled: Outages) -> None:
        self.bus = bus
        self.pulled = pulled
        self.link: VirtualLink | None = None
        self._now = 0.0

    def now(self) -> float:
        return self._now if self.link is None else max(self._now, self.link.now())

    def wait(self, seconds: float) -> None:
        self._now = self.now() + seconds

    def open(self, url: str) -> VirtualLink:
        if self.pulled.covers(self.now()):
            raise PortNotFound(url=url, found="")
        self.link = PulledLink(self, url)
        return self.link


class PulledLink(VirtualLink):
    """A link that is lost when the adapter is pulled."""

    def __init__(self, plug: Plug, url: str) -> None:
        super().__init__(plug.bus, url=url, start=plug.now())
        self._plug = plug

    def read(self, deadline: float) -> Chunk:
        if self._plug.pulled.covers(self.now()):
            self.unplug()
        return super().read(deadline)


@dataclass
class Row:
    """The figures of one method."""

    method: str
    exchanges: int = 0
    troubles: int = 0
    hours: float = 0.0  # of simulated time
    sets: int = 0
    values: int = 0
    wrong: int = 0
    errors: int = 0  # failed cycles
    gaps: int = 0  # of one or more failed cycles
    holes: int = 0
    longest: float = 0.0  # of them, s
    ignition_cuts: int = 0
    unplugged: int = 0
    others: int = 0  # strangers found, times that run back
    dropped: int = 0  # parameters whose responses were lost so often that it looked like a refusal
    seconds: float = 0.0  # of this computer

    @property
    def is_right(self) -> bool:
        return not self.wrong and not self.others

    def cells(self) -> list[str]:
        counts = (self.exchanges, self.troubles, self.sets, self.values, self.wrong, self.others)
        losses = (self.dropped, self.errors, self.gaps, self.holes)
        return [
            self.method,
            *(f"{count:,}" for count in (*counts, *losses)),
            f"{self.longest:.1f} s",
            *(f"{count:,}" for count in (self.ignition_cuts, self.unplugged)),
            f"{self.hours:.1f} h",
            f"{self.seconds:.0f} s",
        ]


TITLES: Final = (
    *("method", "exchanges", "in trouble", "sets", "values", "WRONG", "other mistakes"),
    *(
        "dropped",
        "failed cycles",
        "gaps",
        f"holes > {_HOLE:.0f} s",
        "longest hole",
        "ignition cuts",
    ),
    *("unplugged", "simulated", "took"),
)


class Judge:
    """Looks at every event, and counts into `row`."""

    def __init__(self, row: Row, car: SoakCar, *outages: Outages) -> None:
        self.row = row
        self._car = car
        self._outages = outages
        self._latest = 0.0  # time of the last set
        self._failing = False
        self._is_named = False  # the unit's passports have been read

    def take(self, event: Event) -> None:
        match event:
            case Sampled():
                self._sampled(event)
            case CycleFailed():
                self.row.errors += 1
                self.row.gaps += not self._failing
                self._failing = True
            case ParameterDropped():
                self.row.dropped += 1
            case UnitFound():
                # Before the first passports, the unit may be another one.
                self.row.others += event.another and self._is_named
                self._is_named = True

    def _sampled(self, event: Sampled) -> None:
        row = self.row
        row.sets += 1
        row.values += len(event.fresh)
        for reading in (*event.fresh.values(), *event.stale.values()):
            code, conversion = reading.parameter.code, reading.parameter.conversion
            is_right = self._car.may_be(code, reading.raw, reading.time)
            row.wrong += not is_right or reading.value != conversion.decode(reading.raw)
        row.others += event.time <= self._latest
        silent = event.time - self._latest
        for outage in self._outages:
            silent -= outage.seconds_in(self._latest, event.time)
        row.holes += silent > _HOLE
        row.longest = max(row.longest, silent)
        self._latest, self._failing = event.time, False


def soak(method: FixedMethod, exchanges: int, seed: int) -> Row:
    """Sample by `method` until the unit has sent so many responses."""
    began, row = perf_counter(), Row(method)
    ignition_off, pulled = (
        Outages((60, 600), (0.2, 8), Random(f"{seed} {method} {what}")) for what in ("off", "out")
    )
    car = SoakCar(seed, ignition_off)
    injector = CountingInjector(dict.fromkeys(LineFault, _RATE), seed=seed)
    ecu = VirtualEcu(Responder(car, Identity(0x0A, ("MIKAS",) * 8)))
    plug = Plug(Bus(ecu, fault_injector=injector, stalls=Stalls(1.0, seed=seed)), pulled)
    port = ReconnectingPort("sim:", open_port=plug.open, clock=plug.now, wait=plug.wait)
    sampler = Acquisition(
        port, lambda link: Ecu(Tester(link), shipped()), shipped(), NAMES, method=method
    )
    judge = Judge(row, car, ignition_off, pulled)
    with closing(sampler.run()) as events:
        for event in events:
            judge.take(event)
            if injector.responses >= exchanges:
                break
    row.exchanges, row.troubles = injector.responses, injector.count
    row.ignition_cuts, row.unplugged = ignition_off.count, pulled.count
    row.hours, row.seconds = plug.now() / 3600, perf_counter() - began
    return row


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m bench.soak", description=__doc__)
    parser.add_argument("--exchanges", type=int, default=1_000_000, help="of all methods together")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rows = []
    print(f"seed {given.seed}")
    for cells in (TITLES, ["---"] * len(TITLES)):
        print(_line(cells))
    for method in METHODS:
        rows.append(soak(method, given.exchanges // len(METHODS), given.seed))
        print(_line(rows[-1].cells()), flush=True)
    return 0 if all(row.is_right for row in rows) else 1


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    sys.exit(main())
