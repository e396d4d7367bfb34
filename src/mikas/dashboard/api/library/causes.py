"""Routes of the causes: of the running connection's last hours, of a recording or several.

Reading whole files and ranking takes seconds, so it is work in the lane of files, as a report is.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import Response
from pydantic import BaseModel, Field

from mikas.causes.knowledge import COMPLAINTS, Complaint, Knowledge, load
from mikas.causes.result import (
    LIKELIHOODS,
    CauseVerdict,
    Evidence,
    Likelihood,
    NextMeasurement,
    RankedCause,
    Ranking,
)
from mikas.dashboard.api.dependencies import TheRequester, json_of
from mikas.dashboard.api.errors import TwoTexts, errors, two
from mikas.dashboard.api.library.report import of_this_unit, ranked, without_other_readings
from mikas.dashboard.errors import NotConnected
from mikas.dashboard.session.history import LONGEST

if TYPE_CHECKING:
    from mikas.dashboard.dashboard import Dashboard

router: Final = APIRouter(prefix="/api", tags=["recordings"])

_LIVE: Final = "the causes of the running connection"  # no file has this name
_MOST: Final = 20  # recordings of a car

Complained = Annotated[Complaint | None, Query(description="what the owner complains of")]


class CauseMoment(BaseModel):
    """A span of time in which an evidence was seen, UNIX seconds."""

    begin: float
    end: float


class CauseEvidence(BaseModel):
    """What speaks for or against a cause; `low`, `high`: what sound cars have.

    `recording`: the id of the recording it is from; null: the running connection.
    """

    feature: str
    text: TwoTexts
    value: float
    low: float
    high: float
    recording: str | None
    moments: list[CauseMoment]


class CauseInfo(BaseModel):
    """A cause. `likely`: its likelihood in words."""

    id: str
    variant: str
    likelihood: Likelihood
    likely: TwoTexts
    text: TwoTexts
    check: TwoTexts
    speaks_for: list[CauseEvidence]
    speaks_against: list[CauseEvidence]


class CauseOutcome(BaseModel):
    """What a measurement may find, and the cause that speaks for: its id, and its text."""

    text: TwoTexts
    cause: str
    means: TwoTexts


class CauseMeasurement(BaseModel):
    """What to measure next; `guided`: `test` is the name of a guided test. `outcomes`: of a test by
    hand.
    """

    test: str
    guided: bool
    text: TwoTexts
    why: TwoTexts
    outcomes: list[CauseOutcome]


class ComplaintInfo(BaseModel):
    """A complaint that an owner may have."""

    name: Complaint
    text: TwoTexts


class CauseFileError(BaseModel):
    """A file of the user's causes that is none; line 0: the file as a whole."""

    file: str
    line: int
    text: TwoTexts


class CausesResponse(BaseModel):
    """The causes of one car, the likeliest first. `seconds`: of data.

    `complaints`: all that can be asked for; `errors`: the wrong files of the user's folder.
    """

    verdict: CauseVerdict
    text: TwoTexts
    causes: list[CauseInfo]
    next: list[CauseMeasurement]
    not_seen: list[TwoTexts]
    doubts: list[TwoTexts]
    seconds: float = Field(ge=0)
    complaints: list[ComplaintInfo]
    errors: list[CauseFileError]


@router.get("/causes", responses=errors(409, 503, 504), response_model=CausesResponse)
async def causes(requester: TheRequester, complaint: Complained = None) -> Response:
    """Return the causes for what the connected car showed in the last two hours."""
    work = partial(_of_connection, requester.dashboard, complaint)
    return await requester.make(_LIVE, lambda: json_of(work()))


@router.get(
    "/recordings/{identity}/causes",
    responses=errors(404, 409, 504),
    response_model=CausesResponse,
)
async def recorded_causes(
    requester: TheRequester,
    identity: str,
    complaint: Complained = None,
    more: Annotated[
        list[str], Query(alias="with", max_length=_MOST, description="more of the same car")
    ] = [],  # noqa: B006  (FastAPI copies it)
) -> Response:
    """Return the causes for a recording, or several of one car; 400 for those of different cars."""
    dashboard, library = requester.dashboard, requester.library

    def work() -> CausesResponse:
        from mikas.causes.recorded import rank_recordings

        names = list(dict.fromkeys([identity, *more]))
        knowledge = load(dashboard.settings.causes)
        recordings = [library.opened(library.of_any(name), latest=True) for name in names]
        ranking = rank_recordings(recordings, complaint=complaint, knowledge=knowledge)
        return _response(ranking, knowledge, names)

    return await requester.make(identity, lambda: json_of(work()))


def _of_connection(dashboard: Dashboard, complaint: Complaint | None) -> CausesResponse:
    from mikas.recording.table.channels import Rows

    monitor, later = dashboard.monitor, dashboard.session.later
    with monitor.lock:
        unit, events = monitor.unit, monitor.logged
    rows, _ = of_this_unit(dashboard.history.rows(LONGEST), events)
    if unit is None and not len(rows.times):
        raise NotConnected
    interpretation = dashboard.settings.connection.interpretation
    rows = without_other_readings(
        Rows(rows.times + later, rows.values), dashboard.catalog, interpretation
    )
    knowledge = load(dashboard.settings.causes)
    return _response(ranked(dashboard, rows, complaint), knowledge, ())


def _response(ranking: Ranking, knowledge: Knowledge, names: Sequence[str]) -> CausesResponse:
    return CausesResponse(
        verdict=ranking.verdict,
        text=two(ranking.text),
        causes=[_cause(each, names) for each in ranking.causes],
        next=[_measurement(each) for each in ranking.next],
        not_seen=[two(each) for each in ranking.not_seen],
        doubts=[two(each) for each in ranking.doubts],
        seconds=max(0.0, ranking.seconds),
        complaints=[ComplaintInfo(name=it, text=two(text)) for it, text in COMPLAINTS.items()],
        errors=[
            CauseFileError(file=it.file, line=it.line, text=two(it.problem))
            for it in knowledge.errors
        ],
    )


def _measurement(measurement: NextMeasurement) -> CauseMeasurement:
    return CauseMeasurement(
        test=measurement.test,
        guided=measurement.guided,
        text=two(measurement.text),
        why=two(measurement.why),
        outcomes=[
            CauseOutcome(text=two(it.text), cause=it.cause, means=two(it.means))
            for it in measurement.outcomes
        ],
    )


def _cause(cause: RankedCause, names: Sequence[str]) -> CauseInfo:
    return CauseInfo(
        id=cause.id,
        variant=cause.variant,
        likelihood=cause.likelihood,
        likely=two(LIKELIHOODS[cause.likelihood]),
        text=two(cause.text),
        check=two(cause.check),
        speaks_for=[_evidence(each, names) for each in cause.evidence_for],
        speaks_against=[_evidence(each, names) for each in cause.evidence_against],
    )


def _evidence(evidence: Evidence, names: Sequence[str]) -> CauseEvidence:
    return CauseEvidence(
        feature=evidence.feature,
        text=two(evidence.text),
        value=evidence.value,
        low=evidence.low,
        high=evidence.high,
        recording=names[evidence.source] if names else None,
        moments=[CauseMoment(begin=begin, end=end) for begin, end in evidence.spans],
    )
