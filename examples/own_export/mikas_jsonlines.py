"""An export of your own: JSON lines, the channels first, then an object a row."""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path

from mikas.recording.export.sheet import Sheet


def write(path: Path, sheet: Sheet) -> None:
    """Write the sheet. `path` is of an empty file; it gets its own name when this returns."""
    names = [channel.name for channel in sheet.channels]
    head = {
        "started": sheet.started.isoformat() if sheet.started else None,
        "units": {channel.name: channel.unit for channel in sheet.channels},
        "moments": [moment.as_json() for moment in sheet.moments],
    }
    with path.open("w", encoding="utf-8") as file:
        print(json.dumps(head, ensure_ascii=False), file=file)
        for times, columns in sheet.batches():  # some ten thousand rows each
            for time, *values in zip(times, *columns, strict=True):
                row = {name: float(value) for name, value in zip(names, values, strict=True)}
                known = {name: value for name, value in row.items() if isfinite(value)}
                print(json.dumps({"time": round(float(time), 6), **known}), file=file)
