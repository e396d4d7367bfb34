"""Routes of the car's details: those of the connected unit, and those in a recording."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Final

from fastapi import APIRouter
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas import unkept
from mikas.client.cars import LONGEST, MOST_MILEAGE, NO_CAR, CarDetails, car_details
from mikas.client.identity import UnitIdentity
from mikas.dashboard.api.dependencies import KnownClient, Line, TheDashboard, TheRequester
from mikas.dashboard.api.errors import errors
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import NotConnected
from mikas.dashboard.library.folder import RecordingFile
from mikas.i18n import Text
from mikas.recording.annotations.events import RecordedUnit, car_note
from mikas.recording.capture.writer import append_note

router: Final = APIRouter(prefix="/api", tags=["recordings"])

_UNKEPT = Text(
    "The car's details can't be saved ({place}: {why}): they stay until this program ends.",
    "Данные машины не сохраняются ({place}: {why}): они останутся до завершения программы.",
)


class CarInfo(BaseModel):
    """A car as its owner or a workshop names it; empty or null: not given."""

    car: str
    plate: str
    mileage: int | None = Field(description="km")
    workshop: str


class CarRequest(BaseModel):
    """The details of a car; they replace all those before."""

    car: Line = Field("", max_length=LONGEST)
    plate: Line = Field("", max_length=LONGEST)
    mileage: int | None = Field(None, ge=0, le=MOST_MILEAGE, description="km")
    workshop: Line = Field("", max_length=LONGEST)

    def details(self) -> CarDetails:
        """Return the details, cleaned."""
        return car_details(self.model_dump())


class CarResponse(CarInfo):
    """The car of the connected unit. `mileage`: the last one given."""

    unit: bool = Field(description="a unit answers whose car can be kept: it has a passport")
    asked: bool = Field(description="the details were given, or put off, once")


@router.get("/car", responses=errors(409, 504), response_model=CarResponse)
async def car(requester: TheRequester) -> Response:
    """Return the details of the connected unit's car."""
    return await requester.answer(lambda: _car(requester.dashboard))


def _car(dashboard: Dashboard) -> CarResponse:
    unit, cars = dashboard.monitor.unit, dashboard.cars
    identity = unit.identity if unit else None
    kept = cars.details_of(identity)
    shown = kept or CarDetails(workshop=cars.workshop)
    return CarResponse(**asdict(shown), unit=cars.keeps(identity), asked=kept is not None)


@router.put("/car", responses=errors(409, 503))
def write_car(dashboard: TheDashboard, _: KnownClient, body: CarRequest) -> CarResponse:
    """Keep the details of the connected unit's car, and write them into a running recording.

    Empty ones put the question off. A mileage of null leaves the last one.
    """
    unit = dashboard.monitor.unit
    if unit is None or unit.version_code is None:
        raise NotConnected
    details = body.details()
    _keep(dashboard, unit.identity, details)
    dashboard.car_now = unit.identity, details
    if details:
        dashboard.recorder.describe(details)
    return _car(dashboard)


@router.put("/recordings/{identity}/car", responses=errors(404, 409, 504))
async def write_recording_car(
    requester: TheRequester, _: KnownClient, identity: str, body: CarRequest
) -> CarInfo:
    """Write the details of the car into a recording's file; they replace those before.

    If it is of the connected unit, whose car is not known, they are kept for the next ones, too.
    """
    dashboard, library = requester.dashboard, requester.library
    details = body.details()
    now, date = dashboard.connection.now(), dashboard.connection.date()

    def write(file: RecordingFile) -> CarInfo:
        _keep_unknown(dashboard, library.summary(file).unit, details)
        if library.is_growing(file):
            dashboard.recorder.recorder.describe(car_note(now, details))
        else:
            append_note(file.path, car_note(date, details))
        return CarInfo(**asdict(details))

    return await requester.view(identity, write)


def _keep_unknown(dashboard: Dashboard, recorded: RecordedUnit | None, details: CarDetails) -> None:
    """Keep `details` of a recorded unit, if that is connected and its car has no name yet."""
    unit = dashboard.monitor.unit
    if recorded is None or unit is None or not recorded.identity.may_be(unit.identity):
        return
    kept = dashboard.cars.details_of(unit.identity)
    if details.name and not (kept and kept.name):
        workshop = CarDetails(workshop=dashboard.cars.workshop)
        _keep(dashboard, unit.identity, details.over(workshop))


def _keep(dashboard: Dashboard, unit: UnitIdentity, details: CarDetails) -> None:
    with unkept.saying_once(_UNKEPT, dashboard.cars.file.path):
        dashboard.cars.keep(unit, details)


def car_of_connection(dashboard: Dashboard) -> CarDetails:
    """Return the details for a report on the connected car: the mileage only if it was given since
    the program started, as it is another later.
    """
    unit, now = dashboard.monitor.unit, dashboard.car_now
    if unit is not None and now is not None and now[0].may_be(unit.identity):
        return now[1]
    kept = dashboard.cars.details_of(unit.identity if unit else None)
    return replace(kept or NO_CAR, mileage=None)
