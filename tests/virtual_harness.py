"""A tester, a wire and a unit with known data, on simulated time: what most tests need."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from math import ceil, inf
from pathlib import Path

from mikas.link.virtual import VirtualLink
from mikas.tester import Tester
from mikas.virtual.bus import AdapterKind, Bus, Stalls
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Identity, Responder

VECTORS = Path(__file__).parents[1] / "conformance"
EXCHANGES = json.loads((VECTORS / "exchanges.json").read_text("utf-8"))

# The raw bytes of each code of §4 (`protocol_codes`), by code, of a unit that has no other: the
# responses to the requests for one parameter in conformance/exchanges.json.
DATA = {
    bytes.fromhex(v["request"])[1]: bytes.fromhex(v["answer"])
    for v in EXCHANGES
    if v["why"] == "one parameter"
}
PASSPORTS = tuple(
    bytes.fromhex(v["answer"]).rstrip(b"\0").decode("cp866")
    for v in EXCHANGES
    if v["why"].startswith("passport")
)
FAULTS = [0x0D, 0x35, 0x40, 0x0D]
IDENTITY = Identity(0x0A, PASSPORTS)


class TableCar:
    """Data from a table, raw bytes by parameter code; `rpm` only paces streams by strokes (D15)."""

    def __init__(
        self, data: Mapping[int, bytes], *, faults: Iterable[int] = (), rpm: float = 0.0
    ) -> None:
        self.codes = tuple(data)
        self.faults = list(faults)
        self.rpm = rpm
        self.on = True
        self.data = dict(data)
        self._untouched = dict(data)

    def size_of(self, code: int) -> int | None:
        """Return the size of the datum in bytes, or None."""
        return len(self.data[code]) if code in self.data else None

    def raw(self, code: int, now: float) -> bytes:
        """Return the datum."""
        return self.data[code]

    def write(self, code: int, data: bytes) -> bool:
        """Write any parameter."""
        self.data[code] = data
        return True

    def engine_speed(self, now: float) -> float:
        """Return `rpm`."""
        return self.rpm

    def powered(self, now: float) -> bool:
        """Return `on`."""
        return self.on

    def next_change(self, after: float) -> float:
        """Return infinity: the supply does not change by itself."""
        return inf

    def next_stroke(self, stroke: int, after: float) -> float:
        """Return the next stroke of cycles of two turns that began at time 0."""
        if self.rpm <= 0:
            return inf
        cycle = 120 / self.rpm
        offset = max(0, stroke - 1) * cycle / 4
        count = ceil((after - offset) / cycle)
        time = count * cycle + offset
        # The quotient of two floats may round to the previous stroke.
        return time if time >= after else (count + 1) * cycle + offset

    def power_cycle(self) -> None:
        """Forget written data."""
        self.data = dict(self._untouched)


def make_bus(
    *,
    quirks: EcuQuirks | None = None,
    adapter: AdapterKind | None = None,
    fault_injector: FaultInjector | None = None,
    stalls: Stalls | None = None,
    rpm: float = 850.0,
) -> Bus:
    car = TableCar(DATA, faults=FAULTS, rpm=rpm)
    ecu = VirtualEcu(Responder(car, IDENTITY, quirks or EcuQuirks()))
    return Bus(ecu, adapter=adapter, fault_injector=fault_injector, stalls=stalls)


def make_tester(bus: Bus, **settings: object) -> Tester:
    return Tester(VirtualLink(bus), **settings)


def connected(bus: Bus | None = None, **settings: object) -> Tester:
    tester = make_tester(bus or make_bus(), **settings)
    tester.connect()
    return tester
