"""What a client asks first: who this is, the channels with all that is known of them, presets,
the past of the running connection.
"""

from __future__ import annotations

import io
from importlib.metadata import version
from typing import Annotated, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.catalog import Catalog, Confidence, Derived, Level, Parameter
from mikas.dashboard.api import presets as stored
from mikas.dashboard.api.broadcaster import dumps
from mikas.dashboard.api.dependencies import KnownClient, TheDashboard, Viewer
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.api.messages import LiveEvent
from mikas.dashboard.api.presets import Preset
from mikas.dashboard.errors import NotFound
from mikas.dashboard.security.access import Access
from mikas.dashboard.session.event_log import page_json
from mikas.dashboard.session.history import json_columns
from mikas.recording.table.decimation import decimated

router = APIRouter(tags=["about"])


class AboutResponse(BaseModel):
    """Who this is. `lan_url` has the token in it, and is told to those with full rights only."""

    version: str
    rights: Literal["control", "view"]
    demo: bool
    lan: bool
    url: str
    lan_url: str | None
    recordings_folder: str


class ChannelLimits(BaseModel):
    """Beyond them is an alarm."""

    danger_low: float | None
    warning_low: float | None
    warning_high: float | None
    danger_high: float | None


class LampTexts(BaseModel):
    """What stands on a flag's lamp."""

    on: TwoTexts
    off: TwoTexts


class ChannelErratum(BaseModel):
    """A doubtful place of the source that bears on this channel."""

    id: str
    text: TwoTexts


class ChannelInfo(BaseModel):
    """A parameter, or a derived channel (`inputs`; no code and no size)."""

    name: str
    derived: bool
    flag: bool
    code: int | None
    size: int | None
    unit: TwoTexts
    text: TwoTexts
    decimals: int
    formula: str
    range: tuple[float, float] | None
    reference: tuple[float, float] | None = Field(description="warm idle of a sound engine")
    limits: ChannelLimits | None
    lamp: LampTexts | None
    alarm_when_true: Level
    inputs: list[str] | None
    errata: list[ChannelErratum]
    confidence: Confidence
    writable: bool


class CatalogResponse(BaseModel):
    """Everything that can be shown, and the presets that come with the program."""

    version: str
    parameters: list[ChannelInfo]
    derived: list[ChannelInfo]
    presets: list[Preset]


class PresetList(BaseModel):
    """The user's own."""

    presets: list[Preset] = Field(max_length=100)


class HistoryResponse(BaseModel):
    """Columns over time as in live data, and what happened. null: not fresh in that row."""

    names: list[str]
    times: list[float]
    values: list[list[float | None]]
    events: list[LiveEvent]


@router.get("/about", responses=errors())
def about(request: Request, dashboard: TheDashboard, client: Viewer) -> AboutResponse:
    """Who this is."""
    access: Access = request.app.state.access
    return AboutResponse(
        version=version("mikas"),
        rights="control" if client.may_control else "view",
        demo=dashboard.connection.is_demo,
        lan=access.lan,
        url=access.url,
        lan_url=access.lan_url if client.may_control else None,
        recordings_folder=str(dashboard.settings.recordings),
    )


@router.get(
    "/about/qr.svg",
    response_class=Response,
    responses={**errors(404), 200: {"content": {"image/svg+xml": {}}}},
)
def qr(request: Request, client: Viewer) -> Response:
    """The link for others in the network as a QR code."""
    import segno

    access: Access = request.app.state.access
    if access.lan_url is None or not client.may_control:
        raise NotFound(name="/api/about/qr.svg")
    out = io.BytesIO()
    segno.make(access.lan_url, error="m").save(out, kind="svg", scale=6, xmldecl=False)
    return Response(out.getvalue(), media_type="image/svg+xml")


@router.get("/catalog", responses=errors())
def catalog(dashboard: TheDashboard) -> CatalogResponse:
    """Every channel."""
    known = dashboard.catalog
    return CatalogResponse(
        version=known.version,
        parameters=[_channel(known, it) for it in known.parameters],
        derived=[_channel(known, it) for it in known.derived.values()],
        presets=list(stored.shipped()),
    )


@router.get("/presets", responses=errors())
def presets(dashboard: TheDashboard) -> PresetList:
    """The user's own presets."""
    return PresetList(presets=stored.own(dashboard.settings.presets))


@router.put("/presets", responses=errors())
def keep_presets(dashboard: TheDashboard, _: KnownClient, body: PresetList) -> PresetList:
    """Keeps the user's presets, instead of those that were there."""
    stored.keep(dashboard.settings.presets, body.presets)
    return presets(dashboard)


@router.get("/history", responses=errors(), response_model=HistoryResponse)
def history(
    dashboard: TheDashboard,
    seconds: Annotated[float, Query(gt=0, le=86400)] = 900,
    points: Annotated[int, Query(ge=2, le=20000)] = 2000,
    names: Annotated[str | None, Query(max_length=4000, description="A,B; all")] = None,
) -> Response:
    """The last `seconds`, decimated by each column's minimum and maximum so that spikes stay."""
    wanted = [name for name in names.split(",") if name] if names is not None else None
    rows = dashboard.history.rows(seconds, wanted)
    since = (rows.times[-1] if len(rows.times) else dashboard.connection.now()) - seconds
    events = [page_json(event) for event in dashboard.monitor.events if event.time >= since]
    shown = json_columns(decimated(rows, points))
    return Response(dumps({**shown, "events": events}), media_type="application/json")


def _channel(known: Catalog, it: Parameter | Derived) -> ChannelInfo:
    limits, parameter = it.alarm_limits, it if isinstance(it, Parameter) else None
    lamp = parameter.lamp if parameter else None
    return ChannelInfo(
        name=it.name,
        derived=parameter is None,
        flag=it.is_flag,
        code=parameter.code if parameter else None,
        size=parameter.size if parameter else None,
        unit=two(it.unit_text),
        text=two(it.text),
        decimals=it.decimals,
        formula=it.formula() if isinstance(it, Parameter) else it.formula,
        range=parameter.range if parameter else None,
        reference=parameter.reference if parameter else None,
        limits=ChannelLimits(
            danger_low=limits.danger_low,
            warning_low=limits.warning_low,
            warning_high=limits.warning_high,
            danger_high=limits.danger_high,
        )
        if limits is not None and limits.for_number
        else None,
        lamp=LampTexts(on=two(lamp.on), off=two(lamp.off)) if lamp else None,
        alarm_when_true=limits.when_true if limits else Level.NONE,
        inputs=None if isinstance(it, Parameter) else list(it.inputs),
        errata=[
            ChannelErratum(id=name, text=two(known.errata[name].reason))
            for name in (parameter.errata if parameter else ())
        ],
        confidence=it.confidence,
        writable=parameter is not None and not parameter.is_flag,
    )
