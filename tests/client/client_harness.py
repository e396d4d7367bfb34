"""An `Ecu` on a virtual wire with simulated time, and what was asked on that wire."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from mikas.client import AsyncEcu, Ecu
from mikas.client.limits import LimitsStore
from mikas.client.parameters.polling import FIXED_METHODS as METHODS
from mikas.link.virtual import VirtualLink
from mikas.tester import Tester
from mikas.virtual.bus import Bus
from mikas.virtual.ecu import EcuEvent, VirtualEcu
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Identity, Responder
from protocol_codes import SECTION_4
from virtual_harness import DATA, FAULTS, IDENTITY, TableCar

STROKES = [method for method in METHODS if method.startswith("stroke")]
STREAMS = ["stream", *STROKES]
ASKED = [method for method in METHODS if method not in STREAMS]
PROBES = (b"\x01", bytes([0x61, 0x29]), bytes([0x61, 0x29, 0x29]))


@dataclass
class Bench:
    """A unit on its wire; with the requests that it has heard."""

    car: TableCar
    bus: Bus
    happenings: list[EcuEvent] = field(default_factory=list)
    link: VirtualLink | None = None  # of the last session

    def requests(self, first: int | None = None) -> list[bytes]:
        """The bodies that the unit has heard so far; only those of code `first`, if given."""
        heard = [h.data for h in self.happenings if h.kind == "request"]
        return [body for body in heard if first in (None, body[0])]

    def forget(self) -> None:
        self.happenings.clear()

    def next_faults(self, *line_faults: LineFault | None) -> None:
        self.bus.fault_injector.next(*line_faults)

    def power_cycle(self, ecu: Ecu) -> None:
        """Off and on again, without a request in between."""
        self.car.on = False
        self.bus.ecu.transmit(ecu.tester.link.now())
        self.car.on = True
        self.bus.ecu.transmit(ecu.tester.link.now())


def bench(
    data: dict[int, bytes] | None = None,
    *,
    identity: Identity = IDENTITY,
    rpm: float = 850.0,
    faults: Iterable[int] = FAULTS,
    car: TableCar | None = None,
    **quirks: object,
) -> Bench:
    """A unit with `data`, and with the quirks given by name as in a URL."""
    car = car or TableCar(DATA if data is None else data, faults=faults, rpm=rpm)
    options = EcuQuirks().with_options({name: str(it) for name, it in quirks.items()})
    ecu = VirtualEcu(Responder(car, identity, options))
    made = Bench(car, Bus(ecu, fault_injector=FaultInjector()))
    ecu.watcher = made.happenings.append
    return made


def ecu_on(
    it: Bench,
    *,
    journal: Path | None = None,
    state: Path | None = None,
    lists: Path | None = None,
    confirm: object = None,
    interpretation: str = "corrected",
    **settings: object,
) -> Ecu:
    """A connected `Ecu`; what was asked to connect is forgotten."""
    # The wire's clock goes on from session to session.
    link = VirtualLink(it.bus, start=it.link.now() if it.link else 0.0)
    it.link = link
    tester = Tester(link, **settings)
    tester.connect()
    ecu = Ecu(
        tester,
        SECTION_4,
        interpretation=interpretation,
        confirm=confirm,
        journal=journal,
        store=LimitsStore(state) if state else None,
        lists=lists,
    )
    it.forget()
    return ecu


@asynccontextmanager
async def by_worker(it: Bench, **settings: object) -> AsyncIterator[AsyncEcu]:
    """The same, asynchronous."""
    async with AsyncEcu(ecu_on(it, **settings)) as ecu:
        yield ecu


def lines(path: Path) -> list[dict[str, object]]:
    """A journal's entries; each line has to be JSON of its own."""
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]
