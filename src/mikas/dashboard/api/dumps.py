"""The API's side of dumps: begun, looked at, paused, resumed, compared.

Deleting one is a change, shown and confirmed as every other (`mikas.dashboard.dumps_delete`).
"""

from __future__ import annotations

import asyncio
import time
from itertools import islice
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Body, Path, Query
from fastapi.responses import FileResponse, Response
from pydantic import BaseModel, Field

from mikas.client import Ecu
from mikas.client.memory.dump import Difference, differences
from mikas.client.memory.manifest import Manifest
from mikas.client.memory.spaces import last_of
from mikas.commands.base import check_range
from mikas.dashboard.api.dependencies import Controller, TheHub
from mikas.dashboard.api.errors import ErrorBody, body_of, errors
from mikas.dashboard.api.memory import Space
from mikas.dashboard.dashboard import Hub
from mikas.dashboard.errors import NotFound
from mikas.dashboard.session.dump_jobs import Job

router = APIRouter(tags=["dumps"])

_SHOWN = 1000
DumpId = Annotated[str, Path(max_length=100)]


class DumpRequest(BaseModel):
    """What to read; `last` is inclusive. `verify`: read all of it twice."""

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
    """How far a dump has come. With `verify`, `total` counts both passes."""

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
    error: ErrorBody | None = Field(description="what holds it up, or ended it")
    file: str
    differences: int | None = Field(
        description="that the second pass has found so far; null: none was wanted, or it has not "
        "begun"
    )


class DumpsResponse(BaseModel):
    """The newest first."""

    dumps: list[DumpResponse]


class ByteDifference(BaseModel):
    """Two bytes that differ; null: one side has no byte there."""

    address: int
    a: str | None
    b: str | None


class DifferencesResponse(BaseModel):
    """The first 1000 of `count`."""

    differences: list[ByteDifference]
    count: int


@router.post("/dumps", responses=errors(409, 502, 503))
async def start(hub: TheHub, _: Controller, wish: DumpRequest) -> DumpResponse:
    """Begins to read a range of memory into a file."""
    check_range(wish.space, last_of(wish.space), wish.first, wish.last - wish.first + 1)
    manifest = await hub.ask(lambda ecu: _manifest(ecu, wish))
    stamp = time.strftime("%Y%m%d-%H%M%S")
    name = f"{wish.space}-{wish.first:04X}-{wish.last:04X}-{stamp}"
    folder, number, stem = hub.settings.dumps, 2, name
    while stem in hub.dumping.jobs or (folder / f"{stem}.bin").exists():
        stem, number = f"{name}-{number}", number + 1
    job = Job(stem, folder / f"{stem}.bin", manifest, wish.block)
    hub.dumping.start(job)
    return _answer(job)


@router.get("/dumps", responses=errors())
async def dumps(hub: TheHub) -> DumpsResponse:
    """All that there are."""
    jobs = sorted(hub.dumping.jobs.values(), key=lambda job: job.begun, reverse=True)
    return DumpsResponse(dumps=[_answer(job) for job in jobs])


@router.get("/dumps/{id}", responses=errors(404))
async def dump(hub: TheHub, id: DumpId) -> DumpResponse:  # noqa: A002  (the API's name)
    """One of them."""
    return _answer(_job(hub, id))


@router.post("/dumps/{id}/pause", responses=errors(404, 409))
async def pause(hub: TheHub, _: Controller, id: DumpId) -> DumpResponse:  # noqa: A002  (as above)
    """Stops reading; nothing that was read is lost."""
    job = _job(hub, id)
    await hub.dumping.pause(job)
    return _answer(job)


@router.post("/dumps/{id}/resume", responses=errors(404, 409))
async def resume(hub: TheHub, _: Controller, id: DumpId) -> DumpResponse:  # noqa: A002  (as above)
    """Goes on behind what was read."""
    job = _job(hub, id)
    if job.phase != "done":
        hub.dumping.start(job)
    return _answer(job)


@router.get(
    "/dumps/{id}/file",
    response_class=Response,
    responses={**errors(404), 200: {"content": {"application/octet-stream": {}}}},
)
def file(hub: TheHub, id: DumpId) -> Response:  # noqa: A002  (the API's name)
    """What was read so far, as it is."""
    job = _job(hub, id)
    if not job.file.is_file():
        raise NotFound(name=id)
    return FileResponse(job.file, media_type="application/octet-stream", filename=job.file.name)


@router.post("/dumps/{id}/compare", responses=errors(404))
async def compare(
    hub: TheHub,
    id: DumpId,  # noqa: A002  (the API's name)
    other: Annotated[bytes, Body(media_type="application/octet-stream")],
    first: Annotated[int | None, Query(ge=0, le=0xFFFF)] = None,
) -> DifferencesResponse:
    """Where this dump (`a`) and the body (`b`, beginning at `first`) differ."""
    job = _job(hub, id)
    begin = job.manifest.first if first is None else first

    def work() -> DifferencesResponse:
        try:
            own = job.file.read_bytes()
        except FileNotFoundError:
            raise NotFound(name=id) from None
        found = differences(own, job.manifest.first, other, begin)
        shown = [_difference(it) for it in islice(found, _SHOWN)]
        return DifferencesResponse(differences=shown, count=len(shown) + sum(1 for _ in found))

    return await asyncio.to_thread(work)


def _manifest(ecu: Ecu, wish: DumpRequest) -> Manifest:
    return Manifest(
        wish.space,
        wish.first,
        wish.last,
        ecu.model.text.en,
        ecu.version_code,
        ecu.passport().pieces,
        verify=wish.verify,
    )


def _job(hub: Hub, name: str) -> Job:
    job = hub.dumping.jobs.get(name)
    if job is None:
        raise NotFound(name=name)
    return job


def _answer(job: Job) -> DumpResponse:
    manifest, speed = job.manifest, job.speed
    left = (job.total - job.done) / speed if speed > 0 else None
    return DumpResponse(
        id=job.id,
        space=_space(manifest.space),
        first=manifest.first,
        last=manifest.last,
        block=job.block,
        state=job.phase,
        done=job.done,
        total=job.total,
        speed=round(speed, 1),
        left=None if left is None else round(left, 1),
        blocks=_map(job),
        error=ErrorBody(**body_of(job.error)) if job.error else None,
        file=job.file.name,
        differences=manifest.differences,
    )


def _space(name: str) -> Any:  # noqa: ANN401  (a manifest's; checked when it was read)
    return name


def _map(job: Job) -> list[DumpCell]:
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


def _difference(it: Difference) -> ByteDifference:
    return ByteDifference(
        address=it.address,
        a=None if it.a is None else f"{it.a:02X}",
        b=None if it.b is None else f"{it.b:02X}",
    )
