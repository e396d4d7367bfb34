"""A garage on simulated time: one cable, cars, and what happens to them at which second.

The link runs on the garage's clock, and so does the wait for an adapter that is away. A program in
a thread of its own can be held at a moment, and continued: so two threads take turns, and every
run is the same.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from urllib.parse import parse_qsl

import pytest

from mikas.errors import PortNotFound
from mikas.link import Chunk
from mikas.link.ports import Port
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.virtual import VirtualLink
from mikas.virtual.build import build_bus
from mikas.virtual.bus import Bus
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.responder import Identity, Responder

CABLE = Port(
    "/dev/ttyUSB0",
    "FT232R USB UART (FTDI)",
    likely=True,
    vid=0xFFF1,
    pid=0xFFF2,
    serial_number="GOLDEN",
    location="9-9",
)


class GarageLink(VirtualLink):
    """The cable's link; at each read the garage looks at its clock."""

    def __init__(self, garage: Garage, bus: Bus, url: str) -> None:
        super().__init__(bus, url=url, start=garage.now())
        self._garage = garage
        self._reader = threading.current_thread()

    def read(self, deadline: float) -> Chunk:
        self._garage.look()
        return super().read(deadline)

    def close(self) -> None:
        super().close()
        if threading.current_thread() is not self._reader:
            self._garage.release()


class ForgetfulResponder(Responder):
    """Gives no answer to the first two requests for the passport's piece `code`."""

    code = 0x54
    lost = 0

    def answer(self, body: bytes, now: float) -> bytes | None:
        if body[0] == self.code and self.lost < 2:
            self.lost += 1
            return None
        return super().answer(body, now)


class Garage:
    """`settings`: of the first car, as in a `sim:` URL."""

    def __init__(self, settings: str) -> None:
        self.bus = build_bus(dict(parse_qsl(settings)))
        self.ports = [CABLE]
        self._links: list[GarageLink] = []
        self._idle = 0.0  # the clock without a link
        self._plan: list[tuple[float, Callable[[], object]]] = []
        self._held = threading.Condition()
        self._is_to_hold: Callable[[], bool] = lambda: False
        self._is_held = False
        self._released = False

    # For the program

    def open(self, url: str) -> GarageLink:
        if not self.ports:
            raise PortNotFound(url=url, found="")
        self._released = False
        link = GarageLink(self, self.bus, url)
        self._links.append(link)
        return link

    def find(self) -> list[Port]:
        return list(self.ports)

    def now(self) -> float:
        return max(self._idle, VirtualLink.now(self._links[-1]) if self._links else 0.0)

    def wait(self, seconds: float) -> None:
        self.stand(seconds)
        self.look()

    def stand(self, seconds: float) -> None:
        """Let the time pass while no program uses the cable."""
        self._idle = self.now() + seconds
        self.bus.advance(self._idle)

    def look(self) -> None:
        """Let happen what is due, and hold the caller where that is wanted."""
        while self._plan and self._plan[0][0] <= self.now():
            self._plan.pop(0)[1]()
        with self._held:
            while self._is_to_hold() and not self._released:
                self._is_held = True
                self._held.notify_all()
                self._held.wait()

    def release(self) -> None:
        """Hold the present caller no longer: its link was closed under it."""
        with self._held:
            self._released = True
            self._held.notify_all()

    # For the test

    def at(self, time: float, happens: Callable[[], object]) -> None:
        self._plan.append((time, happens))

    def until(self, time: float) -> None:
        """Let the program's thread go on until this moment of its clock."""
        self.hold_when(lambda: self.now() >= time)

    def hold_when(self, is_time: Callable[[], bool]) -> None:
        """Let the program's thread go on until `is_time`; nothing else runs meanwhile."""
        with self._held:
            self._is_to_hold, self._is_held = is_time, False
            self._held.notify_all()
            assert self._held.wait_for(lambda: self._is_held, timeout=60)

    def hold_next(self) -> None:
        """Hold the program's next thread at its first read."""
        with self._held:
            self._is_to_hold, self._is_held = lambda: True, False

    async def held(self) -> None:
        """Wait for that, while the others run."""
        while not self._is_held:
            await asyncio.sleep(0.001)

    @property
    def car(self):
        return self.bus.ecu.responder.car

    def ignition(self, *, on: bool) -> None:
        self.car.powered = lambda _: on

    def supply(self, *, on: bool) -> None:
        """Put the plug into the car's socket, or pull it out: then the adapter has no 12 V."""
        self.bus.adapter.kind = replace(self.bus.adapter.kind, supplied=on)

    def disturb(self, rates: Mapping[LineFault, float]) -> None:
        """Let the line be as bad as this from now on."""
        self.bus.fault_injector.rates = dict(rates)

    def pull(self) -> None:
        """Pull the cable out of the computer."""
        self.ports = []
        self._links[-1].unplug()

    def plug(self, name: str = CABLE.url) -> None:
        self.ports = [replace(CABLE, url=name)]

    def park(self, settings: str) -> None:
        """Let another car stand at the cable."""
        self.bus = build_bus(dict(parse_qsl(settings)), start=self.now())

    def identify_as(self, *passports: str) -> None:
        """Put another unit of the same version into the car."""
        responder = self.bus.ecu.responder
        self.bus.ecu.responder = Responder(
            responder.car, Identity(0x0A, passports), memory=responder.memory
        )

    def forget_a_piece(self) -> None:
        """Lose a piece of the passport when it is read first."""
        responder = self.bus.ecu.responder
        self.bus.ecu.responder = ForgetfulResponder(
            responder.car, responder.identity, memory=responder.memory
        )

    def equip(self, patch: pytest.MonkeyPatch) -> None:
        """Let every port wait and look around in this garage."""
        init = ReconnectingPort.__init__

        def in_garage(port: ReconnectingPort, *args: object, **settings: object) -> None:
            own = {"clock": self.now, "wait": self.wait, "find": self.find}
            init(port, *args, **(settings | own))

        patch.setattr(ReconnectingPort, "__init__", in_garage)


