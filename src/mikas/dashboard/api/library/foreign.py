"""The route by which a recording from elsewhere gets into the folder: sent, or of another computer.

It is written beside its name first, and has it once it is whole and a recording. No file is ever
replaced. Only this computer may add one: it fills the disk.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator
from contextlib import suppress
from pathlib import Path
from secrets import token_hex
from typing import Annotated, Final

from fastapi import APIRouter, Query, Request
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from mikas.dashboard.api.dependencies import GONE, LocalClient, TheLibrary
from mikas.dashboard.api.errors import errors
from mikas.dashboard.settings import ensure_folder
from mikas.errors import CaptureError, reason_of
from mikas.recording.capture.reader import CaptureReader

router = APIRouter(prefix="/recordings", tags=["recordings"])

_BODY: Final = {"requestBody": {"required": True, "content": {"application/octet-stream": {}}}}


class AddedRecording(BaseModel):
    """The recording that was added."""

    id: str = Field(description="the file's name: another than asked for if that was in use")


@router.post("", responses=errors(409), openapi_extra=_BODY)
async def add(
    library: TheLibrary,
    _: LocalClient,
    request: Request,
    name: Annotated[str, Query(max_length=300, description="of the file, elsewhere")],
) -> AddedRecording:
    """Add a recording made elsewhere, a .pcapng; the body is the file."""
    await asyncio.to_thread(ensure_folder, library.folder.folder)
    path = library.folder.new_path(name)
    new = path.with_name(f"{path.name}.{token_hex(4)}.new")  # of this request alone

    def keep() -> Path:
        CaptureReader(new)  # raises for other files
        return new.rename(library.folder.new_path(name))

    try:
        await _write(new, request.stream())
        kept = await asyncio.to_thread(keep)
    except ClientDisconnect:
        raise HTTPException(GONE, "the client has disconnected") from None
    except OSError as error:
        raise CaptureError(path.name, reason_of(error)) from error
    except CaptureError as error:
        raise CaptureError(path.name, error.problem) from error
    finally:
        with suppress(OSError):
            await asyncio.to_thread(new.unlink, missing_ok=True)
    return AddedRecording(id=kept.name)


async def _write(path: Path, parts: AsyncIterator[bytes]) -> None:
    with await asyncio.to_thread(path.open, "xb") as file:
        async for part in parts:
            await asyncio.to_thread(file.write, part)
        await asyncio.to_thread(file.flush)
        await asyncio.to_thread(os.fsync, file.fileno())
