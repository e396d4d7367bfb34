"""Routes of the unit: stored faults, their freeze frames, passport, commands and measured limits.

Reading is done between two cycles. A client without control gets the result of the last reading.
A freeze frame holds the values around the moment at which a fault was stored.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, TypeVar

from fastapi import APIRouter
from pydantic import BaseModel, Field

from mikas.catalog import Catalog, Confidence, Fault
from mikas.cleaning import public_port
from mikas.client import Ecu, Info, Support
from mikas.commands.unit import version_text
from mikas.dashboard.api.dependencies import NO_CLIENT_ID, Controller, TheDashboard, Viewer
from mikas.dashboard.api.errors import OptionalTexts, TwoTexts, errors, made_of
from mikas.dashboard.api.messages import LiveRows
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import BadRequest, NotAllowed, NotController, NotFound
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.history import plain
from mikas.recording.freeze_frames import FreezeFrame, shown_first

T = TypeVar("T")

router: Final = APIRouter(prefix="/api", tags=["unit"])

_PROBE = 120.0  # s: each unanswered command takes one


class StoredFault(BaseModel):
    """A stored fault; the text of a fault that the catalog does not have is empty."""

    code: int
    text: TwoTexts
    confidence: Confidence
    certain: bool = Field(description="the text was confirmed on real units")
    informational: bool = Field(description="a message, not a fault")
    check: OptionalTexts
    related: list[str] = Field(description="related channels")
    sensor: list[str] = Field(
        description="those from the sensor whose circuit is faulty: perhaps substitute values"
    )
    first_seen: float
    frame: str | None = Field(
        description="the id of its freeze frame; null: there is none of this appearance"
    )


class FaultsResponse(BaseModel):
    """The stored faults, read at `time`."""

    time: float
    faults: list[StoredFault]
    count: int


class UnitLimits(BaseModel):
    """The measured limits of this unit, and the codes it refuses."""

    max_list: int
    max_block: dict[str, int]
    refused: list[int]


class UnitCommand(BaseModel):
    """A command; `supported` null: not tried, or uncertain. `reason`: why, where that can vary."""

    code: int
    name: str
    title: TwoTexts
    source_name: str
    supported: bool | None
    reason: OptionalTexts


class PassportResponse(BaseModel):
    """The identity of the unit, and its adapter."""

    model: TwoTexts
    version_code: str = Field(description="hex, as 0A")
    program_passport: list[str | None]
    data_passport: list[str | None]
    parameter_count: int | None
    adapter: str
    port: str
    echo: bool
    pause: float = Field(
        description="seconds kept between a response and the next request: as set, or as found"
    )
    baud: int
    latency_ms: int | None = Field(description="of the adapter's chip, if the system reports it")
    limits: UnitLimits
    method: str | None
    rates: dict[str, float]
    supported: list[UnitCommand] | None


@router.get("/faults", responses=errors(409, 502, 503))
async def faults(dashboard: TheDashboard, client: Viewer, *, last: bool = False) -> FaultsResponse:
    """Read the stored faults. Without control, or with `last`: as they were last read."""
    history = dashboard.fault_history
    stored = history.latest
    if not last:
        stored = await _latest(dashboard, client, stored, history.read)
    elif stored is None:
        raise dashboard.connection.not_connected()
    later = dashboard.connection.later
    shown = [
        fault_info(fault, stored.first_seen[fault.code] + later, _frame_of(dashboard, fault.code))
        for fault in stored.faults
    ]
    return FaultsResponse(time=stored.time + later, faults=shown, count=len(shown))


@router.get("/passport", responses=errors(409, 502, 503))
async def passport(dashboard: TheDashboard, client: Viewer) -> PassportResponse:
    """Read the passport. Without control: as it was last read."""

    def read(ecu: Ecu) -> Info:
        dashboard.info = info = ecu.info()
        return info

    return _passport_response(
        dashboard, await _latest(dashboard, client, dashboard.info, read), dashboard.supported
    )


@router.post("/passport/probe", responses=errors(409, 502, 503))
async def probe(dashboard: TheDashboard, _: Controller) -> PassportResponse:
    """Try every command once that changes nothing but the unit's list (64).

    Each unanswered one takes a second, each stream two.
    """

    def read(ecu: Ecu) -> tuple[Info, list[Support]]:
        dashboard.info, dashboard.supported = info, supported = ecu.info(), list(ecu.supported())
        return info, supported

    return _passport_response(dashboard, *await dashboard.connection.ask(read, seconds=_PROBE))


async def _latest(
    dashboard: Dashboard, client: Client, known: T | None, job: Callable[[Ecu], T]
) -> T:
    """Return the result of `job`; for a client without control `known`, the last result."""
    try:
        dashboard.control.demand(client, take=False)
        if not client.id:
            raise BadRequest(problem=NO_CLIENT_ID)
    except (BadRequest, NotAllowed, NotController):
        if known is None:
            raise
        return known
    return await dashboard.connection.ask(job)


def _frame_of(dashboard: Dashboard, code: int) -> str | None:
    """Return the latest freeze frame of a fault, unless the fault was absent since."""
    absent = dashboard.fault_history.absent_at(code) + dashboard.connection.later
    frames = dashboard.freeze_frames.frames
    return next((it.id for it in frames if it.code == code and it.seen > absent), None)


def fault_info(fault: Fault, first_seen: float, frame: str | None) -> StoredFault:
    """Return a stored fault as the catalog describes it."""
    return made_of(
        StoredFault,
        fault,
        certain=fault.confidence is Confidence.CONFIRMED,
        related=fault.parameters,
        first_seen=first_seen,
        frame=frame,
    )


def _passport_response(
    dashboard: Dashboard, info: Info, supported: list[Support] | None
) -> PassportResponse:
    thread = dashboard.connection.thread
    port = thread.url if thread else ""
    return made_of(
        PassportResponse,
        info,
        model=info.model.text,
        version_code=version_text(info.version_code),
        program_passport=info.passport.program,
        data_passport=info.passport.data,
        adapter=thread.adapter if thread else "",
        port=public_port(port),
        baud=thread.baud if thread else 9600,
        latency_ms=next((p.latency_ms for p in dashboard.settings.find() if p.url == port), None),
        method=dashboard.monitor.method,
        rates=dashboard.monitor.rates,
        supported=None
        if supported is None
        else [_command(it, _used(dashboard)) for it in supported],
    )


_USED_BY: dict[str, tuple[int, ...]] = {
    "single": (0x61,), "batch": (0x61,), "list": (0x64, 0x63), "stream": (0x71,),
    "stroke0": (0x7F,), "stroke1": (0x80,), "stroke2": (0x81,), "stroke3": (0x82,),
    "stroke4": (0x83,),
}  # fmt: skip


def _used(dashboard: Dashboard) -> frozenset[int]:
    """Return the first codes of the commands that values were read with."""
    methods = {name for name, rate in dashboard.monitor.rates.items() if rate > 0}
    if dashboard.session.samples and dashboard.monitor.method:
        methods.add(dashboard.monitor.method)
    return frozenset(code for name in methods for code in _USED_BY.get(name, ()))


def _command(support: Support, used: frozenset[int]) -> UnitCommand:
    supported = True if support.code in used else support.known
    return made_of(
        UnitCommand,
        support,
        name=support.command.__name__,
        source_name=support.command.SOURCE_NAME,
        supported=supported,
        reason=support.reason if supported is None else None,
    )


class FrameValue(BaseModel):
    """A channel's latest value at `seen`; lowest and highest between `without` and `seen`."""

    name: str
    value: float
    low: float
    high: float


