"""Routes of the virtual cars: what can be chosen, and the answer to a blind one.

A car is chosen by its URL, `sim:?scenario=mixed&car=leak:8` (`POST /api/connect`).
"""

from __future__ import annotations

from typing import Annotated, Final

from fastapi import APIRouter, Query
from pydantic import BaseModel, Field

from mikas.dashboard.api.errors import TwoTexts, errors, made_of

router: Final = APIRouter(prefix="/api", tags=["connection"])


class VirtualScenario(BaseModel):
    """A shipped scenario."""

    name: str
    text: TwoTexts


class VirtualDefect(BaseModel):
    """A defect in one direction: its amounts from `sound` to `most`.

    `phrase`: an amount in words; `{}` stands for the number with its unit.
    """

    key: str
    text: TwoTexts
    phrase: TwoTexts
    unit: TwoTexts
    percent: bool = Field(description="the amount is a share, shown in %")
    sound: float
    least: float
    noticeable: float
    most: float


class VirtualCarsResponse(BaseModel):
    """The scenarios, and the defects with the commonest direction of each first."""

    scenarios: list[VirtualScenario]
    defects: list[VirtualDefect]


class AnsweredDefect(BaseModel):
    """A defect of a car, with its amount."""

    key: str
    amount: float
    text: TwoTexts


class AnswerResponse(BaseModel):
    """The defects of a car; none: it is sound."""

    car: str
    defects: list[AnsweredDefect]


@router.get("/virtual-cars", responses=errors())
def virtual_cars() -> VirtualCarsResponse:
    """Return the scenarios and defects that a virtual car can have."""
    from mikas.virtual.defects.table import DEFECTS, SIDES  # late: most users have a cable
    from mikas.virtual.scenarios.scenario import SCENARIOS

    return VirtualCarsResponse(
        scenarios=[made_of(VirtualScenario, it) for it in SCENARIOS.values()],
        defects=[
            made_of(
                VirtualDefect,
                side,
                phrase=side.amount,
                unit=DEFECTS[side.key].unit,
                percent=DEFECTS[side.key].percent,
            )
            for side in SIDES
        ],
    )


@router.get("/virtual-cars/answer", responses=errors())
def answer(
    car: Annotated[str, Query(max_length=200, examples=["blind:4711"])],
) -> AnswerResponse:
    """Return the defects of a virtual car, by the text of its `car` option."""
    from mikas.virtual.defects import choosing

    found = choosing.answer(car)
    return AnswerResponse(car=car, defects=[made_of(AnsweredDefect, it) for it in found])
