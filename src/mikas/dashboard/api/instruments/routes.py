"""Routes of the instruments beside the unit: the choice, the user's definitions, positions."""

from __future__ import annotations

import asyncio
from typing import Annotated, Final

from fastapi import APIRouter, Path
from fastapi.responses import Response

from mikas.dashboard.api.dependencies import (
    Controller,
    KnownClient,
    TheDashboard,
    TheRequester,
    Viewer,
)
from mikas.dashboard.api.errors import errors
from mikas.dashboard.api.instruments.models import (
    InstrumentsResponse,
    InstrumentStates,
    NewInstrument,
    OwnDefinition,
    Position,
    instruments_now,
    instruments_of,
)
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import Busy, NotFromNetwork
from mikas.dashboard.security.access import check_from_network
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.instruments.positions import POSITIONS
from mikas.i18n import Text
from mikas.instruments.places import GPSD

router: Final = APIRouter(prefix="/api/instruments", tags=["instruments"])

_IN_USE: Final = Text(
    "the instrument {name} has this definition; remove it first",
    "это описание у прибора {name}; сначала уберите прибор",
)
Title = Annotated[str, Path(max_length=80)]
Named = Annotated[str, Path(pattern=r"^[a-z0-9][a-z0-9-]{0,39}$")]


@router.get("", responses=errors(409, 504), response_model=InstrumentsResponse)
async def instruments(requester: TheRequester, client: Viewer) -> Response:
    """Return the instruments with their states, the definitions, and all their channels."""
    return await requester.answer(lambda: instruments_of(requester.dashboard, client))


@router.post("", responses=errors(409, 503))
async def add_instrument(
    dashboard: TheDashboard, client: Controller, body: NewInstrument
) -> InstrumentsResponse:
    """Read one more instrument from now on; a running recording goes on in another file."""
    if not client.local and body.port not in (POSITIONS, "sim:"):
        if body.port.lower().startswith(GPSD):
            raise NotFromNetwork(url=body.port)
        await asyncio.to_thread(check_from_network, body.port, dashboard.settings.find)
    one = await asyncio.to_thread(
        dashboard.instruments.placed, body.definition, body.port, body.label
    )
    await dashboard.instruments.add(one)
    return await _all(dashboard, client)


@router.post("/position", responses=errors(404))
def position(dashboard: TheDashboard, _: KnownClient, body: Position) -> InstrumentStates:
    """Take the position of the phone that shows the page."""
    dashboard.instruments.put_position(body.report())
    return InstrumentStates(instruments=instruments_now(dashboard))


@router.put("/definitions/{name}", responses=errors(409, 503))
async def write_definition(
    dashboard: TheDashboard, client: Controller, name: Named, body: OwnDefinition
) -> InstrumentsResponse:
    """Write a definition of the user's own; an instrument that has it uses it at once."""
    beside = dashboard.instruments
    async with beside.changing:
        await asyncio.to_thread(
            beside.own.write,
            name,
            body.keys(),
            [channel.name for channel in body.channels],
            dashboard.catalog,
        )
        await beside.redefine(name)
    return await _all(dashboard, client)


@router.delete("/definitions/{name}", responses=errors(404, 409))
async def delete_definition(
    dashboard: TheDashboard, client: Controller, name: Named
) -> InstrumentsResponse:
    """Delete a definition of the user's own that no instrument has."""
    beside = dashboard.instruments
    async with beside.changing:
        used = next((it for it in beside.chosen if it.definition.name == name), None)
        if used is not None:
            raise Busy(problem=_IN_USE.filled(name=used.title))
        await asyncio.to_thread(beside.own.remove, name)
        beside.version += 1
    return await _all(dashboard, client)


@router.delete("/{title}", responses=errors(404, 409, 503))
async def remove_instrument(
    dashboard: TheDashboard, client: Controller, title: Title
) -> InstrumentsResponse:
    """Read that instrument no more; its values in a recording stay."""
    await dashboard.instruments.remove(title)
    return await _all(dashboard, client)


async def _all(dashboard: Dashboard, client: Client) -> InstrumentsResponse:
    return await asyncio.to_thread(instruments_of, dashboard, client)
