"""Routes of the guided tests: the list, the running one, and the kept results.

The page asks for `/tests/run` some times a second; the watched values come with it.
"""

from __future__ import annotations

from typing import Annotated, Final

from fastapi import APIRouter, Path
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.dashboard.api.dependencies import (
    Controller,
    KnownClient,
    TheDashboard,
    TheRequester,
)
from mikas.dashboard.api.errors import OptionalTexts, TwoTexts, errors, made_of
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.session.guided_tests import KeptResult
from mikas.guided.definition import Certainty, VerdictKind
from mikas.guided.engine import ProgressPhase

router: Final = APIRouter(prefix="/api/tests", tags=["tests"])

Name = Annotated[str, Path(max_length=80)]


class _Model(BaseModel):
    __test__ = False  # for pytest


class TestStep(_Model):
    """A step. `targets`: by channel, where its value belongs."""

    name: str
    text: TwoTexts
    hold: float
    watch: list[str]
    targets: dict[str, tuple[float, float]]


class LastOutcome(BaseModel):
    """The latest result of a test on this unit."""

    id: str
    outcome: VerdictKind
    ended: float


class TestInfo(_Model):
    """A test. `own`: from the user's folder; `needs`: what must be so before its first step."""

    name: str
    title: TwoTexts
    finds: TwoTexts
    needs: OptionalTexts
    minutes: float
    own: bool
    steps: list[TestStep]
    last: LastOutcome | None


class TestFileError(_Model):
    """A file of the user's folder that is no test. `line` 0: the file as a whole."""

    file: str
    line: int
    text: TwoTexts


class TestList(_Model):
    """All tests. `running`: the name of the one that runs; `folder`: of the user's tests."""

    tests: list[TestInfo]
    errors: list[TestFileError]
    running: str | None
    folder: str | None


class TestNumber(_Model):
    """A measure. `value` null: not measured, for the reason `why`. `rate`: readings a second."""

    name: str
    text: TwoTexts
    value: float | None
    shown: TwoTexts
    count: int
    rate: float
    why: TwoTexts


class TestFinding(_Model):
    """A rule that holds."""

    rule: str
    formula: str
    outcome: VerdictKind
    text: TwoTexts
    check: TwoTexts
    doubt: TwoTexts
    confidence: Certainty


class TestCurve(_Model):
    """A channel over the test: lowest and highest from each time to the next."""

    name: str
    text: TwoTexts
    unit: TwoTexts
    times: list[float]
    lows: list[float]
    highs: list[float]


class TestStepDone(_Model):
    """A step and its time."""

    name: str
    text: TwoTexts
    began: float
    ended: float
    skipped: bool


class TestVerdict(_Model):
    """A result. `missing`: why rules could not be decided; `as_text`: all of it as lines."""

    id: str
    test: str
    title: TwoTexts
    began: float
    ended: float
    outcome: VerdictKind
    verdict: TwoTexts
    findings: list[TestFinding]
    missing: list[TwoTexts]
    numbers: list[TestNumber]
    steps: list[TestStepDone]
    curves: list[TestCurve]
    as_text: TwoTexts
    in_report: bool


class TestUnmet(_Model):
    """A channel whose value keeps the test waiting: `sign` and `limit` are the comparison that has
    to hold, as a sentence in `text`. `value` null: there is none just now.
    """

    name: str
    value: float | None
    sign: str
    limit: float | None
    text: TwoTexts


class TestRun(_Model):
    """The test that runs, or has finished with `result`.

    `phase`: what it waits for; `step`: from 0, null before the first. `held` of `hold` seconds the
    step's condition has held; `late`: show the `advice`. `unmet`: what keeps it waiting; `lacking`:
    parameters without values now.
    """

    name: str
    title: TwoTexts
    needs: OptionalTexts
    phase: ProgressPhase
    step: int | None
    steps: list[TestStep]
    seconds: float
    held: float
    hold: float
    prepare: float
    late: bool
    advice: OptionalTexts
    values: dict[str, float]
    unmet: list[TestUnmet]
    lacking: list[str]
    result: TestVerdict | None


class TestRunState(_Model):
    """The run; null: no test runs."""

    run: TestRun | None


class TestResults(_Model):
    """The kept results of this unit, the latest first."""

    results: list[TestVerdict]


class InReportRequest(BaseModel):
    """Whether the result is shown in the report on the connected car."""

    in_report: bool = Field(strict=True)


@router.get("", responses=errors(409, 504), response_model=TestList)
async def tests(requester: TheRequester) -> Response:
    """Return all tests, the user's files read again."""
    return await requester.answer(lambda: _tests(requester.dashboard))


def _tests(dashboard: Dashboard) -> TestList:
    guided = dashboard.guided
    found, state = guided.available(), guided.progress
    last: dict[str, LastOutcome] = {}
    for kept in guided.results:
        it = kept.result
        last.setdefault(it.test, LastOutcome(id=kept.identity, outcome=it.outcome, ended=it.ended))
    running = state[0].test.name if state and state[0].result is None else None
    folder = dashboard.settings.tests
    return TestList(
        tests=[made_of(TestInfo, test, last=last.get(test.name)) for test in found.tests.values()],
        errors=[made_of(TestFileError, it, text=it.problem) for it in found.errors],
        running=running,
        folder=None if folder is None else str(folder),
    )


@router.get("/run", responses=errors())
def run(dashboard: TheDashboard) -> TestRunState:
    """Return the state of the running or finished test."""
    found = dashboard.guided.progress
    if found is None:
        return TestRunState(run=None)
    engine, progress, kept = found
    test = engine.test
    step = test.steps[progress.step] if progress.step is not None else None
    return TestRunState(
        run=made_of(
            TestRun,
            progress,
            name=test.name,
            title=test.title,
            needs=test.needs,
            steps=test.steps,
            prepare=step.prepare if step else 0.0,
            advice=step.advice if step else None,
            values=dict(progress.values),
            result=verdict_of(kept) if kept else None,
        )
    )


@router.post("/{name}/start", responses=errors(404, 409))
def start(dashboard: TheDashboard, _: Controller, name: Name) -> TestRunState:
    """Start a test; it takes the values that are sampled from now on."""
    dashboard.guided.start(name)
    return run(dashboard)


@router.post("/run/skip", responses=errors(409))
def skip(dashboard: TheDashboard, _: Controller) -> TestRunState:
    """Skip the present step; without its numbers nothing can be good."""
    dashboard.guided.skip()
    return run(dashboard)


@router.post("/run/cancel", responses=errors(409))
def cancel(dashboard: TheDashboard, _: Controller) -> TestRunState:
    """End the test without a result, or put a finished one away."""
    dashboard.guided.cancel()
    return run(dashboard)


@router.get("/results", responses=errors(409, 504), response_model=TestResults)
async def results(requester: TheRequester) -> Response:
    """Return the kept results of this unit."""
    guided = requester.dashboard.guided
    return await requester.answer(
        lambda: TestResults(results=[verdict_of(kept) for kept in guided.results])
    )


@router.put("/results/{name}", responses=errors(404))
def put_in_report(
    dashboard: TheDashboard, _: KnownClient, name: Name, body: InReportRequest
) -> TestVerdict:
    """Put a result into the report on the connected car, or take it out."""
    return verdict_of(dashboard.guided.put_in_report(name, wanted=body.in_report))


def verdict_of(kept: KeptResult) -> TestVerdict:
    """Return a result for the page."""
    result = kept.result
    more = {"id": kept.identity, "in_report": kept.in_report, "as_text": result.as_text()}
    return made_of(TestVerdict, result, **more)