@dataclass(frozen=True)
class Drive:
    """`happens`: what to do at which second. `method`: by which the unit is sampled."""

    name: str
    seconds: float
    settings: str = ""
    method: str = "batch"
    happens: Callable[[Garage], None] = lambda _: None

    def garage(self) -> Garage:
        garage = Garage(self.settings)
        self.happens(garage)
        return garage


def _noise(garage: Garage) -> None:
    garage.at(9, lambda: garage.car.faults.append(13))
    usual = dict(garage.bus.fault_injector.rates)
    garage.at(13, lambda: garage.disturb({LineFault.LOST: 0.8, LineFault.DAMAGED: 0.3}))
    garage.at(15.5, lambda: garage.disturb(usual))


def _stalls(garage: Garage) -> None:
    garage.at(9, lambda: garage.ignition(on=False))
    garage.at(13.5, lambda: garage.ignition(on=True))


def _unplugging(garage: Garage) -> None:
    garage.at(7, garage.pull)
    garage.at(10.4, lambda: garage.plug("/dev/ttyUSB1"))
    garage.at(15, lambda: garage.supply(on=False))
    garage.at(18, lambda: garage.supply(on=True))


def _swapped_unit(garage: Garage) -> None:
    garage.at(8, lambda: garage.ignition(on=False))
    garage.at(10.5, lambda: garage.identify_as("МИКАС 7.1", "ANOTHER", *[""] * 6))
    garage.at(11, lambda: garage.ignition(on=True))


def _another_car(garage: Garage) -> None:
    garage.at(8, garage.pull)
    garage.at(11, lambda: garage.park("model=5.4&faults=40&seed=9"))
    garage.at(11.5, garage.plug)


def _lost_piece(garage: Garage) -> None:
    garage.forget_a_piece()
    garage.at(8, garage.pull)
    garage.at(10, garage.plug)


DRIVES = (
    Drive("noise", 20, "faults=21&damaged=0.03&noise=0.03&lost=0.02&seed=3", happens=_noise),
    Drive("stalls", 20, "stall_every=6&stall_ms=1700&seed=5", "stream", _stalls),
    Drive("unplugging", 24, "faults=13", happens=_unplugging),
    Drive("swapped-unit", 18, "faults=13,21", happens=_swapped_unit),
    Drive("another-car", 18, happens=_another_car),
    Drive("lost-piece", 16, happens=_lost_piece),
)
