"""Instruments in the virtual car at the unit's port: `--port sim: --instrument aem=sim:`."""

from __future__ import annotations

from typing import Final

from mikas.errors import LinkLost, usage_error
from mikas.i18n import Text
from mikas.instruments.choosing import ChosenInstrument
from mikas.link import Link
from mikas.link.base import Chunk, LinkWrapper
from mikas.link.reconnecting import ReconnectingPort
from mikas.link.virtual import BusLink
from mikas.virtual.cars import EngineCar
from mikas.virtual.instruments import VirtualInstrument


class VirtualSource:
    """An instrument in the virtual car at `port`. `read` never waits."""

    def __init__(self, chosen: ChosenInstrument, port: ReconnectingPort) -> None:
        self._name, self._port = chosen.definition.name, port
        self._instrument: VirtualInstrument | None = None
        self._bus: BusLink | None = None

    def open(self) -> None:
        """As `InstrumentSource.open`."""
        found = _bus_link(self._port.link)
        if found is None:
            raise LinkLost(url="sim:", problem=_NO_CAR)
        car = found.bus.ecu.responder.car
        if not isinstance(car, EngineCar):
            raise usage_error(
                "sim: as an instrument's port is for a virtual unit, at --port sim:",
                "sim: как порт прибора — только для виртуального блока, --port sim:",
            )
        with found.held():
            self._instrument = VirtualInstrument(self._name, car, found.now())
        self._bus = found

    def read(self) -> list[Chunk]:
        """As `InstrumentSource.read`."""
        found = _bus_link(self._port.link)
        if self._instrument is None or self._bus is None or found is not self._bus:
            raise LinkLost(url="sim:", problem=_NO_CAR)
        ahead = self._port.now() - found.now()
        with found.held():
            messages = self._instrument.sent(found.now())
        return [Chunk(data, time + ahead) for time, data in messages]

    def close(self) -> None:
        """As `InstrumentSource.close`."""

    def reset(self) -> None:
        """As `InstrumentSource.reset`."""
        self._instrument = self._bus = None


_NO_CAR: Final = Text("there is no virtual car yet", "виртуальной машины ещё нет")


def _bus_link(link: Link | None) -> BusLink | None:
    while isinstance(link, LinkWrapper):
        link = link.link
    return link if isinstance(link, BusLink) else None
