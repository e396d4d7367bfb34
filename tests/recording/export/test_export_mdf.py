"""MDF4, read back by asammdf."""

from __future__ import annotations

from datetime import UTC, datetime
from xml.etree import ElementTree as ET

import numpy as np
from export_tables import (
    ALL_FLOATS,
    CHANNELS,
    FIXED,
    NAN,
    TWAT,
    exported,
    from_start,
    rows,
    tables,
)
from hypothesis import given, settings

from mikas.recording.export import export
from mikas.recording.export import sheet as sheets


def test_the_fixed_table_is_read_back_from_mdf(tmp_path):
    out = tmp_path / "поездка.mf4"
    export(out, CHANNELS, FIXED, about={"unit": "Микас <7.1>", "passport": "a & b"})
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(out) as mdf:
        assert mdf.version == "4.10"
        assert mdf.start_time == datetime(2023, 11, 14, 22, 13, 20, tzinfo=UTC)
        reported = ET.fromstring(mdf.header.comment).findtext("TX")
        assert reported.startswith("mikas ")
        assert reported.endswith("\nunit: Микас <7.1>\npassport: a & b")
        coolant = mdf.get("TWAT")
        assert coolant.unit == "°C"
        assert coolant.comment == "Coolant temperature / Температура охлаждающей жидкости"
        np.testing.assert_array_equal(coolant.samples, [85, NAN, -40])
        np.testing.assert_allclose(coolant.timestamps, [0, 0.0286, 1.5], atol=1e-6)
        assert mdf.get_master(0).tolist() == coolant.timestamps.tolist()
        np.testing.assert_array_equal(mdf.get("IDLE").samples, [1, NAN, 0])
        assert [channel.name for channel in mdf.groups[0].channels] == [
            "time", "TWAT", "UACC", "IDLE",
        ]  # fmt: skip


def test_no_rows_are_a_file_with_its_channels(tmp_path):
    out = tmp_path / "log.mf4"
    export(out, CHANNELS, [])
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(out) as mdf:
        assert len(mdf.get("UACC").samples) == 0
        assert mdf.get("UACC").unit == "V"
        assert mdf.start_time == datetime(1970, 1, 1, tzinfo=UTC)
        assert "start: unknown" in mdf.header.comment


@settings(max_examples=30)
@given(drawn=tables(ALL_FLOATS, least=1))
def test_what_was_exported_is_read_back(tmp_path_factory, drawn):
    out = exported(drawn, tmp_path_factory.getbasetemp() / "log.mf4")
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(out) as mdf:
        for index, channel in enumerate(drawn.channels, 1):
            signal = mdf.get(group=0, index=index)
            assert signal.name == channel.name
            assert signal.unit == channel.unit
            assert signal.samples.dtype == np.float64
            np.testing.assert_array_equal(signal.samples, drawn.values[channel.name])
            np.testing.assert_array_equal(signal.timestamps, from_start(drawn))


def test_many_stretches_are_one_group(tmp_path, monkeypatch):
    monkeypatch.setattr(sheets, "BATCH", 100)
    out = tmp_path / "log.mf4"
    export(out, [TWAT], (rows([n / 35], TWAT=[n]) for n in range(1234)))
    from asammdf import MDF  # here: its import takes 2 s

    with MDF(out) as mdf:
        assert len(mdf.groups) == 1
        assert mdf.get("TWAT").samples.tolist() == list(range(1234))
