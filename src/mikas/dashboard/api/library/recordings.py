"""Routes of recordings: start and stop one, the list, one recording, its rows, comment, markers.

The id of a recording is the name of its file in the folder; no other file is accessible. Files are
read in the lane of views: a report or an export that takes long holds up none of these.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Any, Final

from fastapi import APIRouter, Query
from fastapi.responses import JSONResponse, Response
from pydantic import BaseModel, Field

from mikas.catalog import InstrumentChannel
from mikas.dashboard.api.channel_info import ChannelInfo, instrument_channel_info
from mikas.dashboard.api.dependencies import (
    Controller,
    KnownClient,
    Line,
    Names,
    TheDashboard,
    TheRequester,
    Words,
    split_names,
)
from mikas.dashboard.api.errors import OptionalTexts, TwoTexts, errors, made_of, two
from mikas.dashboard.api.library.cars import CarInfo
from mikas.dashboard.api.library.files import LeftOutFile
from mikas.dashboard.api.messages import LiveRows, RecordedEvent
from mikas.dashboard.api.state import State, state_of
from mikas.dashboard.errors import ADVICE, NotFound
from mikas.dashboard.library.folder import RecordingFile
from mikas.dashboard.library.service import RecordingService
from mikas.dashboard.session.history import json_columns
from mikas.dashboard.settings import folder_error
from mikas.recording.annotations.events import comment_note, had_marker, note_of
from mikas.recording.annotations.fields import LONGEST_COMMENT, LONGEST_LINE, LONGEST_TEXT
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.ignition_only import absent_in
from mikas.recording.recording import Recording
from mikas.recording.summary import Summary
from mikas.sampling.events import Marker, MethodChosen
from mikas.virtual import VIRTUAL_PASSPORT

router: Final = APIRouter(prefix="/api", tags=["recordings"])


class StartRecordingRequest(BaseModel):
    """`name` null: the date and time."""

    name: str | None = Field(None, max_length=200)


class MarkerRequest(BaseModel):
    """A marker's label. `time` null: now; else a moment that has passed."""

    label: Line = Field("", max_length=LONGEST_LINE)
    time: float | None = Field(None, allow_inf_nan=False)


class MarkerResponse(BaseModel):
    """The marker's time."""

    time: float


class NamedMarker(BaseModel):
    """The name of the marker with exactly that time."""

    time: float = Field(allow_inf_nan=False)
    label: Line = Field(max_length=LONGEST_LINE)


MarkerTime = Annotated[float, Query(allow_inf_nan=False)]
"""The time of a marker, exactly."""


class NoteRequest(BaseModel):
    """A note for the recording in progress."""

    text: Words = Field(max_length=LONGEST_TEXT)


class NoteResponse(BaseModel):
    """The note was written."""

    kept: bool


class RecordingInfo(BaseModel):
    """One recording; null: not known. `problem`: why the file can't be read."""

    id: str = Field(description="the file's name")
    bytes: int
    date: float | None = Field(description="the start; null: of a simulated clock")
    length: float | None
    model: OptionalTexts
    passport: list[str | None] | None
    samples: int | None
    samples_exact: bool = Field(description="whether they were counted, not estimated")
    rate: float | None
    gaps: int | None
    faults: list[int] | None = Field(description="as last read in it; null: they were not read")
    markers: int | None
    note: str
    car: CarInfo
    open: bool = Field(description="the recording is in progress")
    reference: bool = Field(description="marked as a reference to compare others with")
    virtual: bool = Field(description="of the virtual car, not measured on an engine")
    clock: list[TwoTexts] = Field(description="the latest changes of the computer's date")
    problem: TwoTexts | None


class RecordingProblem(TwoTexts):
    """A place that can't be read."""

    offset: int


class RecordingDetail(RecordingInfo):
    """One recording with its channels and events. `first`, `last`: the times of its rows."""

    channels: list[str]
    instruments: list[ChannelInfo] = Field(
        description="the channels of instruments beside the unit among them"
    )
    absent: list[str] = Field(
        description="channels that the unit does not have, as found from the values: it controls "
        "the ignition alone; empty: it has them all, or that is not certain"
    )
    first: float | None
    last: float | None
    events: list[RecordedEvent]
    problems: list[RecordingProblem]
    method: str | None


