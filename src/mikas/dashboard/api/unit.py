"""What the unit says of itself: stored faults, passports, what it knows and was found to take.

Reading is done between two cycles. Who does not hold the seat is given what was last read.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from fastapi import APIRouter
from pydantic import BaseModel, Field

from mikas.catalog import Confidence, Fault
from mikas.client import Ecu, Info, Support
from mikas.dashboard.api.dependencies import WHO, Controller, TheHub, Viewer
from mikas.dashboard.api.errors import TwoTexts, errors, two, two_or_none
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.errors import BadRequest, NotAllowed, NotController
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.fault_history import StoredFaults

T = TypeVar("T")

router = APIRouter(tags=["unit"])

_PROBE = 120.0  # s: a second for each command that is left unanswered


class StoredFault(BaseModel):
    """A stored fault; one with an empty text is not known to the catalog."""

    code: int
    text: TwoTexts
    confidence: Confidence
    certain: bool = Field(description="the text was confirmed on real units")
    informational: bool = Field(description="a message, not a fault")
    check: TwoTexts | None
    related: list[str] = Field(description="channels that bear on it")
    first_seen: float


class FaultsResponse(BaseModel):
    """As read at `time`."""

    time: float
    faults: list[StoredFault]
    count: int


class UnitLimits(BaseModel):
    """What this unit was found to take and to lack."""

    max_list: int
    max_block: dict[str, int]
    refused: list[int]


class UnitCommand(BaseModel):
    """A command; `supported` null: not tried, or no telling."""

    code: int
    name: str
    title: TwoTexts
    source_name: str
    supported: bool | None


class PassportResponse(BaseModel):
    """Who the unit is, and through what it is asked."""

    model: TwoTexts
    version_code: int
    program_passport: list[str | None]
    data_passport: list[str | None]
    parameter_count: int | None
    adapter: str
    port: str
    echo: bool
    baud: int
    latency_ms: int | None = Field(description="of the adapter's chip, where the system tells")
    limits: UnitLimits
    method: str | None
    rates: dict[str, float]
    supported: list[UnitCommand] | None


@router.get("/faults", responses=errors(409, 502, 503))
async def faults(hub: TheHub, client: Viewer) -> FaultsResponse:
    """Reads the stored faults. Without control: as they were last read."""
    return faults_answer(await _latest(hub, client, hub.fault_history.latest, hub.read_faults))


@router.get("/passport", responses=errors(409, 502, 503))
async def passport(hub: TheHub, client: Viewer) -> PassportResponse:
    """Who the unit is. Without control: as it was last read."""

    def read(ecu: Ecu) -> Info:
        hub.info = info = ecu.info()
        return info

    return _passport_answer(hub, await _latest(hub, client, hub.info, read), hub.supported)


@router.post("/passport/probe", responses=errors(409, 502, 503))
async def probe(hub: TheHub, _: Controller) -> PassportResponse:
    """Tries every harmless command once; a second for each that is left unanswered."""

    def read(ecu: Ecu) -> tuple[Info, list[Support]]:
        hub.info, hub.supported = info, supported = ecu.info(), list(ecu.supported())
        return info, supported

    return _passport_answer(hub, *await hub.ask(read, seconds=_PROBE))


async def _latest(hub: Hub, client: Client, known: T | None, job: Callable[[Ecu], T]) -> T:
    """What `job` reads now; `known`, what was last read, for a client that may not ask."""
    try:
        hub.seat.demand(client, take=False)
        if not client.id:
            raise BadRequest(problem=WHO)
    except (BadRequest, NotAllowed, NotController):
        if known is None:
            raise
        return known
    return await hub.ask(job)


def faults_answer(stored: StoredFaults) -> FaultsResponse:
    """As the API tells them."""
    return FaultsResponse(
        time=stored.time,
        faults=[fault_of(fault, stored.first_seen[fault.code]) for fault in stored.faults],
        count=len(stored.faults),
    )


def fault_of(fault: Fault, first_seen: float) -> StoredFault:
    """As the API tells it."""
    return StoredFault(
        code=fault.code,
        text=two(fault.text),
        confidence=fault.confidence,
        certain=fault.confidence is Confidence.CONFIRMED,
        informational=fault.informational,
        check=two_or_none(fault.check),
        related=list(fault.parameters),
        first_seen=first_seen,
    )


def _passport_answer(hub: Hub, info: Info, supported: list[Support] | None) -> PassportResponse:
    session = hub.session
    port = session.url if session else ""
    return PassportResponse(
        model=two(info.model.text),
        version_code=info.version_code,
        program_passport=list(info.passport.program),
        data_passport=list(info.passport.data),
        parameter_count=info.parameter_count,
        adapter=session.adapter if session else "",
        port=port,
        echo=info.echo,
        baud=session.baud if session else 9600,
        latency_ms=next((p.latency_ms for p in hub.settings.find() if p.url == port), None),
        limits=UnitLimits(
            max_list=info.limits.max_list,
            max_block=dict(info.limits.max_block),
            refused=list(info.limits.refused),
        ),
        method=hub.monitor.method,
        rates=hub.monitor.rates,
        supported=None if supported is None else [_command(it, _used(hub)) for it in supported],
    )


_USED_BY: dict[str, tuple[int, ...]] = {
    "single": (0x61,), "batch": (0x61,), "list": (0x64, 0x63), "stream": (0x71,),
}  # fmt: skip


def _used(hub: Hub) -> frozenset[int]:
    """The first codes of the commands that values were read with."""
    methods = {name for name, rate in hub.monitor.rates.items() if rate > 0}
    if hub.monitor.meters.samples and hub.monitor.method:
        methods.add(hub.monitor.method)
    return frozenset(code for name in methods for code in _USED_BY.get(name, ()))


def _command(support: Support, used: frozenset[int]) -> UnitCommand:
    command: Any = support.command
    return UnitCommand(
        code=command.CODES[0],
        name=command.__name__,
        title=two(command.TITLE),
        source_name=command.SOURCE_NAME,
        supported=True if command.CODES[0] in used else support.known,
    )
