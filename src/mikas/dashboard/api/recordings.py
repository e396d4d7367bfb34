"""Routes of recordings: the list, one recording, any window of its rows, its note.

A recording is named by its file's name in the folder; nothing else can be reached. Reading takes
threads, never the event loop's time.
"""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.dashboard.advice import ADVICE
from mikas.dashboard.api import exports, report
from mikas.dashboard.api.broadcaster import dumps
from mikas.dashboard.api.dependencies import KnownClient, TheDashboard, TheLibrary
from mikas.dashboard.api.errors import TwoTexts, errors, two, two_or_none
from mikas.dashboard.api.messages import RecordedEvent
from mikas.dashboard.library.folder import RecordingFile
from mikas.dashboard.library.service import RecordingService
from mikas.dashboard.session.history import json_columns
from mikas.dashboard.settings import check_folder
from mikas.errors import UsageError
from mikas.recording.annotations.events import LONGEST_COMMENT, comment_note
from mikas.recording.capture.writer import append_note
from mikas.recording.recording import Recording
from mikas.recording.summary import Summary
from mikas.sampling.events import MethodChosen

router = APIRouter(tags=["recordings"])


class RecordingInfo(BaseModel):
    """One recording; null: not known. `problem`: why it can't be read."""

    id: str = Field(description="the file's name")
    bytes: int
    date: float | None = Field(description="when it began; null: the clock was a simulated one")
    length: float | None
    model: TwoTexts | None
    passport: list[str | None] | None
    samples: int | None
    samples_exact: bool = Field(description="whether they were counted, not estimated")
    rate: float | None
    gaps: int | None
    faults: list[int] | None = Field(description="as last read in it; null: they were not read")
    markers: int | None
    note: str
    open: bool = Field(description="it is being made")
    problem: TwoTexts | None


class RecordingProblem(BaseModel):
    """A place that can't be read."""

    en: str
    ru: str
    offset: int


class RecordingDetail(RecordingInfo):
    """One recording with all that happened in it. `first`, `last`: its rows lie between them."""

    channels: list[str]
    first: float | None
    last: float | None
    events: list[RecordedEvent]
    problems: list[RecordingProblem]
    method: str | None


class RecordingsResponse(BaseModel):
    """The latest first. `problem`: why none can be kept in the folder, if so."""

    recordings: list[RecordingInfo]
    problem: TwoTexts | None


class RowsResponse(BaseModel):
    """Columns over time. null: nothing came in that row. `decimated`: of each piece of time the
    least and the greatest value of each column.
    """

    names: list[str]
    times: list[float]
    values: list[list[float | None]]
    decimated: bool


class RecordingNoteRequest(BaseModel):
    """A person's words about the whole recording; they take the place of those before."""

    text: str = Field(max_length=LONGEST_COMMENT)


@router.get("/recordings", responses=errors())
def recordings(library: TheLibrary) -> RecordingsResponse:
    """All recordings in the folder, the latest first."""
    there = library.folder.all()
    library.summaries.keep_only(there)
    return RecordingsResponse(
        recordings=[_listed(library, it) for it in there],
        problem=_problem(library),
    )


@router.get("/recordings/{identity}", responses=errors(404), response_model=RecordingDetail)
def recording(library: TheLibrary, identity: str) -> Response:
    """One recording, with its channels and its events."""
    it = library.folder.one(identity)
    summary, growing = library.summaries.of(it), library.is_growing(it)
    if summary.problem is not None:
        return _json(detailed(it, summary, None, growing=growing))
    with library.open.using:
        opened = library.open.one(it, growing=growing)
        return _json(detailed(it, summary, opened, growing=growing))


@router.get("/recordings/{identity}/rows", responses=errors(404), response_model=RowsResponse)
def rows(
    library: TheLibrary,
    identity: str,
    *,
    begin: Annotated[float, Query(alias="from", allow_inf_nan=False)] = -1e300,
    end: Annotated[float, Query(alias="to", allow_inf_nan=False)] = 1e300,
    points: Annotated[int, Query(ge=2, le=20_000)] = 2000,
    names: Annotated[str | None, Query(max_length=4000, description="A,B; all")] = None,
) -> Response:
    """What was recorded from `from` to `to`, with spikes kept where there are too many rows."""
    it = library.folder.one(identity)
    wanted = [name for name in names.split(",") if name] if names is not None else None
    with library.open.using:
        opened = library.open.one(it, growing=library.is_growing(it))
        found, decimated = opened.window(begin, end, points, wanted)
    return _json(json_columns(found) | {"decimated": decimated})


@router.put("/recordings/{identity}/note", responses=errors(404))
def note(
    dashboard: TheDashboard,
    library: TheLibrary,
    _: KnownClient,
    identity: str,
    body: RecordingNoteRequest,
) -> RecordingInfo:
    """Keeps words about the recording, in its own file."""
    it = library.folder.one(identity)
    comment = comment_note(dashboard.connection.now(), body.text)
    if library.is_growing(it):
        dashboard.recorder.recorder.note(comment)
    else:
        append_note(it.path, comment)
    return _listed(library, library.folder.one(identity))


def _problem(library: RecordingService) -> TwoTexts | None:
    try:
        check_folder(library.folder.folder)
    except UsageError as error:
        return two(ADVICE.text(error))
    return None


def _json(content: object) -> Response:
    return Response(dumps(content), media_type="application/json")


def _listed(library: RecordingService, it: RecordingFile) -> RecordingInfo:
    return listed(it, library.summaries.of(it), growing=library.is_growing(it))


def listed(it: RecordingFile, summary: Summary, *, growing: bool) -> RecordingInfo:
    """As the list shows it."""
    return RecordingInfo(
        id=it.id,
        bytes=it.bytes,
        date=summary.date,
        length=summary.length,
        model=two_or_none(summary.model),
        passport=None if summary.passport is None else list(summary.passport),
        samples=summary.samples,
        samples_exact=summary.samples_exact,
        rate=None if summary.rate is None else round(summary.rate, 2),
        gaps=None if summary.problem else summary.gaps,
        faults=None if summary.faults is None else list(summary.faults),
        markers=None if summary.problem else summary.markers,
        note=summary.note,
        open=growing,
        problem=two_or_none(summary.problem),
    )


def detailed(
    it: RecordingFile, summary: Summary, recording: Recording | None, *, growing: bool
) -> dict[str, Any]:
    """Return a `RecordingDetail` as JSON, not validated: its events are what the file holds.

    `recording` None: it can't be read.
    """
    detail: dict[str, Any] = listed(it, summary, growing=growing).model_dump(mode="json")
    detail |= {"channels": [], "events": [], "problems": [], "method": None}
    if recording is None:
        return detail | {"first": None, "last": None}
    detail["first"], detail["last"] = _span(summary, recording)
    detail["channels"] = [channel.name for channel in recording.channels]
    detail["events"] = [event.as_json() for event in recording.events]
    detail["problems"] = [
        {"en": it.text.en, "ru": it.text.ru, "offset": it.offset} for it in recording.problems
    ]
    methods = [event.method for event in recording.events if isinstance(event, MethodChosen)]
    unit = summary.unit
    detail["method"] = methods[-1] if methods else unit.method if unit else None
    return detail


def _span(summary: Summary, recording: Recording) -> tuple[float | None, float | None]:
    """From the summary if that tells: the recording itself would have to be read for it."""
    if summary.recordings == 1 and summary.first is not None and summary.length is not None:
        return summary.first, summary.first + summary.length
    return recording.span or (None, None)


router.include_router(exports.router)
router.include_router(report.router)