class RecordingsResponse(BaseModel):
    """The latest first. `problem`: why the folder is not writable, if so. `left_out`: files of the
    folder that are not listed, and why.
    """

    recordings: list[RecordingInfo]
    problem: TwoTexts | None
    left_out: list[LeftOutFile]


class RowsResponse(LiveRows):
    """Columns over time; null: no value in that row. `decimated`: only the minimum and maximum of
    each column in each interval.
    """

    decimated: bool


class RecordingNoteRequest(BaseModel):
    """A comment on the whole recording; replaces the one before."""

    text: Words = Field(max_length=LONGEST_COMMENT)


@router.post("/recording/start", responses=errors(409, 503))
async def start(dashboard: TheDashboard, client: Controller, body: StartRecordingRequest) -> State:
    """Record everything on the wire to a new file from now on."""
    await dashboard.recorder.start(body.name)
    return state_of(dashboard, client)


@router.post("/recording/stop", responses=errors(409))
async def stop(dashboard: TheDashboard, client: Controller) -> State:
    """End the recording, with a last reading of the stored faults if the unit gives one."""
    await dashboard.recorder.read_last()
    dashboard.recorder.stop()
    return state_of(dashboard, client)


@router.post("/recording/marker", responses=errors(409))
def marker(dashboard: TheDashboard, _: Controller, body: MarkerRequest) -> MarkerResponse:
    """Mark this moment, or one that has passed."""
    return MarkerResponse(time=dashboard.recorder.marker(body.label, body.time))


@router.put("/recording/marker", responses=errors(404, 409))
def name_marker(dashboard: TheDashboard, _: Controller, body: NamedMarker) -> MarkerResponse:
    """Give a marker of the running connection another name; its recording gets it, too.

    A removed marker comes back.
    """
    dashboard.recorder.change_marker(Marker(body.time, body.label, renamed=True))
    return MarkerResponse(time=body.time)


@router.delete("/recording/marker", responses=errors(404, 409))
def remove_marker(dashboard: TheDashboard, _: Controller, time: MarkerTime) -> MarkerResponse:
    """Remove the marker of exactly that time; its recording notes it, too."""
    dashboard.recorder.change_marker(Marker(time, removed=True))
    return MarkerResponse(time=time)


@router.post("/recording/note", responses=errors(409))
def note(dashboard: TheDashboard, _: Controller, body: NoteRequest) -> NoteResponse:
    """Write a note into the recording in progress."""
    dashboard.recorder.write_text(body.text)
    return NoteResponse(kept=True)


@router.get("/recordings", responses=errors(409, 504), response_model=RecordingsResponse)
async def recordings(requester: TheRequester) -> Response:
    """Return all recordings in the folder, the latest first."""
    library = requester.library
    listed, left = await requester.awaits(library.all(requester.address))

    def described() -> RecordingsResponse:
        marked = library.references.marked()
        found = [_info(library, file, summary, marked) for file, summary in listed]
        error = folder_error(library.folder.folder)
        problem = two(ADVICE.text(error)) if error else None
        more = {"recordings": found, "problem": problem, "left_out": left}
        return RecordingsResponse.model_validate(more, from_attributes=True)

    return await requester.answer(described)


@router.get(
    "/recordings/{identity}", responses=errors(404, 409, 504), response_model=RecordingDetail
)
async def recording(requester: TheRequester, identity: str) -> Response:
    """Return one recording, with its channels and its events."""

    def look(file: RecordingFile) -> Response:
        library = requester.library
        summary = library.summary(file)
        recording = library.opened(file) if summary.problem is None else None
        return JSONResponse(_detail(library, file, summary, recording) | {"id": identity})

    return await requester.view(identity, look, virtual=True)


@router.get(
    "/recordings/{identity}/rows", responses=errors(404, 409, 504), response_model=RowsResponse
)
async def rows(
    requester: TheRequester,
    identity: str,
    *,
    begin: Annotated[float, Query(alias="from", allow_inf_nan=False)] = -1e300,
    end: Annotated[float, Query(alias="to", allow_inf_nan=False)] = 1e300,
    points: Annotated[int, Query(ge=2, le=20_000)] = 2000,
    names: Names = None,
) -> Response:
    """Return the rows between `from` and `to`, decimated with spikes kept if they are too many."""

    def look(file: RecordingFile) -> Response:
        opened = requester.library.opened(file)
        window, decimated = opened.window(begin, end, points, split_names(names))
        return JSONResponse(json_columns(window.times, window.values) | {"decimated": decimated})

    return await requester.view(identity, look, virtual=True)


