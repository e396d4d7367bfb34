"""Changes of the unit and deletions of files, in two steps: shown, then confirmed.

`POST /api/changes` reads the present content and returns the effect of the change;
`POST /api/changes/NONCE` makes the change, if the content is still the same.
"""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Path
from pydantic import BaseModel, Field

from mikas.dashboard.api.dependencies import Controller, TheDashboard
from mikas.dashboard.api.errors import TwoTexts, errors, made_of
from mikas.dashboard.api.memory import Space
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.security.confirmations import (
    LIFETIME,
    Content,
    DumpShown,
    FaultShown,
    PendingChange,
    RecordingShown,
)
from mikas.dashboard.security.control import Client
from mikas.dashboard.session.changes import recording_deletion

router = APIRouter(tags=["changes"])


_MAX_WRITE = 256
Hex = Annotated[str, Field(pattern=r"^([0-9A-Fa-f]{2})+$", max_length=2 * _MAX_WRITE)]


class EraseFaultsRequest(BaseModel):
    """Erase the stored faults."""

    kind: Literal["erase_faults"]


class WriteParameterRequest(BaseModel):
    """Write a physical `value`, or the `raw` bytes, low byte first."""

    kind: Literal["write_parameter"]
    name: str = Field(max_length=40)
    value: float | None = Field(None, allow_inf_nan=False)
    raw: Hex | None = None


class WriteMemoryRequest(BaseModel):
    """Write bytes, beginning at an address."""

    kind: Literal["write_memory"]
    space: Space
    address: int = Field(ge=0, le=0xFFFF)
    data: Hex


class DeleteRecordingRequest(BaseModel):
    """Delete a recording's file."""

    kind: Literal["delete_recording"]
    id: str = Field(max_length=255)


class DeleteDumpRequest(BaseModel):
    """Delete a dump: its file and its manifest."""

    kind: Literal["delete_dump"]
    id: str = Field(max_length=240)


ChangeRequest = Annotated[
    EraseFaultsRequest
    | WriteParameterRequest
    | WriteMemoryRequest
    | DeleteRecordingRequest
    | DeleteDumpRequest,
    Field(discriminator="kind"),
]


class ChangeProposal(BaseModel):
    """The effect of a change, to be shown to a person, who then confirms it by the nonce."""

    nonce: str
    expires: float
    what: TwoTexts
    before: Content
    after: Content
    danger: bool
    lost: list[FaultShown | RecordingShown | DumpShown]
    meaning: TwoTexts | None


class ChangeResult(BaseModel):
    """The content before the change, and the content that was read back after it."""

    before: Content
    after: Content
    done: Literal[True] = True


@router.post("/changes", responses=errors(404, 409, 502, 503))
async def prepare(
    dashboard: TheDashboard, client: Controller, body: ChangeRequest
) -> ChangeProposal:
    """Read the present content and return the effect of the change; changes nothing."""
    change = await _prepared(dashboard, body)
    _check_lock(dashboard, client, change)
    nonce = dashboard.confirmations.keep(client, change)
    return made_of(
        ChangeProposal, change, nonce=nonce, expires=dashboard.connection.now() + LIFETIME
    )


@router.post("/changes/{nonce}", responses=errors(409, 410, 502, 503))
async def confirm(
    dashboard: TheDashboard, client: Controller, nonce: Annotated[str, Path(max_length=64)]
) -> ChangeResult:
    """Make the change that was shown, once, if the content is still the same."""
    change = dashboard.confirmations.use(client, nonce)
    _check_lock(dashboard, client, change)
    return ChangeResult(before=change.before, after=await change.make())


async def _prepared(dashboard: Dashboard, body: ChangeRequest) -> PendingChange:
    match body:
        case EraseFaultsRequest():
            return await dashboard.changes.erase_faults()
        case WriteParameterRequest():
            return await dashboard.changes.write_parameter(
                body.name, value=body.value, raw=body.raw
            )
        case WriteMemoryRequest():
            return await dashboard.changes.write_memory(
                body.space, body.address, bytes.fromhex(body.data)
            )
        case DeleteRecordingRequest():
            return await recording_deletion(dashboard.library, body.id)
        case DeleteDumpRequest():
            return await dashboard.dump_jobs.deletion(body.id)


def _check_lock(dashboard: Dashboard, client: Client, change: PendingChange) -> None:
    if change.needs_unlock:
        dashboard.write_lock.check(client)
