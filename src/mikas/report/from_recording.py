"""The findings of a recording: from the rows, notes and faults of its last session.

Always in the corrected interpretation, which the references belong to.
"""

from __future__ import annotations

from dataclasses import dataclass

from mikas.catalog import Catalog
from mikas.causes.knowledge import Knowledge
from mikas.causes.recorded import rank_recordings
from mikas.cleaning import clean_line
from mikas.client.cars import NO_CAR, CarDetails
from mikas.drives import trips
from mikas.drives.finding import SPEED, instrument_curve
from mikas.drives.mixture import compared_mixture
from mikas.drives.ways import way_of
from mikas.guided.recorded import results_of
from mikas.recording.annotations.events import (
    RecordedUnit,
    car_of,
    comment_of,
    events_of,
    unit_of,
)
from mikas.recording.capture.reader import Source
from mikas.recording.formatting import date_of
from mikas.recording.recorded_faults import FaultReadings, FrameCollector
from mikas.recording.recording import Recording
from mikas.report.findings import Findings, find
from mikas.report.measurements.measurements import MeasurementCollector
from mikas.report.subject import (
    Conditions,
    ReportedDrive,
    ReportedUnit,
    ReportSubject,
    cleared_faults,
)
from mikas.sampling.events import ClockChanged, Gap, MethodChosen, TextNote


def find_in_recording(
    recording: Recording,
    *,
    name: str | None = None,
    errors: int | None = None,
    car: CarDetails = NO_CAR,
    knowledge: Knowledge | None = None,
) -> Findings:
    """Return the findings of a recording.

    `name`: another name than its file's; empty for a temporary file. `errors`: the number of line
    errors, if they were counted. `car`: details that replace those in the file.
    `knowledge`: of causes, the user's among them; None: the shipped.
    """
    catalog, recording = recording.catalog, recording.interpreted("corrected")
    readings = FaultReadings(recording)
    ports = _ports(recording, readings)
    by_port = {source: port.measuring.measured for source, port in ports.items()}
    no_rows = readings.port_without_rows()
    source = max(by_port, key=lambda port: by_port[port].rows, default=no_rows)
    measured = by_port.get(source) or MeasurementCollector(catalog, ()).measured
    last, heard = source.recording, readings.readings_of_port(source)
    frames = ports[source].frames if source in ports else FrameCollector(heard)
    mine = [note for note in recording.notes if note.recording == last]
    recorded, events = unit_of(mine, catalog), events_of(mine, catalog)
    methods = [event.method for event in events if isinstance(event, MethodChosen)]
    gaps = tuple(event for event in events if isinstance(event, Gap))
    clock = tuple(event for event in events if isinstance(event, ClockChanged))
    words = [event.text for event in events if isinstance(event, TextNote)]
    subject = ReportSubject(
        catalog=catalog,
        unit=_unit(recorded, catalog),
        faults=tuple(map(catalog.fault, dict.fromkeys(heard[-1].codes))) if heard else None,
        faults_read=heard[-1].time if heard else None,
        cleared=cleared_faults(heard, catalog),
        appeared=frames.appeared,
        conditions=Conditions(
            file=clean_line(recording.path.name if name is None else name),
            date=date_of(measured.began),
            port=source.url,
            adapter=recorded.adapter if recorded else source.description,
            echo=recorded.echo if recorded else None,
            method=methods[-1] if methods else (recorded.method or "") if recorded else "",
            other_methods=len(set(methods)) > 1,
            interruptions=gaps if gaps or recorded else None,
            errors=errors,
            sessions=1 + last,
            ports=max(1, sum(each.recording == last for each in ports)),
            damaged=recording.problem_count,
            cars=tuple(each.name for each in recording.raw.cars),
            clock=clock,
            empty=not recording.raw.spans,
        ),
        notes=tuple(filter(None, (comment_of(mine), *words))),
        tests=results_of(mine),
        car=car.over(car_of(mine)),
        causes=rank_recordings([recording], knowledge=knowledge) if by_port else None,
        drive=_drive(recording, last),
        mixture=compared_mixture(recording, last),
    )
    return find(subject, measured)


def _drive(recording: Recording, session: int) -> ReportedDrive | None:
    """Return the drives and the way of a session; None if no instrument measured either."""
    way = tuple(way_of(recording, session))
    if not way and instrument_curve(recording, session, SPEED) is None:
        return None
    has_speed = any(each.name == "FREQ" for each in recording.channels)
    found = trips(recording) if has_speed else []
    return ReportedDrive(tuple(each for each in found if each.session == session), way)


@dataclass(slots=True)
class _Port:
    """One port of the last session."""

    measuring: MeasurementCollector
    frames: FrameCollector


def _ports(recording: Recording, readings: FaultReadings) -> dict[Source, _Port]:
    """Return the ports of the last session that has rows."""
    known = recording.catalog.channels  # without those of instruments, which have no references
    names = [channel.name for channel in recording.channels if channel.name in known]
    ports: dict[Source, _Port] = {}
    for source, rows in recording.stretches(recording.raw.last_session):
        if source not in ports:
            events = [it for it in recording.events if it.recording == source.recording]
            frames = FrameCollector(readings.readings_of_port(source), events)
            ports[source] = _Port(MeasurementCollector(recording.catalog, names, events), frames)
        ports[source].measuring.add(rows)
        ports[source].frames.add(rows)
    return ports


def _unit(recorded: RecordedUnit | None, catalog: Catalog) -> ReportedUnit | None:
    code = recorded.version_code if recorded else None
    if recorded is None or code is None or not 0 <= code <= 0xFF:
        return None
    passport = recorded.passport or ()
    return ReportedUnit(catalog.model(code), passport[:3], passport[3:8])
