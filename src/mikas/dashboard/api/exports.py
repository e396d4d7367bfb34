"""Routes of recordings as files: the capture itself, other programs' formats, a report.

Exports and reports run in a thread, one at a time, so that sampling keeps its share of the
computer. The result is a temporary file, deleted once it is sent or the client is gone.
"""

from __future__ import annotations

import asyncio
import shutil
import tempfile
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal
from urllib.parse import quote

from fastapi import APIRouter, Query
from fastapi.responses import FileResponse, Response, StreamingResponse
from starlette.types import Receive, Scope, Send

from mikas.dashboard.api.dependencies import TheLibrary
from mikas.dashboard.api.errors import errors
from mikas.dashboard.library.folder import RecordingFile
from mikas.dashboard.library.service import RecordingService
from mikas.i18n import Language

if TYPE_CHECKING:
    from mikas.report.findings import Findings

router = APIRouter(prefix="/recordings", tags=["recordings"])

Format = Literal["csv", "mf4", "parquet", "msl", "mlg"]
_TYPES: Final = {
    "csv": "text/csv; charset=utf-8",
    "mf4": "application/x-mdf",
    "parquet": "application/vnd.apache.parquet",
    "msl": "text/plain; charset=utf-8",
    "mlg": "application/octet-stream",
}
_CAPTURE: Final = "application/x-pcapng"
_CHUNK: Final = 1 << 16
_Described = dict[int | str, dict[str, Any]]
_FILE: Final[_Described] = {
    200: {"content": {"application/octet-stream": {}}, "description": "the file"}
}
HTML: Final[_Described] = {200: {"content": {"text/html": {}}, "description": "the page"}}


class _Temporary(FileResponse):
    """A file whose folder goes away with the answer, however that ends."""

    def __init__(self, path: Path, **settings: str) -> None:
        super().__init__(path, **settings)  # type: ignore[arg-type]  # as FileResponse takes them
        self._folder = path.parent

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await super().__call__(scope, receive, send)
        finally:
            await asyncio.shield(asyncio.to_thread(_remove, self._folder))


@router.get("/{identity}/file", response_class=Response, responses={**errors(404), **_FILE})
def file(library: TheLibrary, identity: str) -> Response:
    """The recording itself (.pcapng); of one that is being made, what there is of it."""
    it = library.folder.one(identity)
    if not library.is_growing(it):
        return FileResponse(it.path, media_type=_CAPTURE, filename=it.id)
    headers = {"Content-Length": str(it.bytes), "Content-Disposition": attachment(it.id)}
    return StreamingResponse(_beginning(it), media_type=_CAPTURE, headers=headers)


@router.get("/{identity}/export", response_class=Response, responses={**errors(404, 409), **_FILE})
async def export(
    library: TheLibrary,
    identity: str,
    *,
    format: Annotated[Format, Query()] = "csv",  # noqa: A002  (the contract's word)
    names: Annotated[str | None, Query(max_length=4000, description="A,B; all")] = None,
    dialect: Annotated[Literal["plain", "excel"], Query(description="of a CSV")] = "plain",
    lang: Language = "en",
) -> Response:
    """The recording as a table for other programs."""
    it = await asyncio.to_thread(library.folder.one, identity)
    wanted = tuple(name for name in (names or "").split(",") if name)
    folder = Path(await asyncio.to_thread(tempfile.mkdtemp, prefix="mikas-export-"))
    kind = "-excel" if (format, dialect) == ("csv", "excel") else ""
    out = folder / f"{it.path.stem}{kind}.{format}"
    try:
        await library.run_alone(
            lambda: _export(library, it, out, names=wanted, dialect=dialect, language=lang)
        )
    except BaseException:
        await asyncio.shield(asyncio.to_thread(_remove, folder))
        raise
    return _Temporary(out, media_type=_TYPES[format], filename=out.name)


@router.get("/{identity}/report", response_class=Response, responses={**errors(404, 409), **HTML})
async def report(
    library: TheLibrary, identity: str, lang: Language = "en", inline: bool = False
) -> Response:
    """A page on the car, made of the recording; to be kept, or `inline` to be looked at."""
    it = await asyncio.to_thread(library.folder.one, identity)
    page = await library.run_alone(lambda: _report(lambda: _of_recording(library, it), lang))
    return page_answer(page, f"{it.path.stem}.html", inline=inline)


def page_answer(page: str, name: str, *, inline: bool) -> Response:
    """A report as an answer: with the policy that it needs, and no more rights than paper has.

    `inline`: our own page may show it in a frame, and print it from there. Scripts run in neither.
    """
    from mikas.report.page import policy

    framing = "frame-ancestors 'none'; sandbox"
    headers = {}
    if inline:
        framing = "frame-ancestors 'self'; sandbox allow-same-origin allow-modals"
        headers["X-Frame-Options"] = "SAMEORIGIN"
    else:
        headers["Content-Disposition"] = attachment(name)
    headers["Content-Security-Policy"] = f"{policy()}; {framing}"
    return Response(page, media_type="text/html", headers=headers)


def attachment(name: str) -> str:
    """The header that makes a browser keep the answer under `name`."""
    return f"attachment; filename*=UTF-8''{quote(name, safe='')}"


def _of_recording(library: RecordingService, it: RecordingFile) -> Findings:
    from mikas.report.from_recording import of_recording

    return of_recording(it.path, library.catalog)


def _report(make: Callable[[], Findings], language: Language) -> str:
    from mikas.report.page import render

    return render(make(), language)


def _export(
    library: RecordingService,
    it: RecordingFile,
    out: Path,
    *,
    names: tuple[str, ...],
    dialect: str,
    language: Language,
) -> None:
    from mikas.recording.export import DIALECTS
    from mikas.recording.export import export as write
    from mikas.recording.recording import Recording

    recording = Recording(it.path, library.catalog, library.interpretation, names)
    write(
        out,
        recording.channels,
        recording.rows(),
        events=recording.events,
        about=recording.about,
        language=language,
        dialect=DIALECTS[dialect],
    )


async def _beginning(it: RecordingFile) -> AsyncIterator[bytes]:
    """As many bytes as the file had when it was found; it grows meanwhile."""
    left = it.bytes
    with await asyncio.to_thread(it.path.open, "rb") as opened:
        while left:
            data = await asyncio.to_thread(opened.read, min(left, _CHUNK))
            if not data:
                return
            left -= len(data)
            yield data


def _remove(folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
