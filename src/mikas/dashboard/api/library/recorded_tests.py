"""The route of a guided test over a recording.

It reads a whole file, as a report does, so it is work in the lane of files. Nothing is kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from fastapi import APIRouter, Path
from pydantic import BaseModel

from mikas.dashboard.api.dependencies import TheDashboard, TheRequester
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.api.guided_tests import TestVerdict, verdict_of
from mikas.dashboard.errors import NotFound
from mikas.dashboard.session.guided_tests import KeptResult

if TYPE_CHECKING:
    from mikas.guided.recorded import NotJudged
    from mikas.guided.result import TestResult

router = APIRouter(tags=["recordings"])


class RecordedTest(BaseModel):
    """A test over a recording. `result` null: there is none, for the reason `why`.

    `left_out`: the steps that no values show, so the test was done without them.
    """

    result: TestVerdict | None
    why: TwoTexts | None
    left_out: list[TwoTexts]


@router.get("/recordings/{identity}/tests/{name}", responses=errors(404, 409, 504))
async def recorded_test(
    dashboard: TheDashboard,
    requester: TheRequester,
    identity: str,
    name: Annotated[str, Path(max_length=80)],
) -> RecordedTest:
    """Return the verdict of a test over a recording, or why the recording gives none."""

    def work() -> RecordedTest:
        from mikas.guided.recorded import run_over

        test = dashboard.guided.available().tests.get(name)
        if test is None:
            raise NotFound(name=name)
        library = requester.library
        by_hand = [step for step in test.steps if step.by_hand]
        recording = library.opened(library.of_any(identity), latest=True)
        found = run_over(test, recording, [step.name for step in by_hand])
        return _answer(found, [two(step.text) for step in by_hand])

    return await requester.make(identity, work)


def _answer(found: TestResult | NotJudged, left_out: list[TwoTexts]) -> RecordedTest:
    from mikas.guided.recorded import NotJudged

    if isinstance(found, NotJudged):
        return RecordedTest(result=None, why=two(found.text), left_out=left_out)
    return RecordedTest(result=verdict_of(KeptResult("", found)), why=None, left_out=left_out)
