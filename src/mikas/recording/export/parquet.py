"""Parquet: `time` in seconds, a DOUBLE a channel, a BOOLEAN a flag, missing as NULL.

Units, texts and events have no place in a Parquet column, so they are in the file's own metadata,
as JSON under the key `mikas`.
"""

from __future__ import annotations

import json
from pathlib import Path
from shutil import move
from tempfile import TemporaryDirectory

from mikas.files import utf_8
from mikas.recording.export.sheet import BATCH, Sheet, program
from mikas.recording.parquet import ParquetTable

_GROUP = 122_880  # rows, duckdb's own choice
_VECTOR = 2_048  # rows; a group is a multiple


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet.

    duckdb writes a file with a short name: beside a longer one it would make one longer still.
    """
    rows = min(_GROUP, 4_000_000 // (len(sheet.channels) + 1)) // _VECTOR * _VECTOR
    place, prefix = _place(path)
    with TemporaryDirectory(dir=place, prefix=prefix) as folder:
        whole = Path(folder, "whole.parquet")
        with ParquetTable(Path(folder), ["time"], sheet.channels, BATCH) as table:
            for times, values in sheet.batches():
                table.add((times, *values), len(times))
            query = f"SELECT {', '.join(('time', *table.channel_columns()))} FROM collected"
            table.copy(query, whole, _metadata(sheet), f"ROW_GROUP_SIZE {max(rows, _VECTOR)}")
        move(whole, path)


def _place(path: Path) -> tuple[Path | None, str]:
    """Return in which folder duckdb can write, and how the name of its own begins there: beside
    `path`; None, that of the system, if `path` is not UTF-8.
    """
    try:
        utf_8(path)
    except ValueError:
        return None, "mikas-"
    return path.parent, f"{path.name[:100]}."


def _metadata(sheet: Sheet) -> str:
    started = None if sheet.started is None else sheet.started.isoformat()
    facts = {
        "program": program(),
        "started": started,
        "about": dict(sheet.about),
        "time": {"unit": "s", "en": "Time since the start", "ru": "Время от начала"},
        "channels": {channel.name: channel.facts() for channel in sheet.channels},
        "events": [moment.as_json() for moment in sheet.moments],
    }
    return json.dumps(facts, ensure_ascii=False)
