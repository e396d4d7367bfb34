"""Routes of the report: on a recording, and on the running connection.

The latter covers the last minutes, the passport and the faults as last read. Reports are made in a
thread, in the lane of files.
"""

from __future__ import annotations

import asyncio
from bisect import bisect_left
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final

from fastapi import APIRouter
from fastapi.responses import Response

from mikas.catalog.lookup import is_corrected
from mikas.dashboard.api.dependencies import Requester, TheRequester
from mikas.dashboard.api.errors import content, errors
from mikas.dashboard.api.library.cars import car_of_connection
from mikas.dashboard.api.library.files import attachment
from mikas.dashboard.errors import NotConnected
from mikas.i18n import Language
from mikas.recording.freeze_frames import AppearedFault, new_faults
from mikas.recording.table.channels import Rows
from mikas.sampling.events import ClockChanged, Event, Gap, UnitFound

if TYPE_CHECKING:
    from mikas.catalog import Catalog
    from mikas.causes.knowledge import Complaint
    from mikas.causes.result import Ranking
    from mikas.dashboard.dashboard import Dashboard
    from mikas.report.findings import Findings
    from mikas.report.subject import ReportedUnit

router: Final = APIRouter(prefix="/api", tags=["recordings"])

MINUTES: Final = 15
_LIVE: Final = "the running connection"  # no file has this name
_PAGE: Final = content("text/html", "the page")


@router.get("/report", response_class=Response, responses=errors(409, 503, 504) | _PAGE)
async def report(
    requester: TheRequester, *, lang: Language = "en", inline: bool = False
) -> Response:
    """Return a page on the connected car, made of the last quarter of an hour."""
    findings = partial(_of_connection, requester.dashboard)
    return await _page(requester, _LIVE, findings, lang, None if inline else "mikas.html")


@router.get(
    "/recordings/{identity}/report",
    response_class=Response,
    responses=errors(404, 409, 504) | _PAGE,
)
async def recording_report(
    requester: TheRequester, identity: str, *, lang: Language = "en", inline: bool = False
) -> Response:
    """Return a page on the car, made of the recording; to be saved, or `inline` to be viewed."""
    library = requester.library
    file = await asyncio.to_thread(library.folder.one, identity)

    def findings() -> Findings:
        from mikas.causes.knowledge import load
        from mikas.report.from_recording import find_in_recording

        known = load(requester.dashboard.settings.causes)
        return find_in_recording(library.opened(file, latest=True), knowledge=known)

    name = None if inline else f"{file.path.stem}.html"
    return await _page(requester, file.id, findings, lang, name)


async def _page(
    requester: Requester,
    key: str,
    findings: Callable[[], Findings],
    language: Language,
    name: str | None,
) -> Response:
    """Return a report with the content policy that it needs; scripts never run in it.

    `name`: of the file to save; None: the dashboard's page may show it in a frame, and print it
    from there.
    """

    def make() -> tuple[str, str]:
        from mikas.report.page import policy, render

        return render(findings(), language), policy()

    page, policy = await requester.make(key, make)
    if name is None:
        framing = "frame-ancestors 'self'; sandbox allow-same-origin allow-modals"
        headers = {"X-Frame-Options": "SAMEORIGIN"}
    else:
        framing = "frame-ancestors 'none'; sandbox"
        headers = {"Content-Disposition": attachment(name)}
    headers["Content-Security-Policy"] = f"{policy}; {framing}"
    return Response(page, media_type="text/html", headers=headers)


