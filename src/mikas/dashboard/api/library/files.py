"""Routes of recordings as files: the capture itself, other programs' formats, one from elsewhere.

Exports run in a thread, in the lane of files; two at once leave sampling its share of the computer.
The result is a temporary file, deleted once it is sent or the client has disconnected. Until then
it holds its client's place in the lane.

A recording from elsewhere is written beside its name first, and has it once it is whole and a
recording. No file is ever replaced. Only this computer may add one: it fills the disk.
"""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import tempfile
from collections.abc import Callable
from contextlib import AsyncExitStack, suppress
from math import inf
from pathlib import Path
from secrets import token_hex
from typing import Annotated, BinaryIO, Final, Literal
from urllib.parse import quote

from fastapi import APIRouter, Query, Request
from fastapi.responses import FileResponse, Response, StreamingResponse
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.types import Receive, Scope, Send

from mikas.dashboard.api.dependencies import (
    GONE,
    LocalClient,
    Names,
    TheDashboard,
    TheRequester,
    split_names,
)
from mikas.dashboard.api.errors import TwoTexts, content, errors
from mikas.dashboard.library.folder import opened
from mikas.dashboard.settings import ensure_folder
from mikas.errors import CaptureError, reason_of
from mikas.files import beside
from mikas.i18n import Language
from mikas.recording.capture.opening import copy_plain, is_packed
from mikas.recording.capture.packed import packed_suffix
from mikas.recording.splitting import cars_in, split

router: Final = APIRouter(prefix="/api/recordings", tags=["recordings"])

Format = Literal["csv", "mf4", "parquet", "msl", "mlg", "gpx", "geojson"]
_CHUNK: Final = 1 << 16
_TYPES: Final = {
    "csv": "text/csv; charset=utf-8",
    "mf4": "application/x-mdf",
    "parquet": "application/vnd.apache.parquet",
    "msl": "text/plain; charset=utf-8",
    "mlg": "application/octet-stream",
    "gpx": "application/gpx+xml",
    "geojson": "application/geo+json",
}
_CAPTURE: Final = "application/x-pcapng"
_SENT: Final = re.compile(r"(\.pcapng)( ?\(\d+\))?\.txt$", re.IGNORECASE)
"""How a recording is named that a phone's browser has shared: it shares no .pcapng."""
FILE: Final = content("application/octet-stream", "the file")
"""The description of a response that is a file."""
_BODY: Final = {"requestBody": {"required": True, "content": {"application/octet-stream": {}}}}


class LeftOutFile(BaseModel):
    """A file of the folder that is not listed, and why. `name` empty: several files."""

    name: str
    problem: TwoTexts


class OpenFile(StreamingResponse):
    """The bytes that a file has now, from the open file: deleted or replaced, it is sent whole.

    Of a file that grows the part written so far is sent. If it is cut meanwhile, the response ends
    without its last bytes, and the client sees that.
    """

    def __init__(self, opened: BinaryIO, name: str, media_type: str, *, most: float = inf) -> None:
        self._opened = opened
        self._left = int(min(most, os.fstat(opened.fileno()).st_size))
        headers = {"Content-Length": str(self._left), "Content-Disposition": attachment(name)}
        super().__init__((), media_type=media_type, headers=headers)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await super().__call__(scope, receive, send)
        finally:
            self._opened.close()

    async def stream_response(self, send: Send) -> None:
        start = {"status": self.status_code, "headers": self.raw_headers}
        await send({"type": "http.response.start", **start})
        while self._left:
            data = await asyncio.to_thread(self._opened.read, min(self._left, _CHUNK))
            if not data:
                return
            self._left -= len(data)
            await send({"type": "http.response.body", "body": data, "more_body": True})
        await send({"type": "http.response.body", "body": b"", "more_body": False})


def attachment(name: str) -> str:
    """Return the header that makes a browser save the response as `name`."""
    if quote(name, safe="") == name:
        return f'attachment; filename="{name}"'
    return f"attachment; filename*=UTF-8''{quote(name, safe='')}"


class _Temporary(FileResponse):
    """A file that needs `resources` until it is sent, or was not."""

    def __init__(self, path: Path, resources: AsyncExitStack, **settings: str) -> None:
        super().__init__(path, **settings)  # type: ignore[arg-type]  # as FileResponse takes them
        self._resources = resources

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await super().__call__(scope, receive, send)
        finally:
            await self._resources.aclose()


async def _delete(folder: Path) -> None:
    await asyncio.shield(asyncio.to_thread(shutil.rmtree, folder, ignore_errors=True))


