"""Routes of the data that a client requests first: the server, the channels, presets, history.

Presets are pages of tiles: those that come with the program, and the user's own.
"""

from __future__ import annotations

import io
import json
import tomllib
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Final, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import JSONResponse, Response
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from mikas.catalog import Catalog, Confidence, Derived, Level, Parameter
from mikas.dashboard.api.dependencies import KnownClient, Names, TheDashboard, Viewer, split_names
from mikas.dashboard.api.errors import TwoTexts, content, errors, made_of, two
from mikas.dashboard.api.messages import LiveEvent, LiveRows
from mikas.dashboard.errors import NotFound
from mikas.dashboard.security.access import Access
from mikas.dashboard.session.event_log import page_json
from mikas.dashboard.session.history import json_columns
from mikas.errors import UsageError, reason_at
from mikas.files import read_regular
from mikas.recording.table.decimation import decimated
from mikas.saving import save

router = APIRouter(tags=["about"])

_SHIPPED: Final = Path(__file__).parent.parent / "presets.toml"
_SVG: Final = content("image/svg+xml", "the image")
_ChannelName = Annotated[str, Field(min_length=1, max_length=40)]


class AboutResponse(BaseModel):
    """The server. `lan_url` contains the token; null for clients without control rights.

    `fingerprint`: SHA-256 of the certificate, by which `lan_url` is served; null: plain HTTP.
    """

    version: str
    rights: Literal["control", "view"]
    demo: bool
    lan: bool
    url: str
    lan_url: str | None
    fingerprint: str | None
    recordings_folder: str


class ChannelLimits(BaseModel):
    """The limits of a channel; a value beyond one is an alarm."""

    model_config = ConfigDict(from_attributes=True)

    danger_low: float | None
    warning_low: float | None
    warning_high: float | None
    danger_high: float | None


class LampTexts(BaseModel):
    """The texts of a flag's lamp."""

    model_config = ConfigDict(from_attributes=True)
    on: TwoTexts
    off: TwoTexts


class ChannelErratum(BaseModel):
    """An erratum of the source that concerns this channel."""

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
    short: TwoTexts = Field(description="the text of a small tile")
    decimals: int
    formula: str
    range: tuple[float, float] | None
    reference: tuple[float, float] | None = Field(description="warm idle of a sound engine")
    gauge: tuple[float, float] | None = Field(
        description="the scale of its gauge; null: a flag, or a derived channel without one"
    )
    span_least: float | None = Field(
        description="the least span of an axis of its values; null: a flag"
    )
    limits: ChannelLimits | None
    lamp: LampTexts | None
    alarm_when_true: Level
    inputs: list[str] | None
    errata: list[ChannelErratum]
    confidence: Confidence
    writable: bool


class Tile(BaseModel):
    """One tile. `names`: its channels; none: a table of all channels."""

    kind: Literal["gauge", "number", "lamp", "strip", "table"]
    names: list[_ChannelName] = Field(max_length=100)
    span: int = Field(1, ge=1, le=3)


class Preset(BaseModel):
    """One page of tiles."""

    id: str = Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")
    name: TwoTexts
    shipped: bool = False
    tiles: list[Tile] = Field(max_length=200)


_MOST_BYTES: Final = 1 << 24  # of the file; a request's body has 1 MiB
_Presets: Final = TypeAdapter(list[Preset])


class CatalogResponse(BaseModel):
    """All channels, and the presets that come with the program."""

    version: str
    parameters: list[ChannelInfo]
    derived: list[ChannelInfo]
    presets: list[Preset]


class PresetList(BaseModel):
    """The user's own presets."""

    presets: list[Preset] = Field(max_length=100)


class HistoryResponse(LiveRows):
    """Columns over time and events, as in live data; null: no new value in that row."""

    events: list[LiveEvent]


@router.get("/about", responses=errors())
def about(request: Request, dashboard: TheDashboard, client: Viewer) -> AboutResponse:
    """Return the server's version, addresses and folder, and the client's rights."""
    access: Access = request.app.state.access
    return AboutResponse(
        version=version("mikas"),
        rights="control" if client.may_control else "view",
        demo=dashboard.connection.is_demo,
        lan=access.lan,
        url=access.url,
        lan_url=access.lan_url if client.may_control else None,
        fingerprint=access.fingerprint,
        recordings_folder=str(dashboard.settings.recordings),
    )


