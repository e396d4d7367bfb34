"""What `mikas export` writes of a real recording gives the same numbers back, in every format."""

from __future__ import annotations

import numpy as np
import pytest

import mikas
from mikas.foreign_logs import open_log


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    path = tmp_path_factory.mktemp("drive") / "drive.pcapng"
    with (
        mikas.connect("sim:?clock=simulated&seed=3&scenario=city") as ecu,
        ecu.record(path),
    ):
        for _ in ecu.watch("FREQ", "TWAT", "UACC", "INJ", "DET", count=120):
            pass
    return mikas.open(path, names=["FREQ", "TWAT", "UACC", "INJ", "DET"])


FORMATS = [
    ("csv", {}), ("csv", {"dialect": "excel"}), ("msl", {}), ("mlg", {}), ("mf4", {}),
]  # fmt: skip


@pytest.mark.parametrize(("suffix", "options"), FORMATS)
def test_the_same_numbers_come_back(drive, tmp_path, suffix, options):
    if suffix == "mf4":
        pytest.importorskip("asammdf", reason="MDF4 needs the extra mdf")
    out = tmp_path / f"drive.{suffix}"
    drive.export(out, **options)
    log = open_log(out)
    frame = drive.to_pandas()
    assert len(log) == len(frame)
    # CSV, .msl and .mlg count whole milliseconds.
    assert np.allclose(np.array(log.times) - log.times[0], frame.index, atol=0.00051)
    assert len(log.columns) == len(drive.channels) == 5
    for column, channel in zip(log.columns, drive.channels, strict=True):
        wanted = frame[channel.name].astype(float).to_numpy(na_value=np.nan)
        assert np.array_equal(np.array(column.values), wanted, equal_nan=True), channel.name
        assert column.unit == channel.unit
    assert np.isfinite(log.columns[0].values).sum() > 100
    assert not log.problems
    if suffix == "mf4":
        assert [it.name for it in log.columns] == [it.name for it in drive.channels]
