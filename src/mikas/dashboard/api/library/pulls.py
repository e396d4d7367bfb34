"""Route of power and torque from the pulls of a recording, as `mikas pull` has them."""

from __future__ import annotations

from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import Response
from pydantic import BaseModel

from mikas.dashboard.api.dependencies import TheRequester, json_of
from mikas.dashboard.api.errors import errors, made_of
from mikas.dashboard.errors import BadRequest
from mikas.i18n import Text

router: Final = APIRouter(prefix="/api", tags=["recordings"])

_NO_GEAR: Final = Text(
    "no GPS was recorded: give the speed at 1000 rpm in the gear of the pull",
    "GPS в записи нет: укажите скорость при 1000 об/мин на передаче разгона",
)


class PullPointInfo(BaseModel):
    """The means of one range of the engine's speed, at the wheels: kW and Nm with their doubt."""

    rpm: float
    speed: float
    power: float
    doubt: float
    torque: float
    torque_doubt: float


class PullInfo(BaseModel):
    """One pull. `slips`: the gear seems to change in it by `slip`, its figures are worth little."""

    begin: float
    end: float
    speed_from: str
    per_1000: float
    slip: float
    slips: bool
    points: list[PullPointInfo]


class PullsResponse(BaseModel):
    """The pulls, the first first."""

    pulls: list[PullInfo]


@router.get(
    "/recordings/{identity}/pulls",
    responses=errors(400, 404, 409, 504),
    response_model=PullsResponse,
)
async def recorded_pulls(
    requester: TheRequester,
    identity: str,
    *,
    mass: Annotated[float, Query(allow_inf_nan=False, description="kg")] = 1500,
    per_1000: Annotated[float | None, Query(allow_inf_nan=False)] = None,
    drag_area: Annotated[float, Query(allow_inf_nan=False)] = 0.9,
    slope: Annotated[float, Query(allow_inf_nan=False, description="per cent, up is positive")] = 0,
) -> Response:
    """Return power and torque from the pulls of a recording: full throttle in one gear.

    `per_1000`: km/h at 1000 rpm in that gear; without it a GPS has measured the speed.
    """
    library = requester.library

    def work() -> PullsResponse:
        from mikas.drives.pulls import SLIPS, PullSettings, has_speed, pulls

        recording = library.opened(library.of_any(identity), latest=True)
        if per_1000 is None and not has_speed(recording):
            raise BadRequest(problem=_NO_GEAR)
        settings = PullSettings(mass, per_1000, drag_area, slope=slope / 100)
        found = pulls(recording, settings)
        return PullsResponse(
            pulls=[made_of(PullInfo, each, slips=each.slip > SLIPS) for each in found]
        )

    return await requester.make(identity, lambda: json_of(work()))
