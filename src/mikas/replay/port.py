"""`replay:`: a recording as a port, on which a virtual ECU answers like the recorded one.

The ECU is on the usual virtual wire: 9600 baud, an echo if the recorded adapter had one, line
faults on request. Only the car has its own time, which can be scaled and moved while it runs. A
client waits for a silent ECU, but not for an ended recording: at the end the port raises
`RecordingOver`. After a `seek` it continues.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from mikas.catalog import Catalog, shipped
from mikas.errors import RecordingOver, usage_error
from mikas.link.base import CaptureTee, Link
from mikas.link.urls import take_clock
from mikas.link.virtual import BusLink, RealTimeVirtualLink, VirtualLink
from mikas.options import OptionParser, check_names
from mikas.replay.build import load
from mikas.replay.car import ReplayCar
from mikas.replay.responder import ReplayResponder
from mikas.virtual.build import WIRE_SETTINGS, wired

if TYPE_CHECKING:
    from mikas.virtual.bus import Bus

SETTINGS: Final = ("speed", "seek", "loop", *WIRE_SETTINGS)
"""Names of all settings, as texts: those of this module, and those of `mikas.virtual.build`.

`speed`: of the car, 1 by default; `seek`: where to begin, in seconds; `loop=1`: begin again at the
end. `echo`, `baud` and the switches of `EcuQuirks` are as recorded unless given.
"""
_FASTEST: Final = 1000.0
_BAUDS: Final = range(50, 4_000_001)


def replay_bus(
    path: str | os.PathLike[str],
    settings: Mapping[str, str] | None = None,
    *,
    catalog: Catalog | None = None,
) -> Bus:
    """Return the wire with the recorded ECU. The recording begins with the first byte of a request.

    Raise `UsageError` for a setting that does not exist or is invalid, `CaptureError` for a
    file that can't be read or holds no response.
    """
    settings, catalog = settings or {}, catalog or shipped()
    check_names(settings, SETTINGS)
    recorded = load(path, catalog)
    given = OptionParser(settings)
    seek = given.number("seek", 0.0, highest=1e9)
    speed = given.number("speed", 1.0, highest=_FASTEST)
    loop = given.switch("loop", default=False)
    if seek >= recorded.duration:
        length = f"{recorded.duration:.1f}"
        raise usage_error(
            f"seek={seek:g} is behind the end: the recording has {length} s",
            f"seek={seek:g} — за концом: в записи {length} с",
        )
    car = ReplayCar(recorded, catalog, seek=seek, speed=speed, loop=loop)
    wire = {"echo": "1" if recorded.echo else "0"}
    if recorded.baud in _BAUDS:
        wire["baud"] = str(recorded.baud)
    wire |= {name: value for name, value in settings.items() if name in WIRE_SETTINGS}
    return wired(ReplayResponder(car), wire)


def open_replay(url: str, options: dict[str, str]) -> Link:
    """Open `replay:FILE?speed=2&seek=600&loop=1&clock=real|simulated&…`.

    On the simulated clock, times begin with the recording's own. Raise `BadPortUrl` for an option
    that does not exist or is invalid, `CaptureError` for the file.
    """
    settings = dict(options)
    simulated = take_clock(settings)
    place = _file_in(url)
    if not place:
        raise usage_error("it names no file: replay:FILE", "в нём нет файла: replay:ФАЙЛ")
    bus = replay_bus(place, settings)
    if not simulated:
        return RealTimeReplayLink(bus, url=url)
    car = car_on(bus)
    assert car is not None
    start = car.recorded.begin + car.position()
    return ReplayLink(bus, url=url, start=start)


def playing(link: Link) -> ReplayCar | None:
    """Return the recording on `link`, to seek in it; None: another kind of link."""
    while isinstance(link, CaptureTee):
        link = link.link
    return car_on(getattr(link, "bus", None))


def car_on(bus: object) -> ReplayCar | None:
    """Return the recording on `bus`; None: another kind of bus."""
    responder = getattr(getattr(bus, "ecu", None), "responder", None)
    car = getattr(responder, "car", None)
    return car if isinstance(car, ReplayCar) else None


class _EndingLink(BusLink):
    """The end of a recording is that of its port."""

    def _check(self) -> None:
        super()._check()
        car, now = car_on(self.bus), self.now()
        if car is not None and car.is_over(now):
            car.look(now)
            raise RecordingOver(file=_file_in(self.url), time=now)


class ReplayLink(_EndingLink, VirtualLink):
    """A replay in simulated time."""


class RealTimeReplayLink(_EndingLink, RealTimeVirtualLink):
    """A replay in real time."""


def _file_in(url: str) -> str:
    """Return the file as the user wrote it."""
    return url.partition("?")[0].partition(":")[2].removeprefix("//")
