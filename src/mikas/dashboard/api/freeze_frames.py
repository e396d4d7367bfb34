"""Routes of the freeze frames: the values around the moment at which a fault was stored."""

from __future__ import annotations

from fastapi import APIRouter
from pydantic import BaseModel, Field

from mikas.catalog import Catalog
from mikas.dashboard.api.dependencies import Controller, TheDashboard, Viewer
from mikas.dashboard.api.errors import errors, made_of
from mikas.dashboard.api.messages import LiveRows
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.errors import NotFound
from mikas.dashboard.session.history import plain
from mikas.recording.freeze_frames import FreezeFrame, shown_first

router = APIRouter(tags=["unit"])


class FrameValue(BaseModel):
    """A channel's latest value at `seen`; lowest and highest between `without` and `seen`."""

    name: str
    value: float
    low: float
    high: float


class FreezeFrameInfo(BaseModel):
    """A fault that was not stored at `without` and was at `seen`, and the values of that moment."""

    id: str
    code: int
    without: float
    seen: float
    values: list[FrameValue]
    shown: list[str] = Field(description="the channels to show first, those of the fault in front")


class FreezeFramesResponse(BaseModel):
    """The latest first."""

    frames: list[FreezeFrameInfo]


class FreezeFrameRows(LiveRows):
    """The rows from five seconds before `without` to five seconds after `seen`."""

    id: str = Field(description="of the frame")


@router.get("/freeze-frames", responses=errors())
def freeze_frames(dashboard: TheDashboard, _: Viewer) -> FreezeFramesResponse:
    """Return the freeze frames of the connected unit, or of the last one."""
    return _response(dashboard)


@router.get("/freeze-frames/{identity}", responses=errors(404))
def freeze_frame(dashboard: TheDashboard, _: Viewer, identity: str) -> FreezeFrameRows:
    """Return the rows of one freeze frame."""
    for frame in dashboard.freeze_frames.frames:
        if frame.id == identity:
            values = [plain(column) for column in frame.values.values()]
            names, times = list(frame.values), list(frame.times)
            return FreezeFrameRows(id=identity, names=names, times=times, values=values)
    raise NotFound(name=identity)


@router.delete("/freeze-frames/{identity}", responses=errors(404, 409))
def delete_freeze_frame(
    dashboard: TheDashboard, _: Controller, identity: str
) -> FreezeFramesResponse:
    """Delete one freeze frame from this computer; the unit's fault stays."""
    if not dashboard.freeze_frames.delete(identity):
        raise NotFound(name=identity)
    return _response(dashboard)


def _response(dashboard: Dashboard) -> FreezeFramesResponse:
    frames = dashboard.freeze_frames.frames
    return FreezeFramesResponse(frames=[frame_info(it, dashboard.catalog) for it in frames])


def frame_info(frame: FreezeFrame, catalog: Catalog) -> FreezeFrameInfo:
    """Return the frame without its rows."""
    values = [made_of(FrameValue, it, name=name) for name, it in frame.then.items()]
    shown = shown_first(catalog.fault(frame.code), frame.then)
    return made_of(FreezeFrameInfo, frame, values=values, shown=shown)
