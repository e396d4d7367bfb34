"""The first notes of a recording, as a session writes them: unit, catalog, plan."""

from __future__ import annotations

from mikas.client import Passport
from mikas.recording.annotations.annotator import SessionAnnotator
from mikas.sampling.events import PlanChanged, UnitFound


def write_session_header(
    sink,
    time,
    *,
    version_code,
    passports,
    catalog_version,
    adapter="",
    echo=None,
    plan=None,
):
    """`passports`: 51–58, None for a piece that was not given."""
    program, data = tuple(passports)[:3], tuple(passports)[3:]
    passport = Passport(program, data)
    unit = UnitFound(
        time, version_code, passport, adapter=adapter, echo=echo, catalog=catalog_version
    )
    annotator = SessionAnnotator()
    for event in [unit, PlanChanged(time, plan)] if plan else [unit]:
        for note in annotator.notes_of(event):
            sink.note(note)
