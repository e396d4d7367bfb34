"""Routes of other programs' logs: what one has, and its values, to compare a recording with.

The body is the file, which is kept nowhere: the client sends it again with what the user has chosen
in the dialog. Columns are chosen by their places in the preview; names and units are the file's,
and no channel of ours is made of them. Only this computer may send one: it takes memory.
"""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal

from fastapi import APIRouter, Depends, Query, Request
from fastapi.responses import JSONResponse, Response
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect

from mikas.dashboard.api.dependencies import GONE, LocalClient, TheRequester, json_of
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.errors import BadRequest
from mikas.dashboard.session.history import json_columns
from mikas.foreign_logs import (
    MOST_BYTES,
    ForeignLog,
    LogChoice,
    LogPreview,
    TextSettings,
)
from mikas.foreign_logs.apart import preview_apart, read_apart
from mikas.i18n import Text

router: Final = APIRouter(prefix="/api/foreign-logs", tags=["recordings"])

TimeUnit = Literal[
    "s", "ms", "us", "min", "h", "d", "clock", "date", "date-dmy", "date-mdy"
]  # fmt: skip
Encoding = Literal["utf-8", "windows-1251", "utf-16", "windows-1252"]
_BODY: Final = {"requestBody": {"required": True, "content": {"application/octet-stream": {}}}}
_MOST_SENT: Final = 1_200_000  # values: 12 MB of JSON
_LEAST_POINTS: Final = 2000
_WORK: Final = "a log of another program"  # no file has this name

FileName = Annotated[str, Query(max_length=300, description="of the file; its suffix counts")]
Places = Annotated[
    str | None,
    Query(max_length=8000, pattern=r"^\d{1,4}(,\d{1,4})*$", description="0,2,5; all if absent"),
]


class ForeignColumnInfo(BaseModel):
    """A column of the file. `samples`: its first cells as in the file; of text only."""

    name: str
    unit: str
    samples: list[str]


class ForeignLayout(BaseModel):
    """How a log of text is laid out, recognised or as requested. Lines count from 1; 0: none.

    `time`, `time_unit` null: the file leaves it open, the user has to say.
    """

    encoding: str
    delimiter: str
    decimal: str
    names_line: int
    units_line: int
    time: int | None
    time_unit: str | None


class ForeignPreview(BaseModel):
    """What a log has. `layout` null: it is no text, and has a time of its own."""

    format: Literal["csv", "msl", "mlg", "mdf"]
    columns: list[ForeignColumnInfo]
    layout: ForeignLayout | None


class ForeignMarkInfo(BaseModel):
    """A mark of the log, at a time of its own clock."""

    time: float
    text: str


class ForeignValues(BaseModel):
    """The values, as columns over time (seconds on the log's clock); null: none in that row.

    `decimated`: only the minimum and maximum of each column in each interval. `rows`: of the file.
    `started`: its date, UNIX seconds; null: it has none. `problems`: what was not taken.
    """

    format: str
    names: list[str]
    units: list[str]
    times: list[float]
    values: list[list[float | None]]
    rows: int = Field(ge=0)
    decimated: bool
    started: float | None
    marks: list[ForeignMarkInfo]
    problems: list[TwoTexts]


def _settings(
    *,
    encoding: Annotated[Encoding | None, Query(description="recognised if absent")] = None,
    delimiter: Annotated[
        str | None, Query(min_length=1, max_length=1, description="recognised if absent")
    ] = None,
    decimal: Annotated[Literal[".", ","] | None, Query(description="recognised if absent")] = None,
    names_line: Annotated[int | None, Query(ge=0, le=1000)] = None,
    units_line: Annotated[int | None, Query(ge=0, le=1000)] = None,
) -> TextSettings:
    return TextSettings(encoding, delimiter, decimal, names_line, units_line)


Settings = Annotated[TextSettings, Depends(_settings)]


@router.post(
    "/preview", responses=errors(409, 504), response_model=ForeignPreview, openapi_extra=_BODY
)
async def preview(
    requester: TheRequester, _: LocalClient, request: Request, name: FileName, settings: Settings
) -> Response:
    """Return what a log has, and how a log of text is laid out; the body is the file."""
    data = await _whole(request)
    return await requester.make(_WORK, lambda: json_of(_shown(preview_apart(data, name, settings))))


@router.post(
    "/values", responses=errors(409, 504), response_model=ForeignValues, openapi_extra=_BODY
)
async def values(
    requester: TheRequester,
    _: LocalClient,
    request: Request,
    name: FileName,
    settings: Settings,
    *,
    time: Annotated[int | None, Query(ge=0, le=9999, description="the column's place")] = None,
    time_unit: TimeUnit | None = None,
    columns: Places = None,
) -> Response:
    """Return a log's values; the body is the file."""
    data = await _whole(request)

    def work() -> Response:
        choice = LogChoice(settings, time_unit=time_unit)
        if columns is not None or time is not None:
            names = [column.name for column in preview_apart(data, name, settings).columns]
            wanted = None if columns is None else dict.fromkeys(_named(names, columns))
            when = None if time is None else _named(names, str(time))[0]
            choice = LogChoice(settings, when, time_unit, wanted)
        return JSONResponse(_values(read_apart(data, name, choice)))

    return await requester.make(_WORK, work)


async def _whole(request: Request) -> bytes:
    """Return the body, which is no longer than `MOST_BYTES`: the middleware has seen to it."""
    data = bytearray()
    try:
        async for part in request.stream():
            data += part
            if len(data) > MOST_BYTES:
                break  # the reader says that it is too large
    except ClientDisconnect:
        raise HTTPException(GONE, "the client has disconnected") from None
    return bytes(data)


def _named(names: list[str], places: str) -> list[str]:
    found = [int(place) for place in places.split(",")]
    if max(found) >= len(names):
        problem = Text(f"the file has {len(names)} columns", f"в файле столбцов: {len(names)}")
        raise BadRequest(problem=problem)
    return [names[place] for place in found]


def _shown(preview: LogPreview) -> ForeignPreview:
    layout = preview.layout
    return ForeignPreview.model_validate(
        {
            "format": preview.format,
            "columns": [
                {"name": it.name, "unit": it.unit, "samples": list(it.samples)}
                for it in preview.columns
            ],
            "layout": layout,
        },
        from_attributes=True,
    )


def _values(log: ForeignLog) -> dict[str, Any]:
    """Return a `ForeignValues` as JSON, not validated: a million values are not looked at twice."""
    import numpy as np

    from mikas.recording.table.channels import Rows
    from mikas.recording.table.decimation import decimated

    columns = {column.name: np.array(list(column.values)) for column in log.columns}
    rows = Rows(np.array(list(log.times)), columns)
    points = max(_LEAST_POINTS, _MOST_SENT // (len(columns) + 1))
    shown = decimated(rows, points)
    return json_columns(shown.times, shown.values) | {
        "format": log.format,
        "units": [column.unit for column in log.columns],
        "rows": len(log),
        "decimated": len(log) > max(2, points),
        "started": None if log.started is None else log.started.timestamp(),
        "marks": [{"time": mark.time, "text": mark.text} for mark in log.marks],
        "problems": [two(problem.text).model_dump() for problem in log.problems],
    }
