"""Routes of the survey of a real unit: start, state, answer a question, stop, content, save, file.

A survey has the port meanwhile, as a diagnosis has. The page asks for the state while it runs; the
person's answers come back by the question's number, so that a late one answers no other.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final, Literal

from fastapi import APIRouter
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.cleaning import public_port
from mikas.dashboard.api.dependencies import (
    Controller,
    KnownClient,
    TheDashboard,
    TheRequester,
    port_named,
)
from mikas.dashboard.api.errors import OptionalTexts, TwoTexts, content, errors, made_of
from mikas.dashboard.api.library.files import OpenFile
from mikas.dashboard.dashboard import Dashboard
from mikas.dashboard.error_responses import ErrorBody, body_of
from mikas.dashboard.errors import NotFound
from mikas.dashboard.library.folder import opened
from mikas.dashboard.session.survey_run import SurveyProgress, SurveyRun
from mikas.link.urls import parse
from mikas.survey import SurveyOptions

router: Final = APIRouter(prefix="/api/survey", tags=["survey"])

_ZIP: Final = "application/zip"
_ANY_ZIP: Final = "*.zip"

Regime = Literal["standing", "starting", "idle", "warm", "raised", "after"]


class SurveyConsents(BaseModel):
    """What the owner consents to."""

    passports: bool = Field(False, description="the texts of the passports may be kept")
    memory: bool = Field(False, description="memory may be read: 11 13 15 21 23 25 31")
    engine: bool = Field(True, description="the engine may be started")


class SurveyRequest(SurveyConsents):
    """`port` null: that of the connection, or the one likely adapter. Of a survey that goes on, the
    consents of its begin stay in force.
    """

    port: str | None = Field(None, max_length=500)
    voltmeter: float | None = Field(
        None,
        ge=6,
        le=18,
        description="V at the battery, ignition on, engine off; null: none, or ask going on",
    )


class SurveyAnswerRequest(BaseModel):
    """The answer to the question `id`: `done` to a `ready`, `figure` to a `number` (null: none)."""

    id: int
    done: bool = False
    figure: float | None = None


class SurveyPrompt(BaseModel):
    """A question to the person that waits for an answer. `name`: of the instrument."""

    id: int
    kind: Literal["ready", "number"]
    name: str
    text: TwoTexts
    unit: TwoTexts
    low: float
    high: float


class SurveyStepState(BaseModel):
    """The step under way. `done` of `of`; `of` 0: it does not count."""

    name: str
    title: TwoTexts
    regime: Regime
    place: int = Field(description="among `steps`, from 0")
    steps: int
    done: int
    of: int


class SavedSurvey(BaseModel):
    """A ZIP that was saved."""

    name: str
    bytes: int


class SurveyState(BaseModel):
    """The survey. `idle`: none is under way; `stopped`: it can go on, or be saved as it is;
    `finished`: all is asked, and it can be saved.
    """

    phase: Literal["idle", "running", "stopped", "finished"]
    port: str | None = Field(description="while it runs")
    virtual: bool = Field(description="of a virtual car: for trying, not for sending")
    step: SurveyStepState | None = Field(description="null: none, or the port is being opened")
    instruction: OptionalTexts = Field(
        description="what the person shall do, while the car is waited for"
    )
    asked: SurveyPrompt | None
    found: int = Field(description="questions about the unit that it has answered")
    open: int = Field(description="questions that it has not")
    left: float | None = Field(description="seconds of measuring, without the person's own")
    consents: SurveyConsents | None = Field(description="in force; null: none is under way")
    error: ErrorBody | None = Field(description="why it ended before its end")
    saved: SavedSurvey | None = Field(description="the ZIP that was saved last")


class SurveyAnswerInfo(BaseModel):
    """The answer to one question about the unit."""

    id: str
    clauses: list[str]
    verdict: Literal["found", "open", "not-asked"]
    title: TwoTexts
    text: TwoTexts


class SurveyMemberInfo(BaseModel):
    """A file in the ZIP. `text` null: bytes of the line, which are no text."""

    name: str
    bytes: int
    text: str | None


class SurveyResult(BaseModel):
    """All that the ZIP would hold now."""

    answers: list[SurveyAnswerInfo]
    members: list[SurveyMemberInfo]


@router.get("", responses=errors(409, 504), response_model=SurveyState)
async def state(requester: TheRequester) -> Response:
    """Return the state of the survey."""
    return await requester.answer(lambda: _state(requester.dashboard))


@router.post("/start", responses=errors(409, 503))
async def start(dashboard: TheDashboard, client: Controller, body: SurveyRequest) -> SurveyState:
    """Start a survey, or go on with the one that was stopped."""
    port = await port_named(dashboard, client, body.port)
    if port is None:
        kept = dashboard.connection.port
        port = kept.url if kept is not None else dashboard.connection.likely()
    parse(port)
    options = SurveyOptions(memory=body.memory, passports=body.passports, engine=body.engine)
    dashboard.surveys.start(port, options, {"voltmeter": body.voltmeter})
    return _state(dashboard)


@router.post("/answer", responses=errors(409))
async def answer(dashboard: TheDashboard, _: Controller, body: SurveyAnswerRequest) -> SurveyState:
    """Answer the question that waits."""
    run = _running(dashboard)
    asked = run.shown.asked
    is_number = asked is not None and asked.kind == "number"
    run.answer(body.id, body.figure if is_number else body.done)
    return _state(dashboard)


@router.post("/stop", responses=errors(409))
async def stop(dashboard: TheDashboard, _: Controller) -> SurveyState:
    """Stop the survey, if one runs; responds when its port is free. What was measured is kept."""
    await dashboard.surveys.stop()
    return _state(dashboard)


@router.get("/result", responses=errors(404, 409, 504), response_model=SurveyResult)
async def result(requester: TheRequester) -> Response:
    """Return all that the ZIP would hold: what the person sees before it is saved."""

    def work() -> SurveyResult:
        found = requester.dashboard.surveys.content()
        answers = [
            made_of(SurveyAnswerInfo, each, clauses=list(each.clauses), verdict=each.verdict.value)
            for each in found.answers
        ]
        members = [made_of(SurveyMemberInfo, each) for each in found.members]
        return SurveyResult(answers=answers, members=members)

    return await requester.answer(work)


@router.post("/save", responses=errors(404, 409, 504), response_model=SurveyState)
async def save(requester: TheRequester, _: KnownClient) -> Response:
    """Save the survey as one ZIP; questions that were not measured stay open in it."""

    def work() -> SurveyState:
        requester.dashboard.surveys.save()
        return _state(requester.dashboard)

    return await requester.answer(work)


@router.delete("", responses=errors(409))
def forget(dashboard: TheDashboard, _: Controller) -> SurveyState:
    """Remove what was measured and not saved."""
    dashboard.surveys.forget()
    return _state(dashboard)


@router.get(
    "/file", response_class=Response, responses=errors(404) | content(_ZIP, "the latest ZIP")
)
def file(dashboard: TheDashboard) -> Response:
    """Return the ZIP that was saved last."""
    saved = dashboard.surveys.saved()
    if saved is None:
        raise NotFound(name=_ANY_ZIP)
    return OpenFile(opened(saved, saved.name), saved.name, _ZIP)


def _running(dashboard: Dashboard) -> SurveyRun:
    run = dashboard.surveys.latest
    if run is None or not dashboard.surveys.runs:
        raise NotFound(name="survey")
    return run


def _state(dashboard: Dashboard) -> SurveyState:
    surveys = dashboard.surveys
    runs, run, shown = surveys.runs, surveys.latest, SurveyProgress()
    error = surveys.error  # read after `runs`: in another thread the run may end meanwhile
    shared: dict[str, object] = {
        "port": None,
        "step": None,
        "consents": None,
        "virtual": surveys.virtual,
        "error": body_of(error) if error else None,
        "saved": _saved(surveys.saved()),
    }
    if runs and run is not None:
        shown = run.shown
        shared |= {"port": public_port(run.url), "step": _step(shown), "consents": run.options}
        return made_of(SurveyState, shown, **shared, phase="running")
    kept = surveys.under_way()
    if kept is None:
        return made_of(SurveyState, shown, **shared, phase="idle")
    shared |= {"found": kept.found, "open": kept.open, "consents": kept}
    phase = "finished" if kept.finished else "stopped"
    return made_of(SurveyState, shown, **shared, phase=phase)


def _step(shown: SurveyProgress) -> SurveyStepState | None:
    step = shown.step
    if step is None:
        return None
    regime = step.state.value
    return made_of(SurveyStepState, shown, name=step.name, title=step.title, regime=regime)


def _saved(file: Path | None) -> SavedSurvey | None:
    return None if file is None else SavedSurvey(name=file.name, bytes=file.stat().st_size)
