"""Routes of the data that a client requests first: the server, the channels, presets, history.

Presets are pages of tiles: those that come with the program, and the user's own.
"""

from __future__ import annotations

import io
import tomllib
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Final, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import JSONResponse, Response
from pydantic import BaseModel, Field

from mikas import unkept
from mikas.catalog import Confidence
from mikas.catalog.own.file import left_out
from mikas.dashboard.api.channel_info import ChannelInfo, channel_info
from mikas.dashboard.api.dependencies import (
    KnownClient,
    Names,
    TheDashboard,
    TheRequester,
    Viewer,
    Words,
    split_names,
)
from mikas.dashboard.api.errors import OptionalTexts, TwoTexts, content, errors, made_of, two
from mikas.dashboard.api.messages import LiveEvent, LiveRows
from mikas.dashboard.api.search import search_file
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import NotFound
from mikas.dashboard.security.access import Access
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.history import json_columns, page_json
from mikas.i18n import Text
from mikas.recording.table.decimation import decimated
from mikas.saving import KeptFile

router: Final = APIRouter(prefix="/api", tags=["about"])

_SHIPPED: Final = Path(__file__).parent.parent / "presets.toml"
_SVG: Final = content("image/svg+xml", "the image")
_MOST_BYTES: Final = 1 << 22  # of the file of presets; a request's body has 1 MiB, unindented
_Finite = Annotated[float, Field(allow_inf_nan=False)]
_ChannelName = Annotated[str, Field(min_length=1, max_length=40)]


class LanLinkInfo(BaseModel):
    """A link for other computers. `url` contains the token."""

    address: str
    url: str
    reached: bool = Field(description="another computer has come by this address")


class AboutResponse(BaseModel):
    """The server. `lan_url` contains the token; null for clients without control rights.

    `lan_links`: by all addresses, the likeliest first; empty for clients without control rights.

    `fingerprint`: SHA-256 of the certificate, by which `lan_url` is served; null: plain HTTP.
    """

    version: str
    rights: Literal["control", "view"]
    demo: bool
    lan: bool
    lan_control: bool = Field(description="clients in the network may control")
    local: bool = Field(description="this client is on this computer: it may open the network")
    url: str
    lan_url: str | None
    lan_links: list[LanLinkInfo]
    fingerprint: str | None
    recordings_folder: str
    desktop: bool = Field(
        description="an icon has started the program: the page ends it (`/api/end`)"
    )
    instance: str = Field(description="a mark of this run, new at each start; it gives no rights")
    problems: list[TwoTexts] = Field(
        description="files of the user's that can't be used, things that can't be saved, and why; "
        "empty without control rights"
    )


class Tile(BaseModel):
    """One tile. `names`: its channels; none: a table of all channels."""

    kind: Literal["gauge", "number", "lamp", "strip", "table"]
    names: list[_ChannelName] = Field(max_length=100)
    span: int = Field(1, ge=1, le=3)
    scale: tuple[_Finite, _Finite] | None = Field(
        None, description="of a gauge; null: that of the channel"
    )


class Preset(BaseModel):
    """One page of tiles."""

    id: str = Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")
    name: TwoTexts
    shipped: bool = False
    tiles: list[Tile] = Field(max_length=200)


class KnownFault(BaseModel):
    """A fault number and the channels that it concerns."""

    code: int
    text: TwoTexts
    check: OptionalTexts
    confidence: Confidence
    related: list[str]


class CatalogResponse(BaseModel):
    """All channels, the faults that concern a channel, the presets that come with the program."""

    version: str
    parameters: list[ChannelInfo]
    derived: list[ChannelInfo]
    units: dict[str, TwoTexts]
    faults: list[KnownFault]
    presets: list[Preset]
    problem: TwoTexts | None = Field(
        description="why the user's own catalog is left out; null: it is in use, or there is none"
    )


class PresetList(BaseModel):
    """The user's own presets."""

    presets: list[Preset] = Field(max_length=100)


class HistoryResponse(LiveRows):
    """Columns over time and events, as in live data; null: no new value in that row."""

    events: list[LiveEvent]
    later: float = Field(description="as in live data")


@router.get("/about", responses=errors(409, 504), response_model=AboutResponse)
async def about(request: Request, requester: TheRequester, client: Viewer) -> Response:
    """Return the server's version, addresses and folder, and the client's rights."""
    return await requester.answer(lambda: about_of(request, requester.dashboard, client))


