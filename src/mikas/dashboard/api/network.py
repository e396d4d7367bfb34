"""The routes for this computer only: the switch for the network, and the end of the program."""

from __future__ import annotations

import asyncio
from typing import Final

from fastapi import APIRouter, Request
from pydantic import BaseModel, Field

from mikas.dashboard.api.catalog import AboutResponse, about_of
from mikas.dashboard.api.dependencies import LocalClient, TheDashboard
from mikas.dashboard.api.errors import errors
from mikas.dashboard.program import Ending, Sharing

router: Final = APIRouter(prefix="/api", tags=["about"])


class NetworkRequest(BaseModel):
    """`control`: clients in the network may control; else they may only view."""

    on: bool
    control: bool = Field(False)


@router.put("/network", responses=errors(409))
async def network(
    request: Request, dashboard: TheDashboard, client: LocalClient, body: NetworkRequest
) -> AboutResponse:
    """Open the dashboard to the network with a new token, or close it and end the token.

    For clients on this computer only. 409 with the reason: no network, a port that is taken.
    """
    sharing: Sharing = request.app.state.sharing
    if body.on:
        await sharing.open(control=body.control)
    else:
        await sharing.close()
    return await asyncio.to_thread(about_of, request, dashboard, client)


@router.post("/end", responses=errors(409))
async def end(request: Request, dashboard: TheDashboard, client: LocalClient) -> AboutResponse:
    """End a program that an icon has started; the recording in progress is closed and kept.

    For clients on this computer only. 409: the program was started in a terminal.
    """
    ending: Ending = request.app.state.ending
    ending.end_program()
    return await asyncio.to_thread(about_of, request, dashboard, client)
