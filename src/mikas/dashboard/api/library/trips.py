"""Routes of the trips: litres, distance, idle time, the way, the measured mixture.

Of the running connection's last two hours, or of a recording; from a mark on, or all of it. The
files of the way are written by the export. Work in the lane of files, as whole recordings are read.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Iterator, Sequence
from math import inf
from typing import TYPE_CHECKING, Annotated, Final, Literal

from fastapi import APIRouter, Query
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.dashboard.api.dependencies import TheRequester, json_of
from mikas.dashboard.api.errors import TwoTexts, errors, made_of, two
from mikas.dashboard.api.library.files import FILE, sent_export
from mikas.dashboard.api.library.report import of_this_unit, without_other_readings
from mikas.dashboard.errors import BadRequest, NotConnected
from mikas.dashboard.session.history import LONGEST
from mikas.i18n import Language, Text, joined
from mikas.sampling.events import Event, Marker

if TYPE_CHECKING:
    from pathlib import Path as FilePath

    from mikas.dashboard.dashboard import Dashboard
    from mikas.drives.overview import DrawnWay, DriveOverview
    from mikas.drives.trip import Trip
    from mikas.recording.table.channels import Rows

router: Final = APIRouter(prefix="/api", tags=["recordings"])

_LIVE: Final = "the trip of the running connection"  # no file has this name
_MOST: Final = 500  # drives that are listed
_SAME: Final = 1e-3  # s, within which a time is that of a mark
_GPS: Final = Text(
    "Before the next drive: Connection → Instruments beside the unit, a GPS or this phone's "
    "position.",
    "Перед следующей поездкой: «Связь» → «Приборы рядом с блоком», GPS или местоположение этого "
    "телефона.",
)
_NO_WAY: Final = joined(
    " ",
    (
        Text(
            "No way: no GPS beside the unit gave a place.",
            "Пути на карте нет: GPS рядом с блоком не дал координат.",
        ),
        _GPS,
    ),
)
_NO_GPS: Final = joined(
    " ",
    (
        Text(
            "No kilometres, no litres on 100 km and no way: there was no GPS beside the unit.",
            "Нет ни километров, ни литров на 100 км, ни пути: GPS рядом с блоком не было.",
        ),
        _GPS,
    ),
)
_ASKED: Final = Text(
    "The program asks for them by itself; a plan from a script may lack them, and some units do "
    "not give them.",
    "Программа опрашивает их сама; их может не быть в плане из скрипта, а некоторые блоки их не "
    "дают.",
)

Since = Annotated[float | None, Query(allow_inf_nan=False, description="the time of a marker")]
Colour = Annotated[str, Query(max_length=40, description="the channel that colours the way")]
Track = Literal["gpx", "geojson"]


class TripSums(BaseModel):
    """A drive, or all together. A sum is null where nothing was measured of it, and else holds for
    the seconds beside it.
    """

    begin: float
    end: float
    seconds: float
    gap_seconds: float
    litres: float | None
    litres_from: str | None
    fuel_seconds: float
    kilometres: float | None
    speed_seconds: float
    idle_seconds: float | None
    idle_known: float
    litres_per_100_km: float | None
    mean_speed: float | None
    highest_speed: float | None
    mean_rpm: float | None
    highest_rpm: float | None


class TripMark(BaseModel):
    """A mark from which a trip can be counted."""

    time: float
    label: str


class WayLineInfo(BaseModel):
    """A line of the way. `level`: of its value, null: unknown; metres from the first place."""

    level: int | None
    east: list[float]
    north: list[float]


class WayInfo(BaseModel):
    """The way. `ends`: of the levels of the channel `colour`; empty: it has one value."""

    colour: str
    ends: list[float]
    lines: list[WayLineInfo]


class MixtureCellInfo(BaseModel):
    """A range of speed and load; `difference`: measured by aimed, per cent above 1."""

    rpm: tuple[float, float]
    load: tuple[float, float]
    count: int
    aimed: float
    measured: float
    difference: float
    verdict: Literal["agrees", "leaner", "richer", "scatters", "too-few"]


class MixtureInfo(BaseModel):
    """VALF against the measured λ. `load`: its channel; `unsteady`, `lean`: values left out."""

    load: str
    cells: list[MixtureCellInfo]
    unsteady: int
    lean: int


class TripResponse(BaseModel):
    """The drives, the first first; `total` null: the engine did not run, or `lacks` says why.

    `lacks`: what the sums leave out, and what to do. `channels`: those that can colour the way.
    """

    trips: list[TripSums]
    count: int = Field(description="of all drives; the latest are listed")
    total: TripSums | None
    lacks: list[TwoTexts]
    marks: list[TripMark]
    way: WayInfo | None
    mixture: MixtureInfo | None
    channels: list[str]


@router.get("/trip/{form}", response_class=Response, responses=errors(400, 409, 503, 504) | FILE)
async def way_file(
    requester: TheRequester, form: Track, since: Since = None, lang: Language = "en"
) -> Response:
    """Return the way of the connected car in the last two hours, for maps."""
    dashboard = requester.dashboard

    def write(out: FilePath) -> None:
        from mikas.recording.export import export
        from mikas.recording.table.channels import all_channels
        from mikas.recording.table.instrument_columns import instrument_column

        rows, marks = _live(dashboard)
        begin = _moment(marks, since).time
        catalog, beside = dashboard.catalog, dashboard.instruments.channels
        known = {each.name: instrument_column(each) for each in beside}
        wanted = [name for name in rows.values if name in known or name in catalog.channels]
        channels = all_channels({}, catalog, wanted, known)
        rows = rows.part(rows.times >= begin)
        events = [each for each in marks if each.time >= begin]
        export(out, [channels[name] for name in wanted], [rows], events=events, language=lang)

    return await sent_export(requester, _LIVE, f"mikas.{form}", write)


@router.get(
    "/recordings/{identity}/trip/{form}",
    response_class=Response,
    responses=errors(400, 404, 409, 504) | FILE,
)
async def recorded_way_file(
    requester: TheRequester,
    identity: str,
    form: Track,
    since: Since = None,
    lang: Language = "en",
) -> Response:
    """Return the way in a recording, for maps; from a mark on, or all of it."""
    library = requester.library
    source = await asyncio.to_thread(library.of_any, identity)

    def write(out: FilePath) -> None:
        from mikas.recording.export import export

        opened = library.opened(source, latest=True)
        begin = _moment(_marks(opened.events), since).time
        recording = opened.interpreted(library.interpretation)
        export(
            out,
            recording.channels,
            (rows.part(rows.times >= begin) for rows in recording.rows()),
            events=[each for each in recording.events if each.time >= begin],
            about=recording.about,
            language=lang,
        )

    return await sent_export(requester, source.id, f"{source.path.stem}.{form}", write)


@router.get("/trip", responses=errors(400, 409, 503, 504), response_model=TripResponse)
async def trip(
    requester: TheRequester, since: Since = None, colour: Colour = "GPS_SPEED"
) -> Response:
    """Return the drives in the connected car's last two hours."""
    dashboard = requester.dashboard

    def work() -> TripResponse:
        from mikas.drives.overview import overview_of_live

        rows, marks = _live(dashboard)
        found = overview_of_live(rows, _moment(marks, since).time, colour)
        return _response(found, marks, rows.values)

    return await requester.make(_LIVE, lambda: json_of(work()))


