"""The findings of a recording: from the rows, notes and faults of its last session.

Always in the corrected interpretation, which the references belong to.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from mikas.catalog import Catalog
from mikas.cleaning import clean_line
from mikas.client.cars import NO_CAR, CarDetails
from mikas.commands import ERASE_FAULTS, ReadFaults
from mikas.errors import MikasError
from mikas.guided.recorded import results_of
from mikas.recording.annotations.car import car_of
from mikas.recording.annotations.events import (
    RecordedUnit,
    comment_of,
    events_of,
    recorded_faults,
    unit_of,
)
from mikas.recording.capture.reader import CaptureReader, Problem, Source
from mikas.recording.exchanges import read_exchanges
from mikas.recording.table.channels import Rows, joined_rows
from mikas.recording.table.derived import Deriver
from mikas.recording.table.reader import TableReader
from mikas.report.findings import Findings, find
from mikas.report.formatting import date_of
from mikas.report.measurements.measurements import MeasurementCollector, Measurements
from mikas.report.subject import (
    Conditions,
    ReportSubject,
    UnitIdentity,
    cleared_faults,
)
from mikas.sampling.derived import DerivedChannels
from mikas.sampling.events import Event, FaultReading, Gap, MethodChosen, TextNote


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
    sessions = _sessions(table, catalog, events_of(notes, catalog))
    noted = max((note.recording for note in notes), default=0)
    last = max((source.recording for source in sessions), default=noted)
    mine = [note for note in notes if note.recording == last]
    source, measured = _fullest(sessions, last, catalog)
    heard = [*recorded_faults(mine), *fault_readings(capture.path).get(source, ())]
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


def _sessions(
    table: TableReader, catalog: Catalog, events: Iterable[Event]
) -> dict[Source, _Session]:
    """Return the ports of the last recording that has rows."""
    by_recording: dict[int, list[Event]] = defaultdict(list)
    for event in events:
        by_recording[event.recording].append(event)
    recorded = [channel.name for channel in table.channels]
    derived = [name for name in catalog.derived if _follows(name, recorded, catalog)]
    sessions: dict[Source, _Session] = {}
    for source, rows in _last_recording(table):
        if any(other.recording != source.recording for other in sessions):
            sessions.clear()
        if source not in sessions:
            mine = by_recording[source.recording]
            measuring = MeasurementCollector(catalog, [*recorded, *derived], mine)
            sessions[source] = _Session(measuring, Deriver(catalog, derived))
        made = sessions[source].deriver.columns(rows) if derived else {}
        sessions[source].measuring.add(Rows(rows.times, {**rows.values, **made}))
    return sessions


def _last_recording(table: TableReader) -> Iterator[tuple[Source, Rows]]:
    """Yield the rows of the last recording, at best many at a time.

    Where a clock runs to and fro a stretch may be a single row. An earlier recording of many rows
    is begun, but not one of the thousands that a file can have.
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


def _follows(name: str, recorded: Iterable[str], catalog: Catalog) -> bool:
    return set(DerivedChannels(catalog, [name]).requires) <= set(recorded)


def _fullest(
    sessions: Mapping[Source, _Session], last: int, catalog: Catalog
) -> tuple[Source, Measurements]:
    """Return the port with most rows in the last session; a new source if none has rows."""
    found = [
        (source, session.measuring.measured)
        for source, session in sessions.items()
        if source.recording == last
    ]
    if not found:
        return Source(last), MeasurementCollector(catalog, ()).measured
    return max(found, key=lambda each: each[1].rows)


def _unit(recorded: RecordedUnit | None, catalog: Catalog) -> UnitIdentity | None:
    code = recorded.version_code if recorded else None
    if recorded is None or code is None or not 0 <= code <= 0xFF:
        return None
    passport = recorded.passport or ()
    return UnitIdentity(catalog.model(code), passport[:3], passport[3:8])


def fault_readings(path: Path) -> Mapping[Source, Sequence[FaultReading]]:
    """Return the fault readings by session and port; one without readings is missing."""
    heard: dict[Source, list[FaultReading]] = defaultdict(list)
    erased: set[Source] = set()  # since the last reading
    command, erasing = ReadFaults(), ERASE_FAULTS[-1].body()
    wanted = frozenset((command.body(), erasing))
    for item in read_exchanges(path):
        if isinstance(item, Problem):
            continue
        for time, request, body in item.answers(wanted):
            if request == erasing:
                erased.add(item.source)
                continue
            with suppress(MikasError):
                reading = FaultReading(time, command.read(body), item.source in erased)
                heard[item.source].append(reading)
                erased.discard(item.source)
    return heard
