"""The API's side of recording the running connection."""

from __future__ import annotations

from fastapi import APIRouter
from pydantic import BaseModel, Field

from mikas.dashboard.api.dependencies import Controller, TheDashboard
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
async def start(dashboard: TheDashboard, client: Controller, body: StartRecordingRequest) -> State:
    """Records everything on the wire to a new file from here on."""
    await dashboard.recorder.start(body.name)
    return state_of(dashboard, client)


@router.post("/stop", responses=errors(409))
def stop(dashboard: TheDashboard, client: Controller) -> State:
    """Ends the recording."""
    dashboard.recorder.stop()
    return state_of(dashboard, client)


@router.post("/marker", responses=errors(409))
def marker(dashboard: TheDashboard, _: Controller, body: MarkerRequest) -> MarkerResponse:
    """Marks this moment."""
    return MarkerResponse(time=dashboard.recorder.marker(body.label))


@router.post("/note", responses=errors(409))
def note(dashboard: TheDashboard, _: Controller, body: NoteRequest) -> NoteResponse:
    """Words into the recording that is being made."""
    dashboard.recorder.note(body.text)
    return NoteResponse(kept=True)
