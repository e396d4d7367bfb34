"""Routes of memory: reading the four spaces between two samples, the write lock, the journal."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query
from pydantic import BaseModel, Field

from mikas.cleaning import clean_json, is_in_calendar
from mikas.client import Ecu
from mikas.commands import WriteList
from mikas.dashboard.api.dependencies import Controller, TheDashboard
from mikas.dashboard.api.errors import TwoTexts, errors
from mikas.dashboard.api.state import State, state_of
from mikas.dashboard.errors import NotConnected, api_hex
from mikas.files import open_regular

router = APIRouter(tags=["memory"])

Space = Literal["ram", "xram", "code", "sfr"]
NUMBER = r"^(0[xX][0-9A-Fa-f]{1,4}|[0-9]{1,5})$"
Address = Annotated[str, Query(pattern=NUMBER, description="0x1234 or 4660")]
_TAIL = 1 << 20  # bytes of the journal that are read
_ENTRIES = 200


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


@router.get("/memory/{space}", responses=errors(409, 502, 503))
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
    return MemoryResponse(space=space, address=first, data=api_hex(data) or "", time=time)


@router.post("/unlock", responses=errors(409, 503))
def unlock(dashboard: TheDashboard, client: Controller, body: UnlockRequest) -> State:
    """Unlock writing of memory and parameters for some minutes, on this connection."""
    if dashboard.connection.thread is None:
        raise NotConnected
    dashboard.write_lock.open(client, body.minutes * 60)
    return state_of(dashboard, client)


@router.post("/lock", responses=errors(409))
def lock(dashboard: TheDashboard, client: Controller) -> State:
    """Lock writing."""
    dashboard.write_lock.close()
    return state_of(dashboard, client)


@router.get("/journal", responses=errors(), response_model_exclude_unset=True)
def journal(dashboard: TheDashboard) -> JournalResponse:
    """Return the last 200 changes of units by this computer, without the lists to send (64).

    Lines of another form are left out: cut at the beginning of the tail, or edited by hand.
    """
    try:
        with open_regular(dashboard.settings.journal) as file:
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - _TAIL))
            lines = file.read(_TAIL).decode("utf-8", "replace").split("\n")
    except OSError:
        return JournalResponse(entries=[])
    entries: list[JournalEntry] = []
    for line in reversed(lines):
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
