"""The route of the faults in a recording, with their freeze frames.

The rows around a frame's moment are those of `GET /recordings/ID/rows`.
"""

from __future__ import annotations

from math import inf

from fastapi import APIRouter
from pydantic import BaseModel, Field

from mikas.catalog import Catalog
from mikas.dashboard.api.dependencies import TheRequester
from mikas.dashboard.api.errors import errors
from mikas.dashboard.api.freeze_frames import FreezeFrameInfo, frame_info
from mikas.dashboard.api.unit import StoredFault, fault_info
from mikas.dashboard.library.folder import RecordingFile
from mikas.recording.capture.notes import Kind
from mikas.recording.freeze_frames import first_seen
from mikas.recording.recorded_faults import RecordedFaults, faults_in
from mikas.recording.recording import Recording

router = APIRouter(tags=["recordings"])


class RecordedFault(StoredFault):
    """A fault that was stored at the last reading; `first_seen` is the time of a reading."""

    stored_before: bool = Field(description="a reading before the recording, or its first, had it")


class RecordedFaultsResponse(BaseModel):
    """The faults of a recording's last session at the last reading; null: they were not read.

    `frames`: of all faults that appeared, the latest first, at most thirty.
    """

    time: float | None
    faults: list[RecordedFault] | None
    frames: list[FreezeFrameInfo]


@router.get("/recordings/{identity}/faults", responses=errors(404, 409, 504))
async def recorded_faults(requester: TheRequester, identity: str) -> RecordedFaultsResponse:
    """Return the faults in a recording, and the values of the moments at which they appeared."""

    def look(file: RecordingFile) -> RecordedFaultsResponse:
        recording = requester.library.opened(file)
        return _response(faults_in(recording), recording)

    return await requester.view(identity, look, virtual=True)


def _response(found: RecordedFaults, recording: Recording) -> RecordedFaultsResponse:
    catalog = recording.catalog
    began = max((note.time for note in recording.notes if note.kind == Kind.FAULTS), default=-inf)
    frames = [each.frame for each in found.appeared if each.frame is not None]
    last = found.readings[-1] if found.readings else None
    return RecordedFaultsResponse(
        time=last.time if last else None,
        faults=[_fault(code, found, catalog, began) for code in dict.fromkeys(last.codes)]
        if last
        else None,
        frames=[frame_info(frame, catalog) for frame in frames],
    )


def _fault(code: int, found: RecordedFaults, catalog: Catalog, began: float) -> RecordedFault:
    first = first_seen(code, found.readings)
    appeared = next((each for each in found.appeared if each.code == code), None)
    frame = appeared.frame if appeared and appeared.read == first else None
    return RecordedFault(
        **fault_info(catalog.fault(code), first, frame.id if frame else None).model_dump(),
        stored_before=first <= max(began, found.readings[0].time),
    )
