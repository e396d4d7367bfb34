"""Routes of the connection: state, ports, connecting, the plan and its cost, control, diagnosis.

The connection lends the diagnosis its port. That is a task of its own: it ends after its last step,
when it is stopped, or when its client disconnects; the port is given back in each case. Its steps
are sent as each ends.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Annotated, Final, Literal

from fastapi import APIRouter
from fastapi.responses import Response, StreamingResponse
from pydantic import BaseModel, Field

from mikas.cancellation import check_cancelled
from mikas.catalog import Catalog
from mikas.cleaning import public_port
from mikas.client.doctor import Step
from mikas.client.parameters.polling import Method
from mikas.dashboard.api.dependencies import (
    Controller,
    KnownClient,
    TheDashboard,
    TheRequester,
    Viewer,
    port_named,
)
from mikas.dashboard.api.errors import OptionalTexts, TwoTexts, errors, made_of
from mikas.dashboard.api.state import PlannedChannel, State, state_of
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import ADVICE, Busy
from mikas.dashboard.session.connection import CHANGING
from mikas.dashboard.session.port_threads import Diagnosis
from mikas.dashboard.settings import PlanSettings
from mikas.errors import MikasError
from mikas.i18n import Text
from mikas.link.urls import parse
from mikas.tester.pauses import LONGEST_PAUSE

router: Final = APIRouter(prefix="/api", tags=["connection"])

_MAX_URL = 500
_NDJSON = "application/x-ndjson"
_LINE = {"$ref": "#/components/schemas/DiagnosisStep"}
_TITLES = {
    "port": Text("port", "порт"),
    "echo": Text("echo", "эхо"),
    "baud": Text("baud rate", "скорость"),
    "latency": Text("latency", "задержка"),
    "line": Text("line", "линия"),
    "ecu": Text("ECU", "блок"),
    "commands": Text("commands", "команды"),
    "unasked": Text("bytes unasked", "байты без запроса"),
    "other-baud": Text("01 at other baud rates", "01 на других скоростях"),
    "kwp2000-fast": Text("KWP2000, fast wake-up", "KWP2000, быстрое пробуждение"),
    "kwp2000-slow": Text("KWP2000, slow wake-up", "KWP2000, медленное пробуждение"),
}


class PortInfo(BaseModel):
    """A serial port of this computer. `likely`: probably an adapter."""

    url: str
    description: str
    chip: str
    likely: bool
    quirks: list[TwoTexts]


class PortsResponse(BaseModel):
    """The best guess first."""

    ports: list[PortInfo]


Pause = Annotated[float, Field(ge=0, le=LONGEST_PAUSE, allow_inf_nan=False)]


class ConnectRequest(BaseModel):
    """`port` null: the one likely adapter."""

    port: str | None = Field(None, max_length=_MAX_URL, examples=["/dev/ttyUSB0", "sim:"])
    echo: Literal["auto", "on", "off"] = "auto"
    pause: Pause | Literal["auto"] | None = Field(
        None,
        description="least seconds from a response to the next request; auto: found by trying; "
        "null: as the program was started, as a rule auto",
    )
    method: Method = "auto"
    rate: float | None = Field(None, gt=0, le=1000)


class PriceRequest(BaseModel):
    """The channels of the cost; `first`: those that come first; `method` auto: that in use."""

    first: list[Annotated[str, Field(max_length=40)]] = Field([], max_length=200)
    wanted: list[PlannedChannel] = Field(min_length=1, max_length=200)
    method: Method = "auto"


class PlanRequest(BaseModel):
    """The channels to sample, also derived ones; `method` auto: the fastest."""

    wanted: list[PlannedChannel] = Field(min_length=1, max_length=200)
    method: Method = "auto"
    rate: float | None = Field(None, gt=0, le=1000)


class PriorityRequest(BaseModel):
    """The channels that come first; none: all are equal."""

    names: list[Annotated[str, Field(max_length=40)]] = Field(max_length=200)


class ChannelPrice(BaseModel):
    """The time that a channel adds to each cycle, and the rate with it."""

    seconds: float
    rate: float


class PriceResponse(BaseModel):
    """The average cost of a cycle; `more`: of every other channel, or with `first`, of every
    channel that does not come first, if it did.
    """

    bytes: float
    requests: float
    seconds: float
    rate: float
    more: dict[str, ChannelPrice]


class TakeControlRequest(BaseModel):
    """`force`: also from another client."""

    force: bool = False


@router.get("/state", responses=errors())
def state(dashboard: TheDashboard, client: Viewer) -> State:
    """Return the state of everything."""
    dashboard.refresh()
    return state_of(dashboard, client)


@router.get("/ports", responses=errors())
def ports(dashboard: TheDashboard) -> PortsResponse:
    """Return the serial ports of this computer."""
    return PortsResponse(ports=[made_of(PortInfo, port) for port in dashboard.settings.find()])


@router.post("/connect", responses=errors(409, 503))
async def connect(dashboard: TheDashboard, client: Controller, body: ConnectRequest) -> State:
    """Connect; the state shows the progress."""
    port = await port_named(dashboard, client, body.port)
    await dashboard.connect(
        port, echo=body.echo, pause=body.pause, method=body.method, rate=body.rate
    )
    return state_of(dashboard, client)


@router.post("/disconnect", responses=errors(409))
async def disconnect(dashboard: TheDashboard, client: Controller) -> State:
    """End a recording and close the port."""
    await dashboard.disconnect()
    return state_of(dashboard, client)


@router.put("/plan", responses=errors(409))
async def plan(dashboard: TheDashboard, client: Controller, body: PlanRequest) -> State:
    """Sample these channels from now on."""
    await asyncio.to_thread(dashboard.plan.sample, _settings(dashboard.catalog, body, body.rate))
    return state_of(dashboard, client)


@router.put("/plan/first", responses=errors(409))
def first(dashboard: TheDashboard, client: Controller, body: PriorityRequest) -> State:
    """Let these channels come first where each one costs time; the others are read in every fifth
    cycle there. A stream or a list reads all in one response, and goes on unchanged.
    """
    beside = {channel.name for channel in dashboard.instruments.channels}
    dashboard.plan.prefer([name for name in body.names if name not in beside])
    return state_of(dashboard, client)


@router.post("/plan/price", responses=errors(409, 504), response_model=PriceResponse)
async def price(requester: TheRequester, body: PriceRequest) -> Response:
    """Return the cost of a cycle of these channels, and of each further channel."""
    return await requester.answer(lambda: _price(requester.dashboard, body))


def _price(dashboard: Dashboard, body: PriceRequest) -> PriceResponse:
    catalog = dashboard.catalog
    names, first = _settings(catalog, body).names, body.first
    base = dashboard.plan.price(names, body.method, first)
    known = set(first or (wanted.name for wanted in body.wanted))
    more: dict[str, ChannelPrice] = {}
    alike: dict[object, ChannelPrice] = {}  # channels that need the same cost the same
    for channel in catalog.channels:
        if channel in known:
            continue
        needs = catalog.required_by([channel]), channel in catalog.derived
        if needs not in alike:
            check_cancelled()
            longer = ([*names, channel], first) if not first else (names, [*first, channel])
            with_it = dashboard.plan.price(longer[0], body.method, longer[1])
            seconds = with_it.seconds - base.seconds
            alike[needs] = made_of(ChannelPrice, with_it, seconds=seconds)
        more[channel] = alike[needs]
    return made_of(PriceResponse, base, more=more)


@router.post("/relearn", responses=errors(409, 503))
async def relearn(dashboard: TheDashboard, client: Controller) -> State:
    """Forget the measured speeds and limits of this unit; they are measured again."""
    dashboard.plan.relearn()
    return state_of(dashboard, client)


@router.post("/control/take", responses=errors(409))
def take(dashboard: TheDashboard, client: KnownClient, body: TakeControlRequest) -> State:
    """Take the control lease; with `force` also from another client."""
    dashboard.control.demand(client, force=body.force)
    return state_of(dashboard, client)


@router.post("/control/release", responses=errors())
def release(dashboard: TheDashboard, client: KnownClient) -> State:
    """Release the control lease."""
    dashboard.control.release(client)
    return state_of(dashboard, client)


def _settings(
    catalog: Catalog, body: PriceRequest | PlanRequest, rate: float | None = None
) -> PlanSettings:
    every: dict[str, int] = {}
    for channel in body.wanted:
        every.setdefault(catalog.channel(channel.name).name, channel.every)
    return PlanSettings(every, body.method, rate)


class DiagnosisRequest(BaseModel):
    """`port` null: that of the connection, or the one likely adapter."""

    port: str | None = Field(None, max_length=500)
    other_units: bool = Field(
        default=False, description="where no Mikas answers, look for another kind of unit"
    )


class DiagnosisStep(BaseModel):
    """One line of the response. `ok` null: not known, or could be better."""

    name: str
    port: str = Field(description="the URL that is checked")
    title: TwoTexts
    ok: bool | None
    detail: TwoTexts
    to_try: OptionalTexts
    code: str | None = Field(description="the class of the error: NoEcho…")


@router.post(
    "/doctor",
    response_class=StreamingResponse,
    responses={**errors(409, 503), 200: {"content": {_NDJSON: {"schema": _LINE}}}},
)
async def doctor(
    dashboard: TheDashboard, client: Controller, body: DiagnosisRequest
) -> StreamingResponse:
    """Run the diagnosis; the response has a line of JSON (`DiagnosisStep`) for each step."""
    port = await port_named(dashboard, client, body.port)
    port = port or (dashboard.connection.port.url if dashboard.connection.port else None)
    if port is None:
        port = await asyncio.to_thread(dashboard.connection.likely)
    parse(port)
    dashboard.connection.check_unchanged()
    if dashboard.diagnosis is not None or dashboard.surveys.runs:
        raise Busy(problem=CHANGING)
    steps: asyncio.Queue[DiagnosisStep | None] = asyncio.Queue()
    reached = dashboard.connection.settings_of(port)
    diagnosis = Diagnosis(reached, dashboard.settings, other_units=body.other_units)
    dashboard.diagnosis = diagnosis
    diagnosis.task = asyncio.create_task(_run(dashboard, diagnosis, steps))

    async def lines() -> AsyncIterator[str]:
        try:
            while (step := await steps.get()) is not None:
                yield step.model_dump_json() + "\n"
        finally:  # not awaited: this may be a cancelled task
            asyncio.get_running_loop().run_in_executor(None, diagnosis.stop)

    return StreamingResponse(lines(), media_type=_NDJSON)


@router.post("/doctor/stop", responses=errors(409))
async def stop(dashboard: TheDashboard, client: Controller) -> State:
    """Stop the diagnosis, if there is one; responds when its port is closed."""
    if dashboard.diagnosis is not None:
        await dashboard.diagnosis.stop_and_wait()
    return state_of(dashboard, client)


async def _run(
    dashboard: Dashboard, diagnosis: Diagnosis, steps: asyncio.Queue[DiagnosisStep | None]
) -> None:
    loop = asyncio.get_running_loop()

    def report(step: Step) -> None:
        loop.call_soon_threadsafe(steps.put_nowait, _line(diagnosis.url, step))

    try:
        async with dashboard.connection.lent():
            await asyncio.to_thread(diagnosis.run, report)
    except MikasError as error:
        steps.put_nowait(_line(diagnosis.url, Step("port", False, error.text, error)))
    finally:
        dashboard.diagnosis = None
        steps.put_nowait(None)


def _line(port: str, step: Step) -> DiagnosisStep:
    advice, to_try = Text("", ""), None
    if step.error is not None:
        advice, to_try = step.error.advice, ADVICE.advice(step.error)
    pairs = zip(step.detail, advice, strict=True)
    found = Text(*(detail.removesuffix(shown).strip() for detail, shown in pairs))
    code = type(step.error).__name__ if step.error else None
    shown = {"title": _TITLES[step.name], "detail": found, "to_try": to_try}
    return made_of(DiagnosisStep, step, port=public_port(port), code=code, **shown)