@router.put("/recordings/{identity}/note", responses=errors(404, 409, 504))
async def comment(
    requester: TheRequester, _: KnownClient, identity: str, body: RecordingNoteRequest
) -> RecordingInfo:
    """Write a comment on the recording into its file."""
    dashboard, library = requester.dashboard, requester.library
    note = comment_note(dashboard.connection.date(), body.text)

    def write(file: RecordingFile) -> RecordingInfo:
        dashboard.recorder.append_note(file.path, note)
        written = library.folder.one(identity)
        return _info(library, written, library.summary(written), library.references.marked())

    return await requester.view(identity, write)


@router.put("/recordings/{identity}/marker", responses=errors(404, 409, 504))
async def name_recorded_marker(
    requester: TheRequester, _: KnownClient, identity: str, body: NamedMarker
) -> MarkerResponse:
    """Give a marker of a recording another name, which is appended to its file.

    A removed marker comes back.
    """
    return await _change_marker(requester, identity, Marker(body.time, body.label, renamed=True))


@router.delete("/recordings/{identity}/marker", responses=errors(404, 409, 504))
async def remove_recorded_marker(
    requester: TheRequester, _: KnownClient, identity: str, time: MarkerTime
) -> MarkerResponse:
    """Remove a marker of a recording: a note of it is appended to its file."""
    return await _change_marker(requester, identity, Marker(time, removed=True))


async def _change_marker(requester: TheRequester, identity: str, marker: Marker) -> MarkerResponse:
    def write(file: RecordingFile) -> MarkerResponse:
        if not had_marker(CaptureReader(file.path).notes(), marker.time):
            raise NotFound(name=file.id)
        requester.dashboard.recorder.append_note(file.path, note_of(marker))
        return MarkerResponse(time=marker.time)

    return await requester.view(identity, write)


def _info(
    library: RecordingService, file: RecordingFile, summary: Summary, marked: Collection[str]
) -> RecordingInfo:
    return made_of(
        RecordingInfo,
        summary,
        id=file.id,
        bytes=file.bytes,
        rate=None if summary.rate is None else round(summary.rate, 2),
        gaps=None if summary.problem else summary.gaps,
        markers=None if summary.problem else summary.markers,
        open=library.is_growing(file),
        reference=file.id in marked,
        virtual=VIRTUAL_PASSPORT in (summary.passport or ()),
    )


def _detail(
    library: RecordingService, file: RecordingFile, summary: Summary, recording: Recording | None
) -> dict[str, Any]:
    """Return a `RecordingDetail` as JSON, not validated: its events are those in the file.

    `recording` None: the file can't be read.
    """
    marked = library.references.marked()
    detail: dict[str, Any] = _info(library, file, summary, marked).model_dump(mode="json")
    detail |= {
        "channels": [],
        "instruments": [],
        "absent": [],
        "events": [],
        "problems": [],
        "method": None,
    }
    if recording is None:
        return detail | {"first": None, "last": None}
    detail["first"], detail["last"] = _span(summary, recording)
    detail["channels"] = [channel.name for channel in recording.channels]
    detail["instruments"] = [it.model_dump(mode="json") for it in _beside(recording)]
    detail["absent"] = list(absent_in(recording))
    detail["events"] = [event.as_json() for event in recording.events]
    detail["problems"] = [
        {**problem.text._asdict(), "offset": problem.offset} for problem in recording.problems
    ]
    methods = [event.method for event in recording.events if isinstance(event, MethodChosen)]
    unit = summary.unit
    detail["method"] = methods[-1] if methods else unit.method if unit else None
    return detail


def _beside(recording: Recording) -> list[ChannelInfo]:
    """Return the channels of instruments among the recording's."""
    known, names = recording.catalog.instruments, frozenset(recording.instrument_channels)
    return [
        instrument_channel_info(
            known.get(each.name)
            or InstrumentChannel(
                each.name,
                each.text,
                unit=each.unit,
                unit_text=each.unit_text,
                decimals=each.decimals,
            ),
            {},
        )
        for each in recording.channels
        if each.name in names
    ]


def _span(summary: Summary, recording: Recording) -> tuple[float | None, float | None]:
    """Return the times of the first and last row; from the summary, if known, without reading."""
    if summary.recordings == 1 and summary.first is not None and summary.length is not None:
        return summary.first, summary.first + summary.length
    return recording.span or (None, None)
