"""What a report is about, before anything is judged: the unit, its faults, how it was measured.

Whoever makes a report (of a recording, of a running session) fills these in; None or empty is what
could not be known, and the report says so.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime

from mikas.catalog import Catalog, Fault, Model
from mikas.i18n import Text
from mikas.report.fault_history import ClearedFaults


@dataclass(frozen=True, slots=True)
class UnitIdentity:
    """Who was asked. The passport's pieces: three of the program, five of the data; None: it does
    not tell.
    """

    model: Model
    program: tuple[str | None, ...] = ()
    data: tuple[str | None, ...] = ()


@dataclass(frozen=True, slots=True)
class Interruption:
    """Nothing came from `began` to `ended`, on the link's clock; None: until the end."""

    began: float
    ended: float | None = None
    reason: Text | None = None


@dataclass(frozen=True, slots=True)
class Conditions:
    """How it was measured. `file`: the recording's name; empty: of a running session.

    `date` None: the clock was a simulated one. `errors`: exchanges that failed. `sessions`: how
    many the file holds; the report is of the last. `damaged`: places that could not be read.
    """

    file: str = ""
    date: datetime | None = None
    port: str = ""
    adapter: str = ""
    echo: bool | None = None
    method: str = ""
    pauses: tuple[Interruption, ...] = ()
    errors: int | None = None
    sessions: int = 1
    damaged: int = 0
    recorded_with: str = ""


@dataclass(frozen=True, slots=True)
class ReportSubject:
    """All of it. `faults` None: they were not read; else they were stored at `faults_read`, and
    `gone` had been before. `notes`: a person's words, in their order.
    """

    catalog: Catalog
    unit: UnitIdentity | None = None
    faults: tuple[Fault, ...] | None = None
    how: Conditions = field(default_factory=Conditions)
    notes: tuple[str, ...] = ()
    faults_read: float | None = None
    gone: tuple[ClearedFaults, ...] = ()
