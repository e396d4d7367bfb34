"""What a recording of the box holds, read on the host."""

from __future__ import annotations

from math import isnan
from pathlib import Path

import mikas
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader, Packet, Problem
from mikas.recording.summary import Summary, summarise

STILL = {"FREQ": 840, "TWAT": 87, "UACC": 13.8, "INJ": 4.64, "THR": 0, "RXX": True}
"""The values of `still.toml`."""


def received(path: Path) -> bytes:
    """Return all bytes that came from the adapter; no damage is allowed."""
    data = b""
    for item in CaptureReader(path):
        assert not isinstance(item, Problem), item.text.en
        assert isinstance(item, Packet)
        if item.direction is Direction.RECEIVED:
            data += item.data
    return data


def summary(path: Path) -> Summary:
    """Return the summary of `path`, which is one recording."""
    found = summarise(path)
    assert found.problem is None
    assert found.recordings == 1
    return found


def wrong_values(path: Path) -> dict[str, set[float]]:
    """Return the recorded values, by name, that the car of `still.toml` never had."""
    recording = mikas.open(path)
    assert not recording.problem_count
    wrong: dict[str, set[float]] = {}
    count = 0
    for rows in recording.rows():
        for name in set(rows.values) & set(STILL):
            known = [float(value) for value in rows.values[name] if not isnan(value)]
            count += len(known)
            if others := {value for value in known if abs(value - STILL[name]) > 1e-6}:
                wrong[name] = others
    assert count, f"{path} has no values"
    return wrong
