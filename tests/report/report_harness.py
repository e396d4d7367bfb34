"""Rows and findings made by hand, for the report's tests."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

from mikas.catalog import shipped
from mikas.recording.table.channels import Rows
from mikas.report.findings import Findings, find
from mikas.report.measurements.measurements import MeasurementCollector
from mikas.report.subject import Conditions, ReportedUnit, ReportSubject

GOOD = {
    "TWAT": 88.0, "FREQ": 840.0, "FREQX": 850.0, "UOZ": 13.0, "UACC": 14.1, "INJ": 4.7,
    "JAIR": 14.5, "THR": 0.0, "RXX": 1.0, "TAIR": 25.0,
}  # fmt: skip
"""A sound engine at warm idle."""

START = 1_780_000_000.0


def rows(seconds=60.0, rate=10.0, *, start=START, **changed) -> Rows:
    """`GOOD`, with some values changed: a number, or what `changed` makes of the times since the
    start; None: not recorded.
    """
    times = np.arange(round(seconds * rate)) / rate
    values = {}
    for name, value in {**GOOD, **changed}.items():
        if value is not None:
            column = value(times) if callable(value) else value
            values[name] = np.broadcast_to(np.asarray(column, np.float64), times.shape).copy()
    return Rows(start + times, values)


def measured(*stretches: Rows, catalog=None, events=()):
    names = dict.fromkeys(name for stretch in stretches for name in stretch.values)
    measuring = MeasurementCollector(catalog or shipped(), names, events)
    for stretch in stretches:
        measuring.add(stretch)
    return measuring.measured


def found(*stretches: Rows, faults: tuple[int, ...] | None = (), events=(), **how) -> Findings:
    catalog = shipped()
    subject = ReportSubject(
        catalog,
        ReportedUnit(catalog.model(0x0A), ("МИКАС 7.1", None, "241.3763"), ("2000.09.27",)),
        None if faults is None else tuple(map(catalog.fault, faults)),
        Conditions(
            **{"file": "drive.pcapng", "date": datetime(2026, 5, 9, 12, 30, tzinfo=UTC)} | how
        ),
    )
    return find(subject, measured(*stretches or (rows(),), events=events))
