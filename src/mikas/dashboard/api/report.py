"""The report of the running session: its last minutes, the passport, the faults as last read."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from fastapi import APIRouter
from fastapi.responses import Response

from mikas.dashboard.api.dependencies import TheHub
from mikas.dashboard.api.errors import errors
from mikas.dashboard.api.exports import HTML, page_answer
from mikas.dashboard.errors import NotConnected
from mikas.dashboard.history import Rows
from mikas.dashboard.library.service import TheDesk
from mikas.i18n import Language, Text

if TYPE_CHECKING:
    from mikas.catalog import Catalog
    from mikas.dashboard.dashboard import Hub
    from mikas.report.findings import Findings
    from mikas.report.subject import Interruption

router = APIRouter(tags=["recordings"])

MINUTES: Final = 15


@router.get("/report", response_class=Response, responses={**errors(409, 503), **HTML})
async def report(
    hub: TheHub, desk: TheDesk, lang: Language = "en", inline: bool = False
) -> Response:
    """A page on the car that is connected, made of the last quarter of an hour."""
    from mikas.report.page import render

    page = await desk.alone(lambda: render(_found(hub), lang))
    return page_answer(page, "mikas.html", inline=inline)


def _found(hub: Hub) -> Findings:
    from mikas.report.fault_history import cleared_faults
    from mikas.report.findings import find
    from mikas.report.formatting import date_of
    from mikas.report.measurements import MeasurementCollector
    from mikas.report.subject import Conditions, ReportSubject, UnitIdentity

    catalog, story, session, ecu, way = hub.catalog, hub.story, hub.session, hub.ecu, hub.way
    with story.lock:
        unit, method, errors_ = story.unit, story.method or "", story.meters.errors
        events = story.events
    rows = _since(
        _judged(hub.history.rows(MINUTES * 60), catalog, hub.settings.connection.interpretation),
        events,
    )
    if unit is None and not len(rows.times):
        raise NotConnected
    measuring = MeasurementCollector(catalog, rows.values)
    measuring.add(rows)
    page, measured = hub.fault_book.page, measuring.measured
    subject = ReportSubject(
        catalog=catalog,
        unit=UnitIdentity(
            catalog.model(unit.version_code), unit.passport.program, unit.passport.data
        )
        if unit
        else None,
        faults=page.faults if page else None,
        faults_read=page.time if page else None,
        gone=cleared_faults(hub.fault_book.heard, catalog),
        how=Conditions(
            date=date_of(measured.began),
            port=way.url if way else "",
            adapter=session.adapter if session else "",
            echo=ecu.tester.echoes if ecu else None,
            method=method,
            pauses=tuple(_pauses(events, measured.began)),
            errors=errors_,
        ),
    )
    return find(subject, measured)


def _judged(rows: Rows, catalog: Catalog, interpretation: str) -> Rows:
    """Without what is shown in another sense than the one that references belong to."""
    other = {
        each.name
        for each in catalog.parameters
        if each.interpretation(interpretation) != each.conversion
    }
    return Rows(rows.times, {n: column for n, column in rows.values.items() if n not in other})


def _since(rows: Rows, events: list[dict[str, Any]]) -> Rows:
    """Since the unit of now was first there; before it, it was another car."""
    came = (each["time"] for each in events if each["kind"] == "unit" and each["another"])
    since = max(came, default=float("-inf"))
    first = int(np.searchsorted(rows.times, since))
    return Rows(rows.times[first:], {name: it[first:] for name, it in rows.values.items()})


def _pauses(events: list[dict[str, Any]], began: float | None) -> Iterator[Interruption]:
    """The gaps that have ended; each was told twice."""
    from mikas.report.subject import Interruption

    for event in events:
        ended = event.get("ended") if event["kind"] == "gap" else None
        if ended is not None and began is not None and ended > began:
            reason = event["reason"]
            text = Text(reason["en"], reason["ru"]) if reason else None
            yield Interruption(max(began, event["began"]), ended, text)
