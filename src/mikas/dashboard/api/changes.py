"""Changes of the unit, and of what is kept of it, in two steps: shown, then confirmed.

`POST /api/changes` reads what is there and says what would become of it; `POST /api/changes/NONCE`
does it, if that still stands.
"""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Path
from pydantic import BaseModel

from mikas.dashboard.api.dependencies import Controller, TheHub
from mikas.dashboard.api.errors import TwoTexts, errors, two, two_or_none
from mikas.dashboard.changes_wishes import (
    ChangeRequest,
    DeleteDump,
    DeleteRecording,
    EraseFaults,
    WriteMemory,
    WriteParameter,
)
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.dumps_delete import prepared_delete_of_dump
from mikas.dashboard.errors import Locked
from mikas.dashboard.library.deletion import prepared_delete
from mikas.dashboard.security.confirmations import LIFETIME, Prepared
from mikas.dashboard.session.changes import erase, write_memory, write_parameter

router = APIRouter(tags=["changes"])


class FaultShown(BaseModel):
    """A stored fault that would be erased."""

    code: int
    en: str
    ru: str


class ValueShown(BaseModel):
    """A parameter's value. `raw`: hex."""

    value: bool | int | float
    unit: str
    raw: str


class RecordingShown(BaseModel):
    """A recording that would be deleted."""

    id: str
    bytes: int


class DumpShown(BaseModel):
    """A dump that would be deleted."""

    id: str
    file: str
    done: int
    total: int


Content = list[int] | ValueShown | RecordingShown | DumpShown | str | None
"""Of faults: their codes. Of memory: hex. null: not readable, or deleted."""


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
async def ask(hub: TheHub, client: Controller, wish: ChangeRequest) -> ChangeProposal:
    """Reads what is there and says what would become of it; changes nothing."""
    prepared = await _prepared(hub, wish)
    _check_lock(hub, prepared)
    nonce = hub.nonces.keep(client, prepared)
    return ChangeProposal(
        nonce=nonce,
        expires=hub.now() + LIFETIME,
        what=two(prepared.what),
        before=prepared.before,
        after=prepared.after,
        danger=prepared.danger,
        lost=list(prepared.lost),
        meaning=two_or_none(prepared.meaning),
    )


@router.post("/changes/{nonce}", responses=errors(409, 410, 502, 503))
async def confirm(
    hub: TheHub, client: Controller, nonce: Annotated[str, Path(max_length=64)]
) -> ChangeResult:
    """Does what was shown, if it still stands; once."""
    prepared = hub.nonces.use(client, nonce)
    _check_lock(hub, prepared)
    return ChangeResult(**await prepared.make())


async def _prepared(hub: Hub, wish: ChangeRequest) -> Prepared:
    match wish:
        case EraseFaults():
            return await erase(hub)
        case WriteParameter():
            return await write_parameter(hub, wish)
        case WriteMemory():
            return await write_memory(hub, wish)
        case DeleteRecording():
            return await prepared_delete(hub, wish.id)
        case DeleteDump():
            return prepared_delete_of_dump(hub, wish.id)


def _check_lock(hub: Hub, prepared: Prepared) -> None:
    if prepared.needs_unlock and hub.lock.left is None:
        raise Locked