@router.get("/{identity}/file", response_class=Response, responses=errors(404) | FILE)
def file(dashboard: TheDashboard, identity: str) -> Response:
    """Return the recording itself (.pcapng); of one in progress, the part written so far."""
    found = dashboard.library.folder.one(identity)
    return OpenFile(opened(found.path, found.id), found.id, _CAPTURE)


@router.get("/{identity}/export", response_class=Response, responses=errors(404, 409, 504) | FILE)
async def export(
    requester: TheRequester,
    identity: str,
    *,
    format: Annotated[Format, Query()] = "csv",  # noqa: A002  (the contract's word)
    names: Names = None,
    dialect: Annotated[Literal["plain", "excel"], Query(description="of a CSV")] = "plain",
    lang: Language = "en",
) -> Response:
    """Return the recording as a table for other programs, or as the way of the car.

    The way (gpx, geojson) is one of a recording with a GPS.
    """
    library = requester.library
    source = await asyncio.to_thread(library.folder.one, identity)
    wanted = tuple(split_names(names) or ())
    kind = "-excel" if (format, dialect) == ("csv", "excel") else ""

    def write(out: Path) -> None:
        from mikas.recording.export import DIALECTS, TRACKS, with_position
        from mikas.recording.export import export as write_table

        opened = library.opened(source, latest=True)
        names = with_position(opened, wanted) if f".{format}" in TRACKS else wanted
        recording = opened.interpreted(library.interpretation, names)
        write_table(
            out,
            recording.channels,
            recording.rows(),
            events=recording.events,
            about=recording.about,
            language=lang,
            dialect=DIALECTS[dialect],
        )

    return await sent_export(requester, source.id, f"{source.path.stem}{kind}.{format}", write)


async def sent_export(
    requester: TheRequester, key: str, name: str, write: Callable[[Path], object]
) -> Response:
    """Return the file that `write` makes in the lane of files; it is deleted once it is sent.

    `key`: whose turn it is; `name`: of the file to save, whose suffix is a format.
    """
    lane = requester.library.files
    async with AsyncExitStack() as resources:
        resources.enter_context(lane.place(requester.address))
        folder = Path(tempfile.mkdtemp(prefix="mikas-export-"))
        resources.push_async_callback(_delete, folder)
        out = folder / name
        await requester.awaits(lane.run(lambda: write(out), key=key, address=requester.address))
        kind = _TYPES[out.suffix[1:]]
        return _Temporary(out, resources.pop_all(), media_type=kind, filename=name)


class AddedRecording(BaseModel):
    """The recording that was added."""

    id: str = Field(description="the file's name: another than asked for if that was in use")


@router.post("", responses=errors(409), openapi_extra=_BODY)
async def add(
    dashboard: TheDashboard,
    _: LocalClient,
    request: Request,
    name: Annotated[str, Query(max_length=300, description="of the file, elsewhere")],
) -> AddedRecording:
    """Add a recording made elsewhere, a .pcapng; the body is the file.

    A packed one is kept unpacked; one of several cars as a file of each, and the last is returned.
    """
    folder = dashboard.library.folder
    await asyncio.to_thread(ensure_folder, folder.folder)
    name = _SENT.sub(r"\1", name[: len(name) - len(packed_suffix(name))])
    path = folder.new_path(name)
    new = beside(path, f".{token_hex(4)}.new")  # of this request alone
    plain = beside(path, f".{token_hex(4)}.plain")

    def keep() -> Path:
        if len(cars_in(new)) > 1:  # raises for other files
            return [part for _, part in split(new, folder.new_path(name))][-1]
        if is_packed(new):
            copy_plain(new, plain)
            plain.replace(new)
        while True:
            with suppress(FileExistsError):  # another program has just taken that name
                free = folder.new_path(name)
                free.touch(exist_ok=False)
                return new.replace(free)

    try:
        with await asyncio.to_thread(new.open, "xb") as file:
            async for part in request.stream():
                await asyncio.to_thread(file.write, part)
            await asyncio.to_thread(file.flush)
            await asyncio.to_thread(os.fsync, file.fileno())
        kept = await asyncio.to_thread(keep)
    except ClientDisconnect:
        raise HTTPException(GONE, "the client has disconnected") from None
    except CaptureError as error:
        raise CaptureError(path.name, error.problem).caused_by(error, path.name) from error
    except OSError as error:
        raise CaptureError(path.name, reason_of(error)).caused_by(error, path.name) from error
    finally:
        with suppress(OSError):
            await asyncio.to_thread(new.unlink, missing_ok=True)
            await asyncio.to_thread(plain.unlink, missing_ok=True)
    return AddedRecording(id=kept.name)
