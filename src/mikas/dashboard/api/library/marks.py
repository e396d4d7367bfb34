"""Routes that mark moments of a recording afterwards: notes that are appended to its file.

One request marks one moment, or all that were found. What can't be written to is refused: a
recording in progress, here or in another program, a file that may only be read, a packed one, and
those of the virtual car, which are part of the program.
"""

from __future__ import annotations

from typing import Final

from fastapi import APIRouter
from pydantic import BaseModel, Field

from mikas.dashboard.api.dependencies import KnownClient, Line, TheRequester
from mikas.dashboard.api.errors import errors
from mikas.dashboard.errors import BadRequest, Busy
from mikas.dashboard.library.folder import RecordingFile
from mikas.i18n import Text
from mikas.recording.annotations.events import had_marker, note_of
from mikas.recording.annotations.fields import LONGEST_LINE
from mikas.recording.capture.notes import Kind
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.capture.writer import append_note
from mikas.sampling.events import Marker

router: Final = APIRouter(prefix="/api", tags=["recordings"])

_MOST = 200
_SLACK = 1.0  # s that a moment may lie outside of the first and last row
_GROWING = Text(
    "this recording is still being written; mark it live, or stop it first",
    "эта запись ещё идёт; ставьте отметки во время опроса или сначала остановите её",
)
_SHIPPED = Text(
    "this recording of the virtual car is a part of the program and can't be marked",
    "эта запись виртуальной машины — часть программы, отметить в ней ничего нельзя",
)
_OUTSIDE = Text(
    "there is a moment that the recording does not have", "такого момента в этой записи нет"
)


class NewMarker(BaseModel):
    """A moment of the recording, and its name."""

    time: float = Field(allow_inf_nan=False)
    label: Line = Field("", max_length=LONGEST_LINE)


class NewMarkers(BaseModel):
    """Moments of a recording."""

    markers: list[NewMarker] = Field(min_length=1, max_length=_MOST)


class MarkersResponse(BaseModel):
    """The markers as they stand in the file."""

    markers: list[NewMarker]


@router.post("/recordings/{identity}/markers", responses=errors(404, 409, 504))
async def mark_recording(
    requester: TheRequester, _: KnownClient, identity: str, body: NewMarkers
) -> MarkersResponse:
    """Mark moments of a recording: all, or none of them; notes are appended to its file.

    A moment that has a marker already gets the name.
    """
    library = requester.library

    def write(file: RecordingFile) -> MarkersResponse:
        if library.references.virtual(identity) is not None:
            raise Busy(problem=_SHIPPED)
        if library.is_growing(file):
            raise Busy(problem=_GROWING)
        span = library.opened(file).span
        for it in body.markers:
            if span is None or not span[0] - _SLACK <= it.time <= span[1] + _SLACK:
                raise BadRequest(problem=_OUTSIDE)
        known = list(CaptureReader(file.path).notes())
        markers = [
            Marker(it.time, it.label, renamed=had_marker(known, it.time)) for it in body.markers
        ]
        append_note(file.path, *map(note_of, markers))
        written = [it for it in CaptureReader(file.path).notes() if it.kind == Kind.MARKER]
        times = [it.time for it in written[-len(markers) :]]  # as they are read from here on
        return MarkersResponse(
            markers=[
                NewMarker(time=time, label=it.label)
                for time, it in zip(times, body.markers, strict=True)
            ]
        )

    return await requester.view(identity, write, virtual=True)
