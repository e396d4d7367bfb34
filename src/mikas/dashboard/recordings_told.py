"""What a recording says of itself, for the list and for one: the API's models, and how they are
made.
"""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, Field

from mikas.dashboard.api.errors import TwoTexts, two_or_none
from mikas.dashboard.library.folder import Shelved
from mikas.recording.happened import MethodChosen
from mikas.recording.opening import Recording
from mikas.recording.summary import Summary


class RecordingOut(BaseModel):
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


class ProblemOut(BaseModel):
    """A place that can't be read."""

    en: str
    ru: str
    offset: int


class RecordingDetail(RecordingOut):
    """One recording with all that happened in it. `first`, `last`: its rows lie between them."""

    channels: list[str]
    first: float | None
    last: float | None
    events: list[dict[str, Any]]
    problems: list[ProblemOut]
    method: str | None


class RecordingList(BaseModel):
    """The latest first. `problem`: why none can be kept in the folder, if so."""

    recordings: list[RecordingOut]
    problem: TwoTexts | None


def listed(it: Shelved, summary: Summary, *, growing: bool) -> RecordingOut:
    """As the list shows it."""
    return RecordingOut(
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
) -> RecordingDetail:
    """All of it; `recording` None: it can't be read."""
    base = listed(it, summary, growing=growing).model_dump()
    if recording is None:
        empty: dict[str, Any] = {"channels": [], "events": [], "problems": []}
        return RecordingDetail(**base, **empty, first=None, last=None, method=None)
    first, last = _span(summary, recording)
    methods = [event.method for event in recording.events if isinstance(event, MethodChosen)]
    return RecordingDetail(
        **base,
        channels=[channel.name for channel in recording.channels],
        first=first,
        last=last,
        events=[event.as_json() for event in recording.events],
        problems=[
            ProblemOut(en=it.text.en, ru=it.text.ru, offset=it.offset) for it in recording.problems
        ],
        method=methods[-1] if methods else summary.unit.method if summary.unit else None,
    )


def _span(summary: Summary, recording: Recording) -> tuple[float | None, float | None]:
    """From the summary if that tells: the recording itself would have to be read for it."""
    if summary.recordings == 1 and summary.first is not None and summary.length is not None:
        return summary.first, summary.first + summary.length
    return recording.span or (None, None)
