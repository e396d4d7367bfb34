"""Routes of recordings as files: the capture itself, and the formats of other programs.

Exports run in a thread, in the lane of files; two at once leave sampling its share of the computer.
The result is a temporary file, deleted once it is sent or the client has disconnected. Until then
it holds its client's place in the lane.
"""

from __future__ import annotations

import asyncio
import shutil
import tempfile
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Annotated, Final, Literal

from fastapi import APIRouter, Query
from fastapi.responses import FileResponse, Response
from starlette.types import Receive, Scope, Send

from mikas.dashboard.api.dependencies import Names, TheLibrary, TheRequester, split_names
from mikas.dashboard.api.errors import content, errors
from mikas.dashboard.api.library.downloads import OpenFile
from mikas.i18n import Language

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
_FILE: Final = content("application/octet-stream", "the file")


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


@router.get("/{identity}/file", response_class=Response, responses=errors(404) | _FILE)
def file(library: TheLibrary, identity: str) -> Response:
    """Return the recording itself (.pcapng); of one in progress, the part written so far."""
    found = library.folder.one(identity)
    return OpenFile(library.folder.open(found), found.id, _CAPTURE)


@router.get("/{identity}/export", response_class=Response, responses=errors(404, 409, 504) | _FILE)
async def export(
    requester: TheRequester,
    identity: str,
    *,
    format: Annotated[Format, Query()] = "csv",  # noqa: A002  (the contract's word)
    names: Names = None,
    dialect: Annotated[Literal["plain", "excel"], Query(description="of a CSV")] = "plain",
    lang: Language = "en",
) -> Response:
    """Return the recording as a table for other programs."""
    library = requester.library
    source = await asyncio.to_thread(library.folder.one, identity)
    wanted = tuple(split_names(names) or ())
    kind = "-excel" if (format, dialect) == ("csv", "excel") else ""

    def write(out: Path) -> None:
        from mikas.recording.export import DIALECTS
        from mikas.recording.export import export as write_table

        opened = library.opened(source, latest=True)
        recording = opened.interpreted(library.interpretation, wanted)
        write_table(
            out,
            recording.channels,
            recording.rows(),
            events=recording.events,
            about=recording.about,
            language=lang,
            dialect=DIALECTS[dialect],
        )

    async with AsyncExitStack() as resources:
        resources.enter_context(library.files.place(requester.address))
        folder = Path(tempfile.mkdtemp(prefix="mikas-export-"))
        resources.push_async_callback(_delete, folder)
        out = folder / f"{source.path.stem}{kind}.{format}"
        await requester.awaits(
            library.files.run(lambda: write(out), key=source.id, address=requester.address)
        )
        return _Temporary(out, resources.pop_all(), media_type=_TYPES[format], filename=out.name)
