"""Routes of dumps: start, list, pause, resume, download, compare.

Deleting a dump is a change, shown and confirmed as every other (`api.changes`).
"""

from __future__ import annotations

import time
from itertools import islice
from typing import Annotated, Final, Literal

from fastapi import APIRouter, Body, Depends, Path, Query
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.client import Ecu
from mikas.client.memory.dumps import Manifest, differences, identity_of
from mikas.commands.base import check_range
from mikas.dashboard.api.changes import Space
from mikas.dashboard.api.dependencies import Controller, TheDashboard, TheRequester
from mikas.dashboard.api.errors import content, errors, made_of
from mikas.dashboard.api.library.files import LeftOutFile, OpenFile
from mikas.dashboard.error_responses import ErrorBody, body_of
from mikas.dashboard.library.folder import opened
from mikas.dashboard.session.dump_jobs import DumpJob

router: Final = APIRouter(prefix="/api", tags=["dumps"])

_MAX_SHOWN = 1000


async def _dump(
    dashboard: TheDashboard, identity: Annotated[str, Path(alias="id", max_length=240)]
) -> DumpJob:
    return dashboard.dump_jobs.one(identity)


TheDump = Annotated[DumpJob, Depends(_dump)]
"""The dump of the path's id. Raises `NotFound`."""


class DumpRequest(BaseModel):
    """The range to read; `last` is inclusive. `verify`: read it twice."""

    space: Space
    first: int = Field(0, ge=0, le=0xFFFF)
    last: int = Field(ge=0, le=0xFFFF)
    block: int | None = Field(None, ge=1, le=255)
    verify: bool = False


class DumpCell(BaseModel):
    """A cell of the map."""

    first: int
    count: int
    state: Literal["todo", "done", "retried", "failed"]


class DumpResponse(BaseModel):
    """The progress of a dump. With `verify`, `total` counts both passes."""

    id: str
    space: Space
    first: int
    last: int
    block: int | None
    state: Literal["running", "paused", "done", "failed"]
    done: int
    total: int
    speed: float = Field(description="bytes a second")
    left: float | None = Field(description="seconds")
    blocks: list[DumpCell]
    error: ErrorBody | None = Field(description="the cause of a delay, or of the failure")
    file: str
    differences: int | None = Field(
        description="found by the second pass so far; null: it was not requested, or not started"
    )


class DumpsResponse(BaseModel):
    """The newest first. `left_out`: files of the folder that are not listed, and why."""

    dumps: list[DumpResponse]
    left_out: list[LeftOutFile]


class ByteDifference(BaseModel):
    """Two bytes that differ; null: that side has no byte there."""

    address: int
    a: str | None
    b: str | None


class DifferencesResponse(BaseModel):
    """The first 1000 of `count`."""

    differences: list[ByteDifference]
    count: int


@router.post("/dumps", responses=errors(409, 502, 503))
async def start(dashboard: TheDashboard, _: Controller, body: DumpRequest) -> DumpResponse:
    """Start reading a range of memory into a file."""
    check_range(body.space, body.first, body.last - body.first + 1)

    def manifest_of(ecu: Ecu) -> Manifest:
        unit = ecu.model.text.en, *identity_of(ecu)
        return Manifest(body.space, body.first, body.last, *unit, verify=body.verify)

    manifest = await dashboard.connection.ask(manifest_of)
    stamp = time.strftime("%Y%m%d-%H%M%S")
    name = f"{body.space}-{body.first:04X}-{body.last:04X}-{stamp}"
    file = dashboard.dump_jobs.new_file(name)
    job = DumpJob(file.stem, file, manifest, body.block)
    dashboard.dump_jobs.start(job)
    return _response(job)


@router.get("/dumps", responses=errors(409, 504), response_model=DumpsResponse)
async def dumps(requester: TheRequester) -> Response:
    """Return all dumps."""
    kept = requester.dashboard.dump_jobs
    jobs = sorted(kept.jobs.values(), key=lambda job: job.started, reverse=True)
    return await requester.answer(
        lambda: made_of(DumpsResponse, kept, dumps=[_response(job) for job in jobs])
    )


@router.get("/dumps/{id}", responses=errors(404))
async def dump(job: TheDump) -> DumpResponse:
    """Return one dump."""
    return _response(job)


@router.post("/dumps/{id}/pause", responses=errors(404, 409))
async def pause(dashboard: TheDashboard, _: Controller, job: TheDump) -> DumpResponse:
    """Pause reading; the bytes read so far are kept."""
    await dashboard.dump_jobs.pause(job)
    return _response(job)


@router.post("/dumps/{id}/resume", responses=errors(404, 409))
async def resume(dashboard: TheDashboard, _: Controller, job: TheDump) -> DumpResponse:
    """Resume reading after the bytes read so far."""
    if job.phase != "done":
        dashboard.dump_jobs.start(job)
    return _response(job)


@router.get(
    "/dumps/{id}/file",
    response_class=Response,
    responses=errors(404) | content("application/octet-stream", "the bytes read so far"),
)
def file(job: TheDump) -> Response:
    """Return the bytes read so far."""
    kept, size = opened(job.file, job.id), job.manifest.size
    return OpenFile(kept, job.file.name, "application/octet-stream", most=size)


@router.post(
    "/dumps/{id}/compare", responses=errors(404, 409, 504), response_model=DifferencesResponse
)
async def compare(
    requester: TheRequester,
    job: TheDump,
    other: Annotated[bytes, Body(media_type="application/octet-stream")],
    first: Annotated[int | None, Query(ge=0, le=0xFFFF)] = None,
) -> Response:
    """Compare this dump (`a`) with the body (`b`, beginning at `first`)."""
    begin = job.manifest.first if first is None else first

    def work() -> DifferencesResponse:
        with opened(job.file, job.id) as file:
            own = file.read(job.manifest.size)
        found = differences(own, job.manifest.first, other, begin)
        shown = [
            ByteDifference(address=it.address, a=_hex(it.a), b=_hex(it.b))
            for it in islice(found, _MAX_SHOWN)
        ]
        return DifferencesResponse(differences=shown, count=len(shown) + sum(1 for _ in found))

    return await requester.answer(work)


def _response(job: DumpJob) -> DumpResponse:
    manifest, speed = job.manifest, job.speed
    left = (job.total - job.done) / speed if speed > 0 else None
    state, blocks = job.phase, _map(job)
    error = job.error  # read after the state, and once: in another thread it may change meanwhile
    return made_of(
        DumpResponse,
        job,
        space=manifest.space,
        first=manifest.first,
        last=manifest.last,
        state=state,
        speed=round(speed, 1),
        left=None if left is None else round(left, 1),
        blocks=blocks,
        error=body_of(error) if error else None,
        file=job.file.name,
        differences=manifest.differences,
    )


def _map(job: DumpJob) -> list[DumpCell]:
    manifest, cells = job.manifest, []
    for index, offset in enumerate(range(0, manifest.size, job.cell)):
        count = min(job.cell, manifest.size - offset)
        state: Literal["todo", "done", "retried", "failed"] = "todo"
        if offset + count <= manifest.bytes_read:
            state = "retried" if index in job.retried else "done"
        elif job.phase == "failed" and offset <= manifest.bytes_read:
            state = "failed"
        cells.append(DumpCell(first=manifest.first + offset, count=count, state=state))
    return cells


def _hex(byte: int | None) -> str | None:
    return None if byte is None else f"{byte:02X}"