def about_of(request: Request, dashboard: Dashboard, client: Client) -> AboutResponse:
    """Return the server as `client` sees it; reads the user's files."""
    access: Access = request.app.state.access
    own = dashboard.catalogs.problem
    unusable = [left_out(own)] if own else []
    found = [*unusable, *problems(dashboard), *unkept.sentences()]
    return made_of(
        AboutResponse,
        access,
        version=version("mikas"),
        rights="control" if client.may_control else "view",
        demo=dashboard.connection.is_demo,
        local=bool(request.scope["state"]["local"]),
        lan_url=access.lan_url if client.may_control else None,
        lan_links=[made_of(LanLinkInfo, it) for it in access.lan_links]
        if client.may_control
        else [],
        recordings_folder=str(dashboard.settings.recordings),
        desktop=dashboard.settings.desktop,
        problems=[two(each) for each in found] if client.may_control else [],
    )


@router.get("/about/qr.svg", response_class=Response, responses=errors(404) | _SVG)
def qr(request: Request, client: Viewer, address: Words | None = None) -> Response:
    """Return the link for other computers in the network as a QR code.

    `address`: that of the link; by default the likeliest one.
    """
    import segno

    access: Access = request.app.state.access
    links = [it.url for it in access.lan_links if address in (None, it.address)]
    if not links or not client.may_control:
        raise NotFound(name="/api/about/qr.svg")
    out = io.BytesIO()
    segno.make(links[0], error="m").save(out, kind="svg", scale=6, xmldecl=False)
    return Response(out.getvalue(), media_type="image/svg+xml")


@router.get("/catalog", responses=errors(409, 504), response_model=CatalogResponse)
async def catalog(requester: TheRequester) -> Response:
    """Return every channel."""
    return await requester.answer(lambda: catalog_of(requester.dashboard))


def catalog_of(dashboard: Dashboard) -> CatalogResponse:
    """Return the catalog in use."""
    known, own = dashboard.catalog, dashboard.catalogs.own.entries()
    problem = dashboard.catalogs.problem
    return CatalogResponse(
        version=known.version,
        parameters=[channel_info(known, parameter, own) for parameter in known.parameters],
        derived=[channel_info(known, derived, own) for derived in known.derived.values()],
        units={key: two(text) for key, text in known.units.items()},
        faults=[
            made_of(KnownFault, fault, related=fault.parameters)
            for fault in known.faults.values()
            if fault.parameters
        ],
        problem=two(problem.reason) if problem else None,
        presets=list(_shipped_presets()),
    )


@router.get("/presets", responses=errors(409, 504), response_model=PresetList)
async def presets(requester: TheRequester) -> Response:
    """Return the user's own presets; none if their file can't be used."""
    return await requester.answer(lambda: _presets(requester.dashboard))


def _presets(dashboard: Dashboard) -> PresetList:
    return _preset_file(dashboard).load() or PresetList(presets=[])


@router.put("/presets", responses=errors())
def write_presets(dashboard: TheDashboard, _: KnownClient, body: PresetList) -> PresetList:
    """Replace the user's presets, all or none."""
    content = [{**preset.model_dump(), "shipped": False} for preset in body.presets]
    with dashboard.saving:
        _preset_file(dashboard).save(content)
    return _presets(dashboard)


def _preset_file(dashboard: Dashboard) -> KeptFile[PresetList]:
    path = dashboard.settings.in_state("presets.json")
    return KeptFile(path, _MOST_BYTES, lambda stored: PresetList(presets=stored))


def problems(dashboard: Dashboard) -> list[Text]:
    """Return why files of the user's are not used, besides their own catalog."""
    files = (
        _preset_file(dashboard),
        search_file(dashboard),
        dashboard.library.references.file,
        dashboard.cars.file,
        dashboard.instruments.file,
        dashboard.guided.file,
    )
    return [problem for file in files if (problem := file.problem)]


@router.get("/history", responses=errors(409, 504), response_model=HistoryResponse)
async def history(
    requester: TheRequester,
    seconds: Annotated[float, Query(gt=0, le=86400)] = 900,
    points: Annotated[int, Query(ge=2, le=20000)] = 2000,
    names: Names = None,
) -> Response:
    """Return the last `seconds`, decimated by each column's minimum and maximum to keep spikes."""
    dashboard = requester.dashboard

    def work() -> Response:
        later = dashboard.connection.later
        rows = dashboard.history.rows(seconds, split_names(names))
        since = (rows.times[-1] if len(rows.times) else dashboard.connection.now()) - seconds
        logged = [event for event in dashboard.monitor.logged if event.time >= since]
        fewer = decimated(rows, points)
        shown = json_columns(fewer.times, fewer.values, later)
        events = [page_json(event.moved(later)) for event in logged]
        return JSONResponse(shown | {"events": events, "later": later})

    return await requester.compute(work)


@cache
def _shipped_presets() -> tuple[Preset, ...]:
    """Return the presets that come with the program."""
    stored = tomllib.loads(_SHIPPED.read_text("utf-8"))["preset"]
    return tuple(Preset(**{**preset, "shipped": True}) for preset in stored)