def _of_connection(dashboard: Dashboard) -> Findings:
    from mikas.recording.formatting import date_of
    from mikas.report.findings import find
    from mikas.report.measurements.measurements import MeasurementCollector
    from mikas.report.subject import Conditions, ReportSubject, cleared_faults

    catalog, monitor, connection = dashboard.catalog, dashboard.monitor, dashboard.connection
    thread, port = connection.thread, connection.port
    ecu = thread.acquisition.ecu if thread else None
    with monitor.lock:
        unit, method, errors_ = monitor.unit, monitor.method or "", monitor.meters.errors
        events = monitor.logged
    rows, events = of_this_unit(dashboard.history.rows(MINUTES * 60), events)
    if unit is None and not len(rows.times):
        raise NotConnected
    later = dashboard.session.later
    rows, events = Rows(rows.times + later, rows.values), [it.moved(later) for it in events]
    rows = without_other_readings(rows, catalog, dashboard.settings.connection.interpretation)
    names = [name for name in rows.values if name in catalog.channels]  # as of a recording
    measuring = MeasurementCollector(catalog, names, events)
    measuring.add(rows)
    stored, measured = dashboard.fault_history.latest, measuring.measured
    readings = dashboard.fault_history.readings
    subject = ReportSubject(
        catalog=catalog,
        unit=_unit(unit, catalog),
        faults=stored.faults if stored else None,
        faults_read=stored.time + later if stored else None,
        cleared=cleared_faults([it.moved(later) for it in readings], catalog),
        car=car_of_connection(dashboard),
        conditions=Conditions(
            date=date_of(measured.began),
            port=port.shown if port else "",
            adapter=thread.adapter if thread else "",
            echo=ecu.tester.line.echo if ecu else None,
            method=method,
            interruptions=tuple(_pauses(events, measured.began)),
            errors=errors_,
            clock=tuple(it for it in events if isinstance(it, ClockChanged)),
        ),
        tests=tuple(it.result for it in dashboard.guided.results if it.in_report)[::-1],
        appeared=tuple(_appeared(dashboard))[::-1],
        causes=ranked(dashboard, rows),
    )
    return find(subject, measured)


def ranked(dashboard: Dashboard, rows: Rows, complaint: Complaint | None = None) -> Ranking:
    """Return the causes for rows of the running connection, in their true interpretation."""
    from mikas.causes.knowledge import load
    from mikas.causes.ranking import rank
    from mikas.causes.rows import samples_of_rows, unserved

    samples, stored = samples_of_rows([rows]), dashboard.fault_history.latest
    return rank(
        samples,
        complaint=complaint,
        faults=[fault.code for fault in stored.faults] if stored else (),
        absent=unserved(samples),
        knowledge=load(dashboard.settings.causes),
    )


def _appeared(dashboard: Dashboard) -> Iterator[AppearedFault]:
    """Yield the faults that appeared on this connection, with the frames taken then."""
    catalog, later = dashboard.catalog, dashboard.session.later
    frames = dashboard.freeze_frames.frames
    other = _otherwise_read(catalog, dashboard.settings.connection.interpretation)
    readings = [it.moved(later) for it in dashboard.fault_history.readings]
    for code, before, read in new_faults(readings):
        found = (it for it in frames if it.code == code and before < it.seen <= read)
        frame = next(found, None)
        if frame is not None:
            then = {name: value for name, value in frame.then.items() if name not in other}
            frame = replace(frame, then=then)
        yield AppearedFault(code, before, read, frame)


def of_this_unit(rows: Rows, events: list[Event]) -> tuple[Rows, list[Event]]:
    """Return those since the present unit was first found, without those of another car."""
    others = [n for n, it in enumerate(events) if isinstance(it, UnitFound) and it.another]
    if not others:
        return rows, events
    events = events[others[-1] :]
    return rows.part(slice(bisect_left(rows.times, events[0].time), None)), events


def without_other_readings(rows: Rows, catalog: Catalog, interpretation: str) -> Rows:
    """Return the rows without channels whose interpretation differs from their reference's."""
    other = _otherwise_read(catalog, interpretation)
    return Rows(rows.times, {n: column for n, column in rows.values.items() if n not in other})


def _otherwise_read(catalog: Catalog, interpretation: str) -> set[str]:
    """Return the parameters whose interpretation differs from their reference's."""
    return {each.name for each in catalog.parameters if not is_corrected(each, interpretation)}


def _unit(found: UnitFound | None, catalog: Catalog) -> ReportedUnit | None:
    if found is None or found.version_code is None:
        return None
    from mikas.report.subject import ReportedUnit

    model, passport = catalog.model(found.version_code), found.passport
    return ReportedUnit(model, passport.program, passport.data) if passport else ReportedUnit(model)


def _pauses(events: list[Event], began: float | None) -> Iterator[Gap]:
    """Yield the gaps that have ended; each is logged twice."""
    if began is not None:
        for event in events:
            if isinstance(event, Gap) and event.ended is not None and event.ended > began:
                yield replace(event, began=max(began, event.began))
