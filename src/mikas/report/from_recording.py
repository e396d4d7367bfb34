"""The findings of a recording: from the rows, notes and faults of its last session.

Always in the corrected interpretation, which the references belong to.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

from mikas.catalog import Catalog
from mikas.cleaning import clean_line
from mikas.client.cars import NO_CAR, CarDetails
from mikas.guided.recorded import results_of
from mikas.recording.annotations.car import car_of
from mikas.recording.annotations.events import (
    RecordedUnit,
    comment_of,
    events_of,
    unit_of,
)
from mikas.recording.capture.reader import CaptureReader, Source
from mikas.recording.formatting import date_of
from mikas.recording.recorded_faults import FaultReadings, FrameCollector
from mikas.recording.table.channels import Rows, is_recorded, joined_rows
from mikas.recording.table.derived import Deriver
from mikas.recording.table.reader import TableReader
from mikas.report.findings import Findings, find
from mikas.report.measurements.measurements import MeasurementCollector
from mikas.report.subject import (
    Conditions,
    ReportSubject,
    UnitIdentity,
    cleared_faults,
)
from mikas.sampling.events import Event, Gap, MethodChosen, TextNote


def find_in_recording(
    path: str | os.PathLike[str],
    catalog: Catalog,
    *,
    name: str | None = None,
    errors: int | None = None,
    car: CarDetails = NO_CAR,
) -> Findings:
    """Return the findings of a recording.

    `name`: another name than its file's; empty for a temporary file. `errors`: the number of line
    errors, if they were counted. `car`: details that replace those in the file. Raises
    `CaptureError` for a file that is no capture.
    """
    capture = CaptureReader(path)
    table = TableReader(path, catalog)
    notes = list(capture.notes())
    readings = FaultReadings(capture.path, notes)
    sessions = _sessions(table, catalog, events_of(notes, catalog), readings)
    by_port = {source: session.measuring.measured for source, session in sessions.items()}
    no_rows = readings.port_without_rows()
    source = max(by_port, key=lambda port: by_port[port].rows, default=no_rows)
    measured = by_port.get(source) or MeasurementCollector(catalog, ()).measured
    last, heard = source.recording, readings.readings_of_port(source)
    frames = sessions[source].frames if source in sessions else FrameCollector(heard)
    mine = [note for note in notes if note.recording == last]
    recorded, events = unit_of(mine, catalog), events_of(mine, catalog)
    methods = [event.method for event in events if isinstance(event, MethodChosen)]
    gaps = tuple(event for event in events if isinstance(event, Gap))
    words = [event.text for event in events if isinstance(event, TextNote)]
    subject = ReportSubject(
        catalog=catalog,
        unit=_unit(recorded, catalog),
        faults=tuple(map(catalog.fault, dict.fromkeys(heard[-1].codes))) if heard else None,
        faults_read=heard[-1].time if heard else None,
        cleared=cleared_faults(heard, catalog),
        appeared=frames.appeared,
        conditions=Conditions(
            file=clean_line(capture.path.name if name is None else name),
            date=date_of(measured.began),
            port=source.url,
            adapter=recorded.adapter if recorded else source.description,
            echo=recorded.echo if recorded else None,
            method=methods[-1] if methods else (recorded.method or "") if recorded else "",
            other_methods=len(set(methods)) > 1,
            interruptions=gaps if gaps or recorded else None,
            errors=errors,
            sessions=1 + last,
            ports=max(1, sum(each.recording == last for each in sessions)),
            damaged=table.problem_count,
        ),
        notes=tuple(filter(None, (comment_of(mine), *words))),
        tests=results_of(mine),
        car=car.over(car_of(mine)),
    )
    return find(subject, measured)


_PIECES: Final = 4096


@dataclass(slots=True)
class _Session:
    """One port in one session of the file."""

    measuring: MeasurementCollector
    deriver: Deriver
    frames: FrameCollector


def _sessions(
    table: TableReader, catalog: Catalog, events: Iterable[Event], readings: FaultReadings
) -> dict[Source, _Session]:
    """Return the ports of the last recording that has rows."""
    by_recording: dict[int, list[Event]] = defaultdict(list)
    for event in events:
        by_recording[event.recording].append(event)
    recorded = [channel.name for channel in table.channels]
    derived = [name for name in catalog.derived if is_recorded(name, catalog, recorded)]
    sessions: dict[Source, _Session] = {}
    for source, rows in _last_recording(table):
        if any(other.recording != source.recording for other in sessions):
            sessions.clear()
        if source not in sessions:
            mine = by_recording[source.recording]
            measuring = MeasurementCollector(catalog, [*recorded, *derived], mine)
            frames = FrameCollector(readings.readings_of_port(source), mine)
            sessions[source] = _Session(measuring, Deriver(catalog, derived), frames)
        session = sessions[source]
        made = session.deriver.columns(rows) if derived else {}
        full = Rows(rows.times, {**rows.values, **made})
        session.measuring.add(full)
        session.frames.add(full)
    return sessions


def _last_recording(table: TableReader) -> Iterator[tuple[Source, Rows]]:
    """Yield the rows of the last recording, at best many at a time.

    Where a clock runs to and fro a stretch may be a single row. Rows of an earlier recording are
    yielded only if it has very many; a file can hold thousands of short ones.
    """
    held: dict[Source, list[Rows]] = {}
    for source, rows in table.stretches():
        if any(other.recording != source.recording for other in held):
            held.clear()
        pieces = held.setdefault(source, [])
        pieces.append(rows)
        if len(pieces) >= _PIECES or len(rows.times) >= _PIECES:
            yield source, joined_rows(held.pop(source))
    for source, pieces in held.items():
        yield source, joined_rows(pieces)


def _unit(recorded: RecordedUnit | None, catalog: Catalog) -> UnitIdentity | None:
    code = recorded.version_code if recorded else None
    if recorded is None or code is None or not 0 <= code <= 0xFF:
        return None
    passport = recorded.passport or ()
    return UnitIdentity(catalog.model(code), passport[:3], passport[3:8])
