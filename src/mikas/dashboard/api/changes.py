"""Routes of memory, and of changes: of the unit, of kept files; the write lock, the journal.

A change is made in two steps, shown, then confirmed. `POST /api/changes` reads the present content
and returns the effect of the change; `POST /api/changes/NONCE` makes the change, if the content is
still the same. Memory is read between two samples.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path as FilePath
from typing import Annotated, Any, Final, Literal

from fastapi import APIRouter, Path, Query
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.cancellation import check_cancelled
from mikas.cleaning import clean_json, is_in_calendar
from mikas.client import Ecu
from mikas.commands import WriteList
from mikas.dashboard.api.dependencies import Controller, TheDashboard, TheRequester
from mikas.dashboard.api.errors import TwoTexts, errors, made_of
from mikas.dashboard.api.state import State, state_of
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import NotConnected, api_hex
from mikas.dashboard.security import control
from mikas.dashboard.session.changes import recording_deletion
from mikas.files import open_regular

router: Final = APIRouter(prefix="/api")

Space = Literal["ram", "xram", "code", "sfr"]
NUMBER = r"^(0[xX][0-9A-Fa-f]{1,4}|[0-9]{1,5})$"
Address = Annotated[str, Query(pattern=NUMBER, description="0x1234 or 4660")]
_TAIL = 1 << 20  # bytes of the journal that are read
_ENTRIES = 200

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
    before: control.Content
    after: control.Content
    danger: bool
    lost: list[control.FaultShown | control.RecordingShown | control.DumpShown]
    meaning: TwoTexts | None


class ChangeResult(BaseModel):
    """The content before the change, and the content that was read back after it."""

    before: control.Content
    after: control.Content
    done: Literal[True] = True


@router.post("/changes", tags=["changes"], responses=errors(404, 409, 502, 503))
async def prepare(
    dashboard: TheDashboard, client: Controller, body: ChangeRequest
) -> ChangeProposal:
    """Read the present content and return the effect of the change; changes nothing."""
    change = await _prepared(dashboard, body)
    if change.needs_unlock:
        dashboard.write_lock.check(client)
    nonce = dashboard.confirmations.keep(client, change)
    return made_of(
        ChangeProposal, change, nonce=nonce, expires=dashboard.connection.date() + control.LIFETIME
    )


@router.post("/changes/{nonce}", tags=["changes"], responses=errors(409, 410, 502, 503))
async def confirm(
    dashboard: TheDashboard, client: Controller, nonce: Annotated[str, Path(max_length=64)]
) -> ChangeResult:
    """Make the change that was shown, once, if the content is still the same."""
    change = dashboard.confirmations.use(client, nonce)
    if change.needs_unlock:
        dashboard.write_lock.check(client)
    return ChangeResult(before=change.before, after=await change.make())


async def _prepared(dashboard: Dashboard, body: ChangeRequest) -> control.PendingChange:
    match body:
        case EraseFaultsRequest():
            return await dashboard.changes.erase_faults()
        case WriteParameterRequest():
            return await dashboard.writing.proposal(body.name, value=body.value, raw=body.raw)
        case WriteMemoryRequest():
            return await dashboard.changes.write_memory(
                body.space, body.address, bytes.fromhex(body.data)
            )
        case DeleteRecordingRequest():
            return await recording_deletion(dashboard.library, body.id)
        case DeleteDumpRequest():
            return await dashboard.dump_jobs.deletion(body.id)


class WritableParameter(BaseModel):
    """The value of a parameter, what can be written, and the value before the first write.

    `lowest`, `highest`, `step`: of its raw bytes; null: a flag, which is written as `raw`.
    """

    name: str
    now: control.ValueShown | None = Field(description="null: the unit does not give it")
    time: float
    lowest: float | None
    highest: float | None
    step: float | None
    start: control.ValueShown | None = Field(
        description="before the first write of this session; null: none was made"
    )
    start_time: float | None


@router.get("/parameters/{name}", tags=["changes"], responses=errors(409, 502, 503))
async def parameter(
    dashboard: TheDashboard, _: Controller, name: Annotated[str, Path(max_length=40)]
) -> WritableParameter:
    """Read a parameter, and return what can be written to it."""
    return made_of(WritableParameter, await dashboard.writing.look(name))


class MemoryResponse(BaseModel):
    """The content at `time`."""

    space: Space
    address: int
    data: str = Field(description="hex")
    time: float


class UnlockRequest(BaseModel):
    """The time until writing is locked again."""

    minutes: float = Field(5, gt=0, le=30)


class JournalEntry(BaseModel):
    """A line of the journal. `before`, `after`: hex; `outcome`: hex read back, or the failure."""

    time: float
    port: str | None = None
    model: str | None = None
    change: TwoTexts
    command: str | None = None
    safety: str | None = None
    before: str | None = None
    after: str | None = None
    state: Literal["started", "done", "failed", "interrupted"] | None = None
    outcome: str | None = None


class JournalResponse(BaseModel):
    """Changes, the newest first; each has two entries: `started`, and one with its outcome."""

    entries: list[JournalEntry]


@router.get("/memory/{space}", tags=["memory"], responses=errors(409, 502, 503))
async def memory(
    dashboard: TheDashboard,
    _: Controller,
    space: Space,
    address: Address,
    count: Annotated[int, Query(ge=1, le=1024)] = 256,
) -> MemoryResponse:
    """Read `count` bytes; of sfr one by one."""
    first = int(address, 0) if address.lower().startswith("0x") else int(address)

    def read(ecu: Ecu) -> tuple[bytes, float]:
        return ecu.memory[space].read_block(first, count), ecu.tester.link.now()

    data, time = await dashboard.connection.ask(read)
    time += dashboard.connection.later
    return MemoryResponse(space=space, address=first, data=api_hex(data) or "", time=time)


@router.post("/unlock", tags=["memory"], responses=errors(409, 503))
def unlock(dashboard: TheDashboard, client: Controller, body: UnlockRequest) -> State:
    """Unlock writing of memory and parameters for some minutes, on this connection."""
    if dashboard.connection.thread is None:
        raise NotConnected
    dashboard.write_lock.open(client, body.minutes * 60)
    return state_of(dashboard, client)


@router.post("/lock", tags=["memory"], responses=errors(409))
def lock(dashboard: TheDashboard, client: Controller) -> State:
    """Lock writing."""
    dashboard.write_lock.close()
    return state_of(dashboard, client)


@router.get("/journal", tags=["memory"], responses=errors(409, 504), response_model=JournalResponse)
async def journal(requester: TheRequester) -> Response:
    """Return the last 200 changes of units by this computer, without the lists to send (64).

    Lines of another form are left out: cut at the beginning of the tail, or edited by hand.
    """

    def work() -> Response:
        shown = _journal(requester.dashboard.settings.journal).model_dump_json(exclude_unset=True)
        return Response(shown, media_type="application/json")

    return await requester.compute(work)


def _journal(path: FilePath) -> JournalResponse:
    try:
        with open_regular(path) as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - _TAIL))
            lines = file.read(_TAIL).decode("utf-8", "replace").split("\n")
    except OSError:
        return JournalResponse(entries=[])
    entries: list[JournalEntry] = []
    for line in reversed(lines):
        check_cancelled()
        if len(entries) == _ENTRIES:
            break
        with suppress(ValueError, RecursionError):
            entry = clean_json(json.loads(line))
            if isinstance(entry, dict) and entry.get("command") != WriteList.SOURCE_NAME:
                entries.append(_entry(entry))
    return JournalResponse(entries=entries)


def _entry(stored: dict[str, Any]) -> JournalEntry:
    """Return a line of the journal. Raises `ValueError`; old lines have English texts only."""
    english = stored.get("change", "")
    both = {"en": english, "ru": stored.get("change_ru", english)}
    entry = JournalEntry.model_validate({**stored, "change": both})
    if not is_in_calendar(abs(entry.time)):
        raise ValueError("no date")
    return entry