class FreezeFrameInfo(BaseModel):
    """A fault that was not stored at `without` and was at `seen`, and the values of that moment."""

    id: str
    code: int
    without: float
    seen: float
    values: list[FrameValue]
    shown: list[str] = Field(description="the channels to show first, those of the fault in front")


class FreezeFramesResponse(BaseModel):
    """The latest first."""

    frames: list[FreezeFrameInfo]


class FreezeFrameRows(LiveRows):
    """The rows from five seconds before `without` to five seconds after `seen`."""

    id: str = Field(description="of the frame")


@router.get("/freeze-frames", responses=errors())
def freeze_frames(dashboard: TheDashboard, _: Viewer) -> FreezeFramesResponse:
    """Return the freeze frames of the connected unit, or of the last one."""
    frames = dashboard.freeze_frames.frames
    return FreezeFramesResponse(frames=[frame_info(it, dashboard.catalog) for it in frames])


@router.get("/freeze-frames/{identity}", responses=errors(404))
def freeze_frame(dashboard: TheDashboard, _: Viewer, identity: str) -> FreezeFrameRows:
    """Return the rows of one freeze frame."""
    for frame in dashboard.freeze_frames.frames:
        if frame.id == identity:
            values = [plain(column) for column in frame.values.values()]
            names, times = list(frame.values), list(frame.times)
            return FreezeFrameRows(id=identity, names=names, times=times, values=values)
    raise NotFound(name=identity)


@router.delete("/freeze-frames/{identity}", responses=errors(404, 409))
def delete_freeze_frame(
    dashboard: TheDashboard, client: Controller, identity: str
) -> FreezeFramesResponse:
    """Delete one freeze frame from this computer; the unit's fault stays."""
    if not dashboard.freeze_frames.delete(identity):
        raise NotFound(name=identity)
    return freeze_frames(dashboard, client)


def frame_info(frame: FreezeFrame, catalog: Catalog) -> FreezeFrameInfo:
    """Return the frame without its rows."""
    values = [made_of(FrameValue, it, name=name) for name, it in frame.then.items()]
    shown = shown_first(catalog.fault(frame.code), frame.then)
    return made_of(FreezeFrameInfo, frame, values=values, shown=shown)
