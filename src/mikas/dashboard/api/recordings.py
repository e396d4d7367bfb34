"""The API's side of recordings: which there are, what is in one, any window of it, its note.

A recording is named by its file's name in the folder; nothing else can be reached. Reading takes
threads, never the event loop's time.
"""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.dashboard.advice import ADVICE
from mikas.dashboard.api import exports, report
from mikas.dashboard.api.broadcaster import dumps
from mikas.dashboard.api.dependencies import Asker, TheHub
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.library.folder import Shelved
from mikas.dashboard.library.service import Desk, TheDesk
from mikas.dashboard.recordings_told import (
    RecordingDetail,
    RecordingInfo,
    RecordingsResponse,
    detailed,
    listed,
)
from mikas.dashboard.session.history import json_columns
from mikas.dashboard.settings import check_folder
from mikas.errors import UsageError
from mikas.recording.annotations.comment import LONGEST, comment_note, write_comment

router = APIRouter(tags=["recordings"])


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

    text: str = Field(max_length=LONGEST)


@router.get("/recordings", responses=errors())
def recordings(desk: TheDesk) -> RecordingsResponse:
    """All recordings in the folder, the latest first."""
    there = desk.shelf.all()
    desk.summaries.forget_all_but(there)
    return RecordingsResponse(
        recordings=[_listed(desk, it) for it in there],
        problem=_problem(desk),
    )


@router.get("/recordings/{identity}", responses=errors(404), response_model=RecordingDetail)
def recording(desk: TheDesk, identity: str) -> Response:
    """One recording, with its channels and its events."""
    it = desk.shelf.one(identity)
    summary, growing = desk.summaries.of(it), desk.is_growing(it)
    if summary.problem is not None:
        return _json(detailed(it, summary, None, growing=growing))
    with desk.opened.using:
        opened = desk.opened.one(it, growing=growing)
        return _json(detailed(it, summary, opened, growing=growing))


@router.get("/recordings/{identity}/rows", responses=errors(404), response_model=RowsResponse)
def rows(
    desk: TheDesk,
    identity: str,
    *,
    begin: Annotated[float, Query(alias="from", allow_inf_nan=False)] = -1e300,
    end: Annotated[float, Query(alias="to", allow_inf_nan=False)] = 1e300,
    points: Annotated[int, Query(ge=2, le=20_000)] = 2000,
    names: Annotated[str | None, Query(max_length=4000, description="A,B; all")] = None,
) -> Response:
    """What was recorded from `from` to `to`, with spikes kept where there are too many rows."""
    it = desk.shelf.one(identity)
    wanted = [name for name in names.split(",") if name] if names is not None else None
    with desk.opened.using:
        opened = desk.opened.one(it, growing=desk.is_growing(it))
        found, decimated = opened.window(begin, end, points, wanted)
    return _json(json_columns(found) | {"decimated": decimated})


@router.put("/recordings/{identity}/note", responses=errors(404))
def note(
    hub: TheHub, desk: TheDesk, _: Asker, identity: str, wish: RecordingNoteRequest
) -> RecordingInfo:
    """Keeps words about the recording, in its own file."""
    it = desk.shelf.one(identity)
    if desk.is_growing(it):
        hub.recording.recorder.note(comment_note(hub.now(), wish.text))
    else:
        write_comment(it.path, wish.text, hub.now())
    return _listed(desk, desk.shelf.one(identity))


def _problem(desk: Desk) -> TwoTexts | None:
    try:
        check_folder(desk.hub.settings.recordings)
    except UsageError as error:
        return two(ADVICE.text(error))
    return None


def _json(content: object) -> Response:
    return Response(dumps(content), media_type="application/json")


def _listed(desk: Desk, it: Shelved) -> RecordingInfo:
    return listed(it, desk.summaries.of(it), growing=desk.is_growing(it))


router.include_router(exports.router)
router.include_router(report.router)
