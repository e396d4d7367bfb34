"""The report on the running connection: its last minutes, the passport, the last read faults."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from fastapi import APIRouter
from fastapi.responses import Response

from mikas.dashboard.api.dependencies import TheDashboard, TheLibrary
from mikas.dashboard.api.errors import errors
from mikas.dashboard.api.exports import HTML, page_answer
from mikas.dashboard.errors import NotConnected
from mikas.i18n import Language
from mikas.recording.table.channels import Rows
from mikas.sampling.events import Event, Gap, UnitFound

if TYPE_CHECKING:
    from mikas.catalog import Catalog
    from mikas.dashboard.dashboard import Dashboard
    from mikas.report.findings import Findings
    from mikas.report.subject import Interruption, UnitIdentity

router = APIRouter(tags=["recordings"])

MINUTES: Final = 15


@router.get("/report", response_class=Response, responses={**errors(409, 503), **HTML})
async def report(
    dashboard: TheDashboard, library: TheLibrary, lang: Language = "en", inline: bool = False
) -> Response:
    """Return a page on the connected car, made of the last quarter of an hour."""
    from mikas.report.page import render

    page = await library.run_alone(lambda: render(_found(dashboard), lang))
    return page_answer(page, "mikas.html", inline=inline)


def _found(dashboard: Dashboard) -> Findings:
    from mikas.report.fault_history import cleared_faults
    from mikas.report.findings import find
    from mikas.report.formatting import date_of
    from mikas.report.measurements import MeasurementCollector
    from mikas.report.subject import Conditions, ReportSubject

    catalog, monitor, connection = dashboard.catalog, dashboard.monitor, dashboard.connection
    thread, ecu, port = connection.thread, connection.ecu, connection.port
    with monitor.lock:
        unit, method, errors_ = monitor.unit, monitor.method or "", monitor.meters.errors
        events = monitor.events
    rows = _since(
        _judged(
            dashboard.history.rows(MINUTES * 60),
            catalog,
            dashboard.settings.connection.interpretation,
        ),
        events,
    )
    if unit is None and not len(rows.times):
        raise NotConnected
    measuring = MeasurementCollector(catalog, rows.values)
    measuring.add(rows)
    stored, measured = dashboard.fault_history.latest, measuring.measured
    subject = ReportSubject(
        catalog=catalog,
        unit=_unit(unit, catalog),
        faults=stored.faults if stored else None,
        faults_read=stored.time if stored else None,
        gone=cleared_faults(dashboard.fault_history.readings, catalog),
        how=Conditions(
            date=date_of(measured.began),
            port=port.url if port else "",
            adapter=thread.adapter if thread else "",
            echo=ecu.tester.echoes if ecu else None,
            method=method,
            pauses=tuple(_pauses(events, measured.began)),
            errors=errors_,
        ),
    )
    return find(subject, measured)


def _judged(rows: Rows, catalog: Catalog, interpretation: str) -> Rows:
    """Return the rows without channels whose interpretation differs from their reference's."""
    other = {
        each.name
        for each in catalog.parameters
        if each.interpretation(interpretation) != each.conversion
    }
    return Rows(rows.times, {n: column for n, column in rows.values.items() if n not in other})


def _unit(found: UnitFound | None, catalog: Catalog) -> UnitIdentity | None:
    if found is None or found.version_code is None or found.passport is None:
        return None
    from mikas.report.subject import UnitIdentity

    passport = found.passport
    return UnitIdentity(catalog.model(found.version_code), passport.program, passport.data)


def _since(rows: Rows, events: list[Event]) -> Rows:
    """Return the rows since the present unit was found first; before it, it was another car."""
    came = (each.time for each in events if isinstance(each, UnitFound) and each.another)
    since = max(came, default=float("-inf"))
    first = bisect_left(rows.times, since)
    return Rows(rows.times[first:], {name: it[first:] for name, it in rows.values.items()})


def _pauses(events: list[Event], began: float | None) -> Iterator[Interruption]:
    """Yield the gaps that have ended; each is logged twice."""
    from mikas.report.subject import Interruption

    for event in events:
        ended = event.ended if isinstance(event, Gap) else None
        if isinstance(event, Gap) and ended is not None and began is not None and ended > began:
            yield Interruption(max(began, event.began), ended, event.reason)
