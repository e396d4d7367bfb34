"""`VirtualUnit`: a unit for a test. Its values are set, its line fails, its cable is pulled out.

Its time is simulated: minutes pass in no time, and none passes between two calls.

    with VirtualUnit(scenario="city", faults="17") as car, car.connect() as ecu:
        car.set("TWAT", 110)
        car.next_responses(LineFault.LOST, None, LineFault.CUT)
        car.pass_time(60)
"""

from __future__ import annotations

from typing import Any, Self

from mikas.catalog import shipped
from mikas.client.connecting import connect
from mikas.client.ecu import Ecu
from mikas.errors import usage_error
from mikas.link import Link
from mikas.link.virtual import VirtualLink
from mikas.options import check_choice
from mikas.sampling.plan import select
from mikas.virtual.build import build_bus
from mikas.virtual.bus import Bus
from mikas.virtual.ecu import EcuEvent
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.responder import Car

__all__ = ["LineFault", "VirtualUnit"]


class _SetCar:
    """Another car, with data that a test has set and a key that it turns."""

    def __init__(self, car: Car) -> None:
        self.car = car
        self.on = True
        self.data: dict[int, bytes] = {}
        self.codes = car.codes

    @property
    def faults(self) -> list[int]:
        """The stored faults, in the unit's order."""
        return self.car.faults

    @faults.setter
    def faults(self, codes: list[int]) -> None:
        self.car.faults = codes

    def size_of(self, code: int) -> int | None:
        """Return the size of the datum in bytes."""
        return self.car.size_of(code)

    def raw(self, code: int, now: float) -> bytes:
        """Return the datum that was set, else the car's."""
        return self.data.get(code) or self.car.raw(code, now)

    def write(self, code: int, data: bytes) -> bool:
        """Write the car's datum; one that was set is no longer."""
        self.data.pop(code, None)
        return self.car.write(code, data)

    def powered(self, now: float) -> bool:
        """Return whether the key is on, here and in the car's scenario."""
        return self.on and self.car.powered(now)

    def next_change(self, after: float) -> float:
        """Return when the scenario turns the key."""
        return self.car.next_change(after)

    def next_stroke(self, stroke: int, after: float) -> float:
        """Return when the engine next reaches this stroke."""
        return self.car.next_stroke(stroke, after)

    def engine_speed(self, now: float) -> float:
        """Return the engine's speed, as it was set."""
        return self.car.engine_speed(now)

    def power_cycle(self) -> None:
        """Forget written data; what the test has set stays."""
        self.car.power_cycle()


def _as_text(value: str | float) -> str:
    """Return the value as in a URL: 1 for True, 7 for 7.0."""
    is_whole = isinstance(value, bool) or (isinstance(value, float) and value.is_integer())
    return str(int(value)) if is_whole else str(value)


class VirtualUnit:
    """A virtual unit of `sim:` with these options (docs/reference/simulator.md), for one test.

    Raises `UsageError` for an unknown option or an invalid value.
    """

    def __init__(self, **options: str | float) -> None:
        self._events: list[EcuEvent] = []
        given = {name: _as_text(value) for name, value in options.items()}
        self.bus: Bus = build_bus(given, watcher=self._events.append)
        """The wire with the unit, for what has no method here."""
        self._car = _SetCar(self.bus.ecu.responder.car)
        self.bus.ecu.responder.car = self._car
        self._link = VirtualLink(self.bus)

    @property
    def now(self) -> float:
        """The simulated time in seconds."""
        return self._link.now()

    @property
    def requests(self) -> tuple[bytes, ...]:
        """The bodies that the unit has heard since `forget_requests`, undamaged ones."""
        return tuple(event.data for event in self._events if event.kind == "request")

    @property
    def faults(self) -> list[int]:
        """The stored faults by number, in the unit's order; may be changed and replaced."""
        return self._car.faults

    @faults.setter
    def faults(self, codes: list[int]) -> None:
        if wrong := [code for code in codes if code not in range(256)]:
            raise usage_error(
                f"a fault has a number of 0 to 255, not {wrong[0]!r}",
                f"номер ошибки — от 0 до 255, а не {wrong[0]!r}",
            )
        self._car.faults = codes

    def connect(self, **options: Any) -> Ecu:
        """Connect as `mikas.connect`, with its options; the time goes on from before.

        An adapter that was pulled out is plugged in again.
        """
        ecu = connect(link=self.link(), **options)
        self.forget_requests()
        return ecu

    def link(self) -> Link:
        """Open a new link to the unit, at the time of the one before."""
        self._link = VirtualLink(self.bus, start=self.now)
        return self._link

    def set(self, name: str, value: float | bool) -> None:
        """Let a parameter have this value. Raises `UnknownParameter`, `ValueDoesNotFit`.

        A derived channel follows from its parameters: a `UsageError`.
        """
        if channel := shipped().derived.get(shipped().channel_of(name)):
            inputs = ", ".join(each.parameter.name for each in select(shipped(), [name]).parameters)
            raise usage_error(
                f"{channel.name} is computed: set what it is computed from, {inputs}",
                f"{channel.name} вычисляется: задайте то, из чего, — {inputs}",
            )
        parameter = shipped().parameter(name)
        if parameter.is_flag:
            mask = parameter.conversion.mask or 0
            before = self._car.raw(parameter.code, self.now)[0]
            self._car.data[parameter.code] = bytes([before | mask if value else before & ~mask])
        else:
            self._car.data[parameter.code] = parameter.encode(value)

    def unset(self, name: str) -> None:
        """Let a parameter have the engine's value again."""
        self._car.data.pop(shipped().parameter(name).code, None)

    def next_responses(self, *faults: LineFault | str | None) -> None:
        """Let the next responses have these faults, in their order; None: that one has none.

        After a failed exchange the tester asks the unit for its identity, which takes a response
        of these too. A fault may be given by its value, `"lost"`.
        """
        known = [each.value for each in LineFault]
        for each in faults:
            if isinstance(each, str):
                check_choice("fault", each, known)
        self.bus.fault_injector.next(
            *(None if each is None else LineFault(each) for each in faults)
        )

    def pass_time(self, seconds: float) -> None:
        """Let time pass without a request, also while nothing is connected."""
        if seconds < 0:
            raise usage_error("time does not run back", "время назад не идёт")
        self._link.pass_time(seconds)

    def turn_key(self, *, on: bool) -> None:
        """Switch the unit's supply; off, it answers nothing and forgets all that is volatile."""
        self._car.on = on
        self.bus.ecu.transmit(self.now)

    def unplug(self) -> None:
        """Pull out the adapter: the link that is open is lost. `connect` plugs it in again."""
        self._link.unplug()

    def forget_requests(self) -> None:
        """Empty `requests`; the next ones are listed again."""
        self._events.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._link.close()
