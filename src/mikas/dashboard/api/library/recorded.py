"""Routes of what a recording shows: its faults with their freeze frames, a guided test over it.

The rows around a frame's moment are those of `GET /recordings/ID/rows`. A test reads a whole file,
as a report does, so it is work in the lane of files. Nothing is kept.
"""

from __future__ import annotations

from math import inf
from typing import Annotated, Final

from fastapi import APIRouter, Path
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.catalog import Catalog
from mikas.dashboard.api.dependencies import TheRequester, json_of
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.api.guided_tests import TestVerdict, verdict_of
from mikas.dashboard.api.unit import FreezeFrameInfo, StoredFault, fault_info, frame_info
from mikas.dashboard.errors import NotFound
from mikas.dashboard.session.guided_tests import KeptResult
from mikas.i18n import Text
from mikas.recording.capture.notes import Kind
from mikas.recording.freeze_frames import first_seen
from mikas.recording.recorded_faults import RecordedFaults, faults_in
from mikas.recording.recording import Recording

router: Final = APIRouter(prefix="/api", tags=["recordings"])


class RecordedFault(StoredFault):
    """A fault that was stored at the last reading; `first_seen` is the time of a reading."""

    stored_before: bool = Field(description="a reading before the recording, or its first, had it")


class RecordedFaultsResponse(BaseModel):
    """The faults of a recording's last session at the last reading; null: they were not read.

    `frames`: of all faults that appeared, the latest first, at most thirty.
    """

    time: float | None
    faults: list[RecordedFault] | None
    frames: list[FreezeFrameInfo]


@router.get(
    "/recordings/{identity}/faults",
    responses=errors(404, 409, 504),
    response_model=RecordedFaultsResponse,
)
async def recorded_faults(requester: TheRequester, identity: str) -> Response:
    """Return the faults in a recording, and the values of the moments at which they appeared."""
    opened = requester.library.opened
    return await requester.view(
        identity, lambda file: json_of(_response(opened(file))), virtual=True
    )


def _response(recording: Recording) -> RecordedFaultsResponse:
    found, catalog = faults_in(recording), recording.catalog
    began = max((note.time for note in recording.notes if note.kind == Kind.FAULTS), default=-inf)
    frames = [each.frame for each in found.appeared if each.frame is not None]
    last = found.readings[-1] if found.readings else None
    return RecordedFaultsResponse(
        time=last.time if last else None,
        faults=[_fault(code, found, catalog, began) for code in dict.fromkeys(last.codes)]
        if last
        else None,
        frames=[frame_info(frame, catalog) for frame in frames],
    )


def _fault(code: int, found: RecordedFaults, catalog: Catalog, began: float) -> RecordedFault:
    first = first_seen(code, found.readings)
    appeared = next((each for each in found.appeared if each.code == code), None)
    frame = appeared.frame if appeared and appeared.read == first else None
    return RecordedFault(
        **fault_info(catalog.fault(code), first, frame.id if frame else None).model_dump(),
        stored_before=first <= max(began, found.readings[0].time),
    )


class RecordedTest(BaseModel):
    """A test over a recording. `result` null: there is none, for the reason `why`.

    `left_out`: the steps that no values show, so the test was done without them.
    """

    result: TestVerdict | None
    why: TwoTexts | None
    left_out: list[TwoTexts]


@router.get(
    "/recordings/{identity}/tests/{name}",
    responses=errors(404, 409, 504),
    response_model=RecordedTest,
)
async def recorded_test(
    requester: TheRequester, identity: str, name: Annotated[str, Path(max_length=80)]
) -> Response:
    """Return the verdict of a test over a recording, or why the recording gives none."""

    def work() -> RecordedTest:
        from mikas.guided.recorded import run_over

        test = requester.dashboard.guided.available().tests.get(name)
        if test is None:
            raise NotFound(name=name)
        library = requester.library
        by_hand = [step for step in test.steps if step.by_hand]
        recording = library.opened(library.of_any(identity), latest=True)
        found = run_over(test, recording, [step.name for step in by_hand])
        return RecordedTest(
            result=None if isinstance(found, Text) else verdict_of(KeptResult("", found)),
            why=two(found) if isinstance(found, Text) else None,
            left_out=[two(step.text) for step in by_hand],
        )

    return await requester.make(identity, lambda: json_of(work()))