@router.get(
    "/recordings/{identity}/trip", responses=errors(400, 404, 409, 504), response_model=TripResponse
)
async def recorded_trip(
    requester: TheRequester, identity: str, since: Since = None, colour: Colour = "GPS_SPEED"
) -> Response:
    """Return the drives in a recording."""
    library = requester.library

    def work() -> TripResponse:
        from mikas.drives.overview import overview_of_recording

        recording = library.opened(library.of_any(identity), latest=True)
        marks = _marks(recording.events)
        mark = None if since is None else _moment(marks, since)
        found = overview_of_recording(recording, mark, colour)
        return _response(found, marks, (each.name for each in recording.channels))

    return await requester.make(identity, lambda: json_of(work()))


def _live(dashboard: Dashboard) -> tuple[Rows, list[Marker]]:
    """Return the rows of the connected car, and its marks, in the time of the API."""
    from mikas.recording.table.channels import Rows

    with dashboard.monitor.lock:
        unit, events = dashboard.monitor.unit, dashboard.monitor.logged
    rows, events = of_this_unit(dashboard.history.rows(LONGEST), events)
    if unit is None and not len(rows.times):
        raise NotConnected
    later = dashboard.session.later
    rows = without_other_readings(
        Rows(rows.times + later, rows.values),
        dashboard.catalog,
        dashboard.settings.connection.interpretation,
    )
    return rows, _marks(each.moved(later) for each in events)


def _marks(events: Iterable[Event]) -> list[Marker]:
    return [each for each in events if isinstance(each, Marker) and not each.removed]


def _moment(marks: Sequence[Marker], time: float | None) -> Marker:
    """Return the mark of that time; None: one before all. Raises `BadRequest` for another time."""
    if time is None:
        return Marker(-inf)
    for mark in marks:
        if abs(mark.time - time) < _SAME:
            return mark
    raise BadRequest(
        problem=Text(
            "there is no mark at that time: it was removed, or is older than what is kept",
            "отметки с таким временем нет: её убрали, или она старше того, что хранится",
        )
    )


def _response(
    found: DriveOverview, marks: Sequence[Marker], channels: Iterable[str]
) -> TripResponse:
    from mikas.drives.trip import joined_trips

    total = joined_trips(found.trips)
    return TripResponse(
        trips=[_sums(each) for each in found.trips[-_MOST:]],
        count=len(found.trips),
        total=_sums(total) if total else None,
        lacks=[two(each) for each in _lacks(found, total)],
        marks=[TripMark(time=each.time, label=each.label) for each in marks],
        way=_way(found.way) if found.way else None,
        mixture=made_of(MixtureInfo, found.mixture) if found.mixture else None,
        channels=list(channels),
    )


def _sums(trip: Trip) -> TripSums:
    return made_of(TripSums, trip)


def _lacks(found: DriveOverview, total: Trip | None) -> Iterator[Text]:
    """Yield each thing that is missing, with the remedy on the screens."""
    from mikas.drives.wording import NO_FUEL, NO_SPEED, left_out

    if found.why is not None:
        yield found.why
    missing = list(left_out(total)) if total is not None else []
    for each in missing:
        if each == NO_SPEED:
            yield joined(" ", (each, _GPS)) if found.way is not None else _NO_GPS
        else:
            yield joined(" ", (each, _ASKED)) if each == NO_FUEL else each
    if found.way is None and NO_SPEED not in missing:
        yield _NO_WAY


def _way(way: DrawnWay) -> WayInfo:
    return WayInfo(
        colour=way.colour,
        ends=list(way.ends),
        lines=[
            WayLineInfo(
                level=line.level,
                east=[round(east, 1) for east, _ in line.points],
                north=[round(north, 1) for _, north in line.points],
            )
            for line in way.lines
        ],
    )
