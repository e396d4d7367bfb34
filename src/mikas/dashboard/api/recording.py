"""The API's side of recording the running connection."""

from __future__ import annotations

from fastapi import APIRouter
from pydantic import BaseModel, Field

from mikas.dashboard.api.dependencies import Controller, TheHub
from mikas.dashboard.api.errors import errors
from mikas.dashboard.api.state import State, state_of

router = APIRouter(prefix="/recording", tags=["recording"])


class StartRecordingRequest(BaseModel):
    """`name` null: the date and time."""

    name: str | None = Field(None, max_length=200)


class MarkerRequest(BaseModel):
    """What the moment is to be called."""

    label: str = Field("", max_length=1000)


class MarkerResponse(BaseModel):
    """When it was."""

    time: float


class NoteRequest(BaseModel):
    """A person's words."""

    text: str = Field(max_length=100_000)


class NoteResponse(BaseModel):
    """It is in the recording."""

    kept: bool


@router.post("/start", responses=errors(409, 503))
async def start(hub: TheHub, client: Controller, wish: StartRecordingRequest) -> State:
    """Records everything on the wire to a new file from here on."""
    await hub.recording.start(wish.name)
    return state_of(hub, client)


@router.post("/stop", responses=errors(409))
def stop(hub: TheHub, client: Controller) -> State:
    """Ends the recording."""
    hub.recording.stop()
    return state_of(hub, client)


@router.post("/marker", responses=errors(409))
def marker(hub: TheHub, _: Controller, wish: MarkerRequest) -> MarkerResponse:
    """Marks this moment."""
    return MarkerResponse(time=hub.recording.marker(wish.label))


@router.post("/note", responses=errors(409))
def note(hub: TheHub, _: Controller, wish: NoteRequest) -> NoteResponse:
    """Words into the recording that is being made."""
    hub.recording.note(wish.text)
    return NoteResponse(kept=True)
