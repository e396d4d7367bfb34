"""The connection: ports, connecting, the plan and what it costs, who has control."""

from __future__ import annotations

import asyncio
from typing import Literal

from fastapi import APIRouter
from pydantic import BaseModel, Field

from mikas.catalog import Catalog
from mikas.client.polling import Method
from mikas.dashboard.api.dependencies import Asker, Controller, TheHub, Viewer
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.api.state import PlannedChannel, State, state_of
from mikas.dashboard.security.ports import TheReach
from mikas.dashboard.wishes import Wish

router = APIRouter(tags=["connection"])

_LONGEST_URL = 500


class PortInfo(BaseModel):
    """A serial port of this computer. `likely`: an adapter may be behind it."""

    url: str
    description: str
    chip: str
    likely: bool
    quirks: list[TwoTexts]


class PortsResponse(BaseModel):
    """The best guess first."""

    ports: list[PortInfo]


class ConnectRequest(BaseModel):
    """`port` null: the one likely adapter."""

    port: str | None = Field(None, max_length=_LONGEST_URL, examples=["/dev/ttyUSB0", "sim:"])
    echo: Literal["auto", "on", "off"] = "auto"
    method: Method = "auto"
    rate: float | None = Field(None, gt=0, le=1000)


class PlanRequest(BaseModel):
    """What to sample, derived channels among it."""

    wanted: list[PlannedChannel] = Field(min_length=1, max_length=200)
    method: Method = "auto"
    rate: float | None = Field(None, gt=0, le=1000)


class PriceRequest(BaseModel):
    """A plan to be priced; `method` auto: that in use."""

    wanted: list[PlannedChannel] = Field(min_length=1, max_length=200)
    method: Method = "auto"


class ChannelPrice(BaseModel):
    """What a channel would add to each set, and the rate with it."""

    seconds: float
    rate: float


class PriceResponse(BaseModel):
    """What a set costs on average; `more`: of every channel that is not in it yet."""

    bytes: float
    requests: float
    seconds: float
    rate: float
    more: dict[str, ChannelPrice]


class TakeControlRequest(BaseModel):
    """`force`: also from another."""

    force: bool = False


@router.get("/state", responses=errors())
def state(hub: TheHub, client: Viewer) -> State:
    """Everything at a glance."""
    hub.look()
    return state_of(hub, client)


@router.get("/ports", responses=errors())
def ports(hub: TheHub) -> PortsResponse:
    """The serial ports that the system sees."""
    return PortsResponse(
        ports=[
            PortInfo(
                url=port.url,
                description=port.description,
                chip=port.chip,
                likely=port.likely,
                quirks=[two(quirk) for quirk in port.quirks],
            )
            for port in hub.settings.find()
        ]
    )


@router.post("/connect", responses=errors(409, 503))
async def connect(hub: TheHub, client: Controller, reach: TheReach, wish: ConnectRequest) -> State:
    """Connects; how far it comes is told by the state."""
    await asyncio.to_thread(reach.check, wish.port)
    method = None if wish.method == "auto" else wish.method
    await hub.connect(wish.port, echo=wish.echo, method=method, rate=wish.rate)
    return state_of(hub, client)


@router.post("/disconnect", responses=errors(409))
async def disconnect(hub: TheHub, client: Controller) -> State:
    """Ends a recording and lets go of the port."""
    await hub.disconnect()
    return state_of(hub, client)


@router.put("/plan", responses=errors(409))
async def plan(hub: TheHub, client: Controller, wish: PlanRequest) -> State:
    """Samples these channels from now on."""
    await asyncio.to_thread(
        hub.planning.want, _wish(hub.catalog, wish.wanted, wish.method, wish.rate)
    )
    return state_of(hub, client)


@router.post("/plan/price", responses=errors())
def price(hub: TheHub, wish: PriceRequest) -> PriceResponse:
    """What a set of these would cost, and what one more would add."""
    names = _wish(hub.catalog, wish.wanted, wish.method, None)
    base = hub.planning.price(names.names, wish.method)
    more = {}
    for channel in hub.planning.channels:
        if channel not in names.every:
            with_it = hub.planning.price([*names.names, channel], wish.method)
            more[channel] = ChannelPrice(seconds=with_it.seconds - base.seconds, rate=with_it.rate)
    return PriceResponse(
        bytes=base.bytes,
        requests=base.requests,
        seconds=base.seconds,
        rate=base.rate,
        more=more,
    )


@router.post("/relearn", responses=errors(409, 503))
async def relearn(hub: TheHub, client: Controller) -> State:
    """Forgets what was learnt about this unit; it is measured anew."""
    hub.planning.relearn()
    return state_of(hub, client)


@router.post("/control/take", responses=errors(409))
def take(hub: TheHub, client: Asker, wish: TakeControlRequest) -> State:
    """Takes the controller's seat; with `force` also from another."""
    hub.seat.demand(client, force=wish.force)
    return state_of(hub, client)


@router.post("/control/release", responses=errors())
def release(hub: TheHub, client: Asker) -> State:
    """Lets go of the controller's seat."""
    hub.seat.release(client)
    return state_of(hub, client)


def _wish(
    catalog: Catalog, wanted: list[PlannedChannel], method: Method, rate: float | None
) -> Wish:
    every: dict[str, int] = {}
    for one in wanted:
        every.setdefault(catalog.channel(one.name).name, one.every)
    return Wish(every, None if method == "auto" else method, rate)
