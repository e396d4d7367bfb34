"""A tester, a wire and a unit with known data, on simulated time: what most tests need."""

from __future__ import annotations

import json
from pathlib import Path

from mikas.link.virtual import VirtualLink
from mikas.tester import Tester
from mikas.virtual.bus import AdapterKind, Bus
from mikas.virtual.cars import TableCar
from mikas.virtual.ecu import VirtualEcu
from mikas.virtual.fault_injector import FaultInjector
from mikas.virtual.quirks import EcuQuirks
from mikas.virtual.responder import Identity, Responder

VECTORS = Path(__file__).parent / "vectors"
EXCHANGES = json.loads((VECTORS / "exchanges.json").read_text("utf-8"))

# The data that the exchange vectors were made with, by parameter code.
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


def make_bus(
    *,
    quirks: EcuQuirks | None = None,
    adapter: AdapterKind | None = None,
    fault_injector: FaultInjector | None = None,
    rpm: float = 850.0,
) -> Bus:
    car = TableCar(DATA, faults=FAULTS, rpm=rpm)
    ecu = VirtualEcu(Responder(car, IDENTITY, quirks or EcuQuirks()))
    return Bus(ecu, adapter=adapter, fault_injector=fault_injector)


def make_tester(bus: Bus, **settings: object) -> Tester:
    return Tester(VirtualLink(bus), **settings)


def connected(bus: Bus | None = None, **settings: object) -> Tester:
    tester = make_tester(bus or make_bus(), **settings)
    tester.connect()
    return tester
