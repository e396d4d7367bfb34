"""Routes of references: recordings that others are compared with.

The user marks them; those of the virtual car have ids of their own, by which `/recordings/{id}`
and its rows are read like any other.
"""

from __future__ import annotations

from typing import Final

from fastapi import APIRouter
from fastapi.responses import Response
from pydantic import BaseModel

from mikas.dashboard.api.dependencies import KnownClient, TheRequester
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.library.folder import RecordingFile
from mikas.dashboard.library.service import DRIVES, VIRTUAL, RecordingService

router: Final = APIRouter(prefix="/api", tags=["recordings"])


class VirtualReferenceInfo(BaseModel):
    """A recording of the virtual car, not measured on an engine. `model`: 7.1, 5.4."""

    id: str
    model: str
    text: TwoTexts


class ReferencesResponse(BaseModel):
    """`marked`: ids of recordings, the latest mark first; the file may be gone since."""

    marked: list[str]
    virtual: list[VirtualReferenceInfo]


class ReferenceRequest(BaseModel):
    """`on`: the recording is a reference."""

    on: bool


@router.get("/references", responses=errors(409, 504), response_model=ReferencesResponse)
async def references(requester: TheRequester) -> Response:
    """Return the marked recordings, and those of the virtual car.

    The latter are made when they are first read, which takes seconds.
    """
    return await requester.answer(lambda: _references(requester.library))


def _references(library: RecordingService) -> ReferencesResponse:
    virtual = [
        VirtualReferenceInfo(id=identity, model=model, text=two(DRIVES[drive].text))
        for identity, (drive, model) in VIRTUAL.items()
    ]
    return ReferencesResponse(marked=library.references.marked(), virtual=virtual)


@router.put("/recordings/{identity}/reference", responses=errors(404, 409, 504))
async def mark(
    requester: TheRequester, _: KnownClient, identity: str, body: ReferenceRequest
) -> ReferencesResponse:
    """Mark a recording as a reference, or remove its mark."""

    def write(file: RecordingFile) -> ReferencesResponse:
        requester.library.references.mark(file.id, on=body.on)
        return _references(requester.library)

    return await requester.view(identity, write)
