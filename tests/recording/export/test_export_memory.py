"""Memory does not grow with the recording: four times the rows, the same peak."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from export_tables import CHANNELS

from mikas.recording.export import SUFFIXES, export
from mikas.recording.export import sheet as sheets
from mikas.recording.table.channels import Rows


def source(count, size=1000):
    for at in range(0, count, size):
        numbers = np.arange(at, at + size, dtype=float)
        yield Rows(
            numbers / 35,
            {"TWAT": numbers % 256 - 40, "UACC": numbers % 200 / 10, "IDLE": numbers % 2},
        )


def peak_of(out, count):
    tracemalloc.start()
    try:
        export(out, CHANNELS, source(count), overwrite=True)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


# What duckdb allocates is not seen here; it has its own limit. asammdf packs 4 MB at a time.
FEW, MANY = dict.fromkeys(SUFFIXES, 20_000), dict.fromkeys(SUFFIXES, 80_000)
FEW[".mf4"], MANY[".mf4"] = 250_000, 1_000_000


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_peak_does_not_grow_with_the_rows(tmp_path, monkeypatch, suffix):
    monkeypatch.setattr(sheets, "BATCH", 4096)
    out = tmp_path / f"log{suffix}"
    export(out, CHANNELS, source(1000))  # imports
    short, long = peak_of(out, FEW[suffix]), peak_of(out, MANY[suffix])
    assert long < short * 1.2 + 300_000