@router.get("/about/qr.svg", response_class=Response, responses=errors(404) | _SVG)
def qr(request: Request, client: Viewer) -> Response:
    """Return the link for other computers in the network as a QR code."""
    import segno

    access: Access = request.app.state.access
    if access.lan_url is None or not client.may_control:
        raise NotFound(name="/api/about/qr.svg")
    out = io.BytesIO()
    segno.make(access.lan_url, error="m").save(out, kind="svg", scale=6, xmldecl=False)
    return Response(out.getvalue(), media_type="image/svg+xml")


@router.get("/catalog", responses=errors())
def catalog(dashboard: TheDashboard) -> CatalogResponse:
    """Return every channel."""
    known = dashboard.catalog
    return CatalogResponse(
        version=known.version,
        parameters=[_channel(known, parameter) for parameter in known.parameters],
        derived=[_channel(known, derived) for derived in known.derived.values()],
        presets=list(_shipped_presets()),
    )


@router.get("/presets", responses=errors())
def presets(dashboard: TheDashboard) -> PresetList:
    """Return the user's own presets; none if their file can't be read."""
    try:
        stored = read_regular(dashboard.settings.presets, _MOST_BYTES)
        return PresetList(presets=_Presets.validate_json(stored))
    except (OSError, ValidationError):
        return PresetList(presets=[])


@router.put("/presets", responses=errors())
def write_presets(dashboard: TheDashboard, _: KnownClient, body: PresetList) -> PresetList:
    """Replace the user's presets, all or none."""
    file = dashboard.settings.presets
    content = [{**preset.model_dump(), "shipped": False} for preset in body.presets]
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        save(file, json.dumps(content, ensure_ascii=False, indent=1))
    except OSError as error:
        raise UsageError(problem=reason_at(file, error)) from error
    return presets(dashboard)


@router.get("/history", responses=errors(), response_model=HistoryResponse)
def history(
    dashboard: TheDashboard,
    seconds: Annotated[float, Query(gt=0, le=86400)] = 900,
    points: Annotated[int, Query(ge=2, le=20000)] = 2000,
    names: Names = None,
) -> Response:
    """Return the last `seconds`, decimated by each column's minimum and maximum to keep spikes."""
    rows = dashboard.history.rows(seconds, split_names(names))
    since = (rows.times[-1] if len(rows.times) else dashboard.connection.now()) - seconds
    events = [page_json(event) for event in dashboard.monitor.events if event.time >= since]
    return JSONResponse(json_columns(decimated(rows, points)) | {"events": events})


@cache
def _shipped_presets() -> tuple[Preset, ...]:
    """Return the presets that come with the program."""
    stored = tomllib.loads(_SHIPPED.read_text("utf-8"))["preset"]
    return tuple(Preset(**{**preset, "shipped": True}) for preset in stored)


def _channel(known: Catalog, channel: Parameter | Derived) -> ChannelInfo:
    parameter = channel if isinstance(channel, Parameter) else None
    limits, lamp = channel.alarm_limits, parameter.lamp if parameter else None
    return made_of(
        ChannelInfo,
        channel,
        derived=parameter is None,
        flag=channel.is_flag,
        code=parameter.code if parameter else None,
        size=parameter.size if parameter else None,
        unit=channel.unit_text,
        formula=channel.formula() if isinstance(channel, Parameter) else channel.formula,
        range=parameter.range if parameter else None,
        reference=parameter.reference if parameter else None,
        gauge=channel.gauge_scale,
        span_least=channel.least_span,
        limits=limits if limits and limits.for_number else None,
        lamp=lamp,
        alarm_when_true=limits.when_true if limits else Level.NONE,
        inputs=None if isinstance(channel, Parameter) else channel.inputs,
        errata=[
            ChannelErratum(id=name, text=two(known.errata[name].reason))
            for name in (parameter.errata if parameter else ())
        ],
        writable=parameter is not None and not parameter.is_flag,
    )
