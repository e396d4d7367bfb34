"""Routes of setting the idle CO by a meter, as `mikas co` does: what to write next, and why.

The page keeps the figures of the meter and sends all of them with each new one, so that nothing is
held here. Nothing is written here either: each byte is a change of RCOD, made in two steps by
`/api/changes`, with the write lock and the journal.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Final

from fastapi import APIRouter
from pydantic import BaseModel, Field

from mikas.catalog import Parameter
from mikas.client import Ecu
from mikas.dashboard.api.dependencies import Controller, TheDashboard
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.errors import BadRequest
from mikas.guided.co_conditions import CHANNEL, NEEDED, idle_problems, not_kept
from mikas.guided.co_setting import (
    BOUNDS,
    MOST_WRITES,
    WIDEST,
    WITHIN,
    CoOutcome,
    CoSetting,
    MixtureMeter,
)
from mikas.i18n import Text

router: Final = APIRouter(prefix="/api/co", tags=["changes"])

Figure = Annotated[float, Field(ge=0, le=15, allow_inf_nan=False)]
Byte = Annotated[str, Field(pattern=r"^[0-9A-Fa-f]{2}$")]


class MeterBounds(BaseModel):
    """The figures that a meter can show, and how near to the goal is near enough."""

    meter: MixtureMeter
    lowest: float
    highest: float
    within: float


class CoValue(BaseModel):
    """RCOD: its byte in hex, and its value."""

    raw: str
    value: float


class CoResponse(BaseModel):
    """What the unit has now. `problems`: why nothing may be set now; empty: it is warm idle."""

    now: CoValue
    values: dict[str, float]
    problems: list[TwoTexts]
    meters: list[MeterBounds]


class CoStepRequest(BaseModel):
    """An adjustment so far. `found`: the byte at its begin; `figures`: of the meter, all of them,
    the last one belongs to the present byte; `within` null: as usual.
    """

    meter: MixtureMeter
    target: Figure
    within: Annotated[float, Field(gt=0, le=5, allow_inf_nan=False)] | None = None
    found: Byte
    figures: list[Figure] = Field(min_length=1, max_length=MOST_WRITES + 1)


class CoStepResponse(BaseModel):
    """What to do. With `problems` nothing, and the last figure does not count.

    `next`: of `write` the byte to write, of `stop` the one to put back, of `set` the present one.
    `turned`: the unit was found to count the other way just now.
    """

    outcome: CoOutcome
    next: CoValue
    why: TwoTexts
    turned: bool
    now: CoValue
    problems: list[TwoTexts]


@router.get("", responses=errors(409, 502, 503))
async def co(dashboard: TheDashboard, _: Controller) -> CoResponse:
    """Read RCOD, and whether the engine is at warm idle."""
    parameter = dashboard.catalog.parameter(CHANNEL)
    raw, values = await dashboard.connection.ask(_read)
    return CoResponse(
        now=_value(parameter, raw),
        values=values,
        problems=[two(each) for each in idle_problems(values)],
        meters=[
            MeterBounds(meter=each, lowest=low, highest=high, within=WITHIN[each])
            for each, (low, high) in BOUNDS.items()
        ],
    )


@router.post("/step", responses=errors(409, 502, 503))
async def step(dashboard: TheDashboard, _: Controller, body: CoStepRequest) -> CoStepResponse:
    """Return what to do with the meter's last figure; reads the unit, and changes nothing."""
    _check(body.meter, [body.target, *body.figures])
    if body.within is not None and body.within > WIDEST[body.meter]:
        most = f"{WIDEST[body.meter]:g}"
        raise BadRequest(
            problem=Text(f"near enough is up to {most}", f"достаточная точность — до {most}")
        )
    parameter = dashboard.catalog.parameter(CHANNEL)
    found = int(body.found, 16)
    setting = CoSetting(found, body.target, body.within or WITHIN[body.meter], body.meter)
    for figure in body.figures[:-1]:
        setting.next(figure)
    held, values = await dashboard.connection.ask(_read)
    problems = idle_problems(values)
    if held != setting.raw:
        problems.append(not_kept(*(_shown(parameter, raw) for raw in (setting.raw, held))))
    due = setting.next(body.figures[-1])
    return CoStepResponse(
        outcome=due.outcome,
        next=_value(parameter, due.raw),
        why=two(due.why),
        turned=due.turned,
        now=_value(parameter, held),
        problems=[two(each) for each in problems],
    )


def _read(ecu: Ecu) -> tuple[int, dict[str, float]]:
    readings = ecu.read(CHANNEL, *NEEDED)
    values = {name: float(readings[name].value) for name in NEEDED}
    return readings[CHANNEL].raw[0], values


def _check(meter: MixtureMeter, figures: Sequence[float]) -> None:
    low, high = BOUNDS[meter]
    for figure in figures:
        if not low <= figure <= high:
            raise BadRequest(
                problem=Text(
                    f"{figure:g} is no figure of this meter: from {low:g} to {high:g}",
                    f"{figure:g} — не показание этого прибора: от {low:g} до {high:g}",
                )
            )


def _value(parameter: Parameter, raw: int) -> CoValue:
    return CoValue(raw=f"{raw:02X}", value=float(parameter.decode(bytes([raw]))))


def _shown(parameter: Parameter, raw: int) -> str:
    return f"{_value(parameter, raw).value:.{parameter.decimals}f}".replace("-", "−")
