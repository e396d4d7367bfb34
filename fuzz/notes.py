"""The JSON of a recording's notes: a note that can be used everywhere, or none.

Input: notes, one a line, as their blocks hold them. What is read must be writable as a note and as
JSON again, which the dashboard and `--json` do, and readable by whatever takes notes.
"""

from __future__ import annotations

import json
from math import isfinite
from typing import Final

from mikas.catalog import shipped
from mikas.guided.recorded import results_of
from mikas.guided.result import read as read_result
from mikas.recording.annotations.events import comment_of, events_of, recorded_faults, unit_of
from mikas.recording.capture.blocks import Custom
from mikas.recording.capture.notes import ENTERPRISE, TAG, block_of, read_block
from mikas.replay.outages import Outages

WORDS: Final = (
    *('{"kind":"unit","time":0,"data":{', '"kind":"gap"', '"kind":"faults"', '"kind":"alarm"'),
    *('"nan"', '"inf"', "1e999", "-1", "9" * 400, "true", "null", "[]", "{}", '"\\ud800"'),
)


def check(data: bytes) -> None:
    read = (read_block(Custom(ENTERPRISE, TAG + line)) for line in data.split(b"\n"))
    notes = [note for note in read if note is not None]
    for note in notes:
        assert isfinite(note.time)
        assert read_block(block_of(note)) == note
    unit_of(notes, shipped())
    comment_of(notes)
    outages = Outages()
    for note in notes:
        outages.add_note(note)
    outages.conclude(())
    events = events_of(notes, shipped())
    for reading in (*events, *recorded_faults(notes)):
        assert isfinite(reading.time)
    for result in results_of(notes):
        again = json.dumps(result.as_json(), allow_nan=False, ensure_ascii=False)
        assert read_result(json.loads(again)) == result
        assert all(result.as_text())
    for event in events:
        json.dumps(event.as_json(), allow_nan=False, ensure_ascii=False).encode()
