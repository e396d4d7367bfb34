"""`replay:` — a recording as a port: a virtual unit that answers as the recorded one did.

The unit stands on the usual virtual wire: 9600 baud, an echo if the recorded adapter gave one, line
faults if asked for. Only the car's time is another one: it can be scaled, and moved while it runs.
At the end the port says that the recording is over, lest anybody waits for the ignition.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mikas.catalog import Catalog, shipped
from mikas.errors import CaptureError, MissingExtra, UsageError
from mikas.i18n import Text
from mikas.link.base import Link
from mikas.link.tee import CaptureTee
from mikas.link.urls import take_clock
from mikas.options import OptionParser, check_names
from mikas.recording.notes import Kind, Note
from mikas.recording.reader import CaptureReader
from mikas.recording.replay_car import ReplayCar
from mikas.recording.replay_index import index
from mikas.recording.replay_link import RealTimeReplayLink, ReplayLink
from mikas.recording.replay_recorded import Recorded
from mikas.recording.replay_unit import ReplayResponder
from mikas.virtual.build import WIRE_SETTINGS, wired

if TYPE_CHECKING:
    from mikas.virtual.bus import Bus
    from mikas.virtual.ecu import EcuEvent

__all__ = ["SETTINGS", "ReplayCar", "car_on", "load", "open_replay", "playing", "replay_bus"]

SETTINGS: Final = ("speed", "seek", "loop", *WIRE_SETTINGS)
"""Names of all settings, as texts: those of this module, and those of `mikas.virtual.build`.

`speed`: of the car, 1 by default; `seek`: where to begin, in seconds; `loop=1`: begin again at the
end. `echo`, `baud` and the switches of `EcuQuirks` are as recorded unless given.
"""
_FASTEST: Final = 1000.0
_BAUDS: Final = range(50, 4_000_001)


def load(path: str | os.PathLike[str], catalog: Catalog | None = None) -> Recorded:
    """What can be replayed of a capture. Raises `CaptureError` if that is nothing at all.

    Damaged parts are passed over; `problems` counts them.
    """
    reader = CaptureReader(path)
    notes = list(reader.notes())
    recorded = _indexed(reader, catalog or shipped(), notes)
    if not recorded.frames:
        raise CaptureError(str(Path(path)), _NOTHING)
    _add_noted_identity(recorded, notes)
    return recorded


def _indexed(reader: CaptureReader, catalog: Catalog, notes: list[Note]) -> Recorded:
    """By numpy where it is installed: ten hours in seconds, not minutes; else packet by packet."""
    try:
        from mikas.recording.replay_bulk import index_file
    except MissingExtra:
        return index(reader, catalog, notes)
    return index_file(reader.path, catalog, notes)


def replay_bus(
    path: str | os.PathLike[str],
    settings: Mapping[str, str] | None = None,
    *,
    start: float | None = None,
    catalog: Catalog | None = None,
    watcher: Callable[[EcuEvent], None] | None = None,
) -> Bus:
    """The wire with the recorded unit on it. The recording begins at `start` of the owner's clock;
    with None, when the first byte of a request is heard.

    Raises `UsageError` for a setting that does not exist or makes no sense, `CaptureError` for a
    file that can't be read or holds no response.
    """
    settings = settings or {}
    check_names(settings, SETTINGS)
    given = OptionParser(settings)
    return _bus_of(
        load(path, catalog),
        settings,
        catalog or shipped(),
        start=start,
        seek=given.number("seek", 0.0, highest=1e9),
        speed=given.number("speed", 1.0, highest=_FASTEST),
        loop=given.switch("loop", default=False),
        watcher=watcher,
    )


def _bus_of(
    recorded: Recorded,
    settings: Mapping[str, str],
    catalog: Catalog,
    *,
    start: float | None,
    seek: float,
    speed: float,
    loop: bool,
    watcher: Callable[[EcuEvent], None] | None,
) -> Bus:
    if seek >= recorded.duration:
        length = f"{recorded.duration:.1f}"
        raise UsageError(
            problem=Text(
                f"seek={seek:g} is behind the end: the recording has {length} s",
                f"seek={seek:g} — за концом: в записи {length} с",
            )
        )
    car = ReplayCar(recorded, catalog, start=start, seek=seek, speed=speed, loop=loop)
    as_recorded = {"echo": "1" if recorded.echo else "0"}
    if recorded.baud in _BAUDS:
        as_recorded["baud"] = str(recorded.baud)
    given = {name: value for name, value in settings.items() if name in WIRE_SETTINGS}
    return wired(ReplayResponder(car), as_recorded | given, watcher=watcher)


def open_replay(url: str, options: dict[str, str]) -> Link:
    """Opens `replay:FILE?speed=2&seek=600&loop=1&clock=real|simulated&…`.

    On the simulated clock, times begin with the recording's own. Raises `BadPortUrl` for an option
    that does not exist or makes no sense, `CaptureError` for the file.
    """
    settings = dict(options)
    simulated = take_clock(settings)
    place = url.partition("?")[0].partition(":")[2].removeprefix("//")
    if not place:
        raise UsageError(
            problem=Text("it names no file: replay:FILE", "в нём нет файла: replay:ФАЙЛ")
        )
    bus = replay_bus(place, settings)
    if not simulated:
        return RealTimeReplayLink(bus, url=url, file=place)
    car = car_on(bus)
    assert car is not None
    start = car.recorded.begin + car.position()
    return ReplayLink(bus, url=url, start=start, file=place)


def playing(link: Link) -> ReplayCar | None:
    """The recording that is played on `link`, to seek in it; None if it is another kind of link."""
    while isinstance(link, CaptureTee):
        link = link.link
    return car_on(getattr(link, "bus", None))


def car_on(bus: object) -> ReplayCar | None:
    """The recording that is played on `bus`; None if it is another kind of bus."""
    responder = getattr(getattr(bus, "ecu", None), "responder", None)
    car = getattr(responder, "car", None)
    return car if isinstance(car, ReplayCar) else None


def _add_noted_identity(recorded: Recorded, notes: list[Note]) -> None:
    """What a note tells of the unit, where the wire does not: it may have been asked before."""
    for note in notes:
        if note.kind != Kind.UNIT:
            continue
        version = note.data.get("version_code")
        if isinstance(version, int) and 0 <= version <= 0xFF and not recorded.version.values:
            recorded.version.add(0.0, version)
        pieces = note.data.get("passports")
        if not isinstance(pieces, list):  # not what `unit_note` writes
            recorded.problems += pieces is not None
            continue
        codes = range(0x51, 0x59)
        for code, piece, known in zip(codes, pieces, recorded.passports, strict=False):
            if isinstance(piece, str) and not known.values:
                known.add(0.0, piece)
                recorded.refusals.pop(code, None)


_NOTHING: Final = Text(
    "there is no response of an ECU in it, so there is nothing to replay",
    "в записи нет ни одного ответа блока, воспроизводить нечего",
)
