"""ASAM MDF 4.10, by asammdf: one group, its master `time` in seconds, the start in the header.

A channel is a float of 64 bits with its unit; both texts are its comment; a missing value is NaN.
Records go to a file beside OUT as they come and are packed (transposed, deflate) at the end.
"""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
from asammdf import MDF, Signal

from mikas.recording.export.heading import program
from mikas.recording.export.sheet import Column, Sheet

_PACKED: Final = 2
_UNKNOWN = datetime(1970, 1, 1, tzinfo=UTC)


def write(path: Path, sheet: Sheet) -> None:
    """Write the whole sheet."""
    with (
        path.open("wb+") as file,
        TemporaryDirectory(dir=path.parent, prefix=f"{path.name}.") as folder,
        MDF(version="4.10", temporary_folder=folder) as mdf,
    ):
        mdf.start_time = sheet.started or _UNKNOWN
        mdf.header.comment = _comment(sheet)
        begun = False
        for times, columns in sheet.stretches:
            if begun:
                mdf.extend(0, [(times, None), *((column, None) for column in columns)])
            else:
                _begin(mdf, sheet, times, columns)
                begun = True
        if not begun:
            empty = np.empty(0)
            _begin(mdf, sheet, empty, [empty] * len(sheet.channels))
        mdf.save(file, compression=_PACKED)


def _begin(mdf: MDF, sheet: Sheet, times: Column, columns: list[Column]) -> None:
    signals = [
        Signal(
            samples=values,
            timestamps=times,
            name=channel.name,
            unit=channel.unit,
            comment=f"{channel.text.en} / {channel.text.ru}",
        )
        for channel, values in zip(sheet.channels, columns, strict=True)
    ]
    mdf.append(signals, common_timebase=True)


def _comment(sheet: Sheet) -> str:
    facts = [program(), *(f"{title}: {text}" for title, text in sheet.about.items())]
    if sheet.started is None:
        facts.append("start: unknown")
    return "\n".join(facts)
