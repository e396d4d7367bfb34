"""What a recording says of itself, for the list and for one: the API's models, and how they are
made.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, Field

from mikas.dashboard.api.errors import TwoTexts, two_or_none
from mikas.dashboard.api.messages import RecordedEvent
from mikas.dashboard.library.folder import Shelved
from mikas.recording.recording import Recording
from mikas.recording.summary import Summary
from mikas.sampling.events import MethodChosen


class RecordingInfo(BaseModel):
    """One recording. Null is what is not known of it; `problem`: why it can't be read."""

    id: str = Field(description="the file's name")
    bytes: int
    date: float | None = Field(description="when it began; null: the clock was a simulated one")
    length: float | None
    model: TwoTexts | None
    passport: list[str | None] | None
    samples: int | None
    samples_exact: bool = Field(description="whether they were counted, not estimated")
    rate: float | None
    gaps: int | None
    faults: list[int] | None = Field(description="as last read in it; null: they were not read")
    markers: int | None
    note: str
    open: bool = Field(description="it is being made")
    problem: TwoTexts | None


class RecordingProblem(BaseModel):
    """A place that can't be read."""

    en: str
    ru: str
    offset: int


class RecordingDetail(RecordingInfo):
    """One recording with all that happened in it. `first`, `last`: its rows lie between them."""

    channels: list[str]
    first: float | None
    last: float | None
    events: list[RecordedEvent]
    problems: list[RecordingProblem]
    method: str | None


class RecordingsResponse(BaseModel):
    """The latest first. `problem`: why none can be kept in the folder, if so."""

    recordings: list[RecordingInfo]
    problem: TwoTexts | None


def listed(it: Shelved, summary: Summary, *, growing: bool) -> RecordingInfo:
    """As the list shows it."""
    return RecordingInfo(
        id=it.id,
        bytes=it.bytes,
        date=summary.date,
        length=summary.length,
        model=two_or_none(summary.model),
        passport=None if summary.passport is None else list(summary.passport),
        samples=summary.samples,
        samples_exact=summary.samples_exact,
        rate=None if summary.rate is None else round(summary.rate, 2),
        gaps=None if summary.problem else summary.gaps,
        faults=None if summary.faults is None else list(summary.faults),
        markers=None if summary.problem else summary.markers,
        note=summary.note,
        open=growing,
        problem=two_or_none(summary.problem),
    )


def detailed(
    it: Shelved, summary: Summary, recording: Recording | None, *, growing: bool
) -> dict[str, Any]:
    """Return a `RecordingDetail` as JSON, not validated: its events are what the file holds.

    `recording` None: it can't be read.
    """
    detail: dict[str, Any] = listed(it, summary, growing=growing).model_dump(mode="json")
    detail |= {"channels": [], "events": [], "problems": [], "method": None}
    if recording is None:
        return detail | {"first": None, "last": None}
    detail["first"], detail["last"] = _span(summary, recording)
    detail["channels"] = [channel.name for channel in recording.channels]
    detail["events"] = [event.as_json() for event in recording.events]
    detail["problems"] = [
        {"en": it.text.en, "ru": it.text.ru, "offset": it.offset} for it in recording.problems
    ]
    methods = [event.method for event in recording.events if isinstance(event, MethodChosen)]
    unit = summary.unit
    detail["method"] = methods[-1] if methods else unit.method if unit else None
    return detail


def _span(summary: Summary, recording: Recording) -> tuple[float | None, float | None]:
    """From the summary if that tells: the recording itself would have to be read for it."""
    if summary.recordings == 1 and summary.first is not None and summary.length is not None:
        return summary.first, summary.first + summary.length
    return recording.span or (None, None)
