"""`mikas.open`: a recording in a notebook; derived channels over rows that hold a part each."""

from __future__ import annotations

import json
import sys
from contextlib import closing

import numpy as np
import pytest

import mikas
from mikas.catalog import shipped
from mikas.client import Limits
from mikas.client.connecting import ConnectionOptions
from mikas.errors import CaptureError, CatalogError, MissingExtra, UnknownParameter, UsageError
from mikas.i18n import Text
from mikas.link.reconnecting import ReconnectingPort
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import note_of
from mikas.recording.table.channels import Channel, Rows
from mikas.recording.table.dataframes import Table, arrow_table, pandas_frame, polars_frame
from mikas.recording.table.derived import FRESH, Deriver
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import MethodChosen, Sampled
from mikas.sampling.plan import Plan, PlannedParameter
from session_header_harness import write_session_header

NAN = np.nan
PORT = "sim:?clock=simulated"
RPM = Channel("FREQ", "rpm", Text("Speed", "Обороты"))
IDLE = Channel("RXX", "", Text("Idle", "Холостой ход"), is_flag=True)
SMALL = Table(
    (RPM, IDLE),
    np.array([0.0, 0.1, 0.2]),
    {"FREQ": np.array([840.0, NAN, 880.0]), "RXX": np.array([1.0, 0.0, NAN])},
    {"started": None, "units": {"FREQ": "rpm", "RXX": ""}},
)


def record(path, *names, method="batch", count=30):
    with CaptureWriter(path, url=PORT) as sink, mikas.connect(PORT, sink=sink) as ecu:
        for _ in ecu.watch(*names, method=method, count=count):
            pass
    return path


@pytest.fixture
def drive(tmp_path):
    return record(tmp_path / "drive.pcapng", "TWAT", "FREQ", "INJ", "RXX", "UACC")


def test_a_recording_has_its_channels_facts_and_rows(drive):
    recording = mikas.open(drive)
    assert [channel.name for channel in recording.channels] == [
        "TWAT", "FREQ", "UACC", "INJ", "RXX", "BITPOW", "RDET",
        "FUEL_STROKE", "FUEL_FLOW", "FUEL_USED", "DUTY",
    ]  # fmt: skip
    assert (recording.problems, recording.problem_count, recording.absent) == ((), 0, ())
    assert recording.about["port"] == PORT
    assert "drive.pcapng" in repr(recording)
    (rows,) = recording.rows()
    assert len(rows.times) == 30
    assert set(rows.values) == {channel.name for channel in recording.channels}
    (again,) = recording.rows()
    for name, values in rows.values.items():
        np.testing.assert_array_equal(values, again.values[name])
    assert (np.diff(rows.values["FUEL_USED"]) > 0).all()


def test_pandas_gets_seconds_values_and_units(drive):
    frame = mikas.open(str(drive)).to_pandas()
    assert frame.index.name == "time"
    assert frame.index[0] == 0
    assert len(frame) == 30
    assert frame.attrs["units"]["TWAT"] == "°C"
    assert frame.attrs["channels"]["TWAT"]["ru"].startswith("Температура")
    assert frame.attrs["started"] is None  # a simulated clock knows no calendar
    assert frame.RXX.dtype == "boolean"


def test_polars_gets_the_named_columns_in_their_order(drive):
    frame = mikas.open(drive, names=["FUEL_FLOW", "TWAT"]).to_polars()
    assert frame.columns == ["time", "FUEL_FLOW", "TWAT"]
    assert frame.height == 30


def test_arrow_gets_units_and_facts_in_its_metadata(drive):
    table = mikas.open(drive).to_arrow()
    assert table.schema.field("TWAT").metadata[b"unit"].decode() == "°C"
    assert table.schema.field("time").metadata[b"unit"] == b"s"
    facts = json.loads(table.schema.metadata[b"mikas"])
    assert facts["about"]["recording"] == "drive.pcapng"
    assert table.num_rows == 30


def test_all_three_have_the_same_values(drive):
    recording = mikas.open(drive)
    pandas, polars, arrow = recording.to_pandas(), recording.to_polars(), recording.to_arrow()
    for name in ("TWAT", "FUEL_FLOW"):
        np.testing.assert_array_equal(pandas[name].to_numpy(), polars[name].to_numpy())
        np.testing.assert_array_equal(pandas[name].to_numpy(), arrow[name].to_numpy())
    np.testing.assert_array_equal(pandas.index.to_numpy(), arrow["time"].to_numpy())


def test_what_is_missing_is_nan_or_null():
    frame = pandas_frame(SMALL)
    assert frame["FREQ"].isna().tolist() == [False, True, False]
    assert frame["RXX"].isna().tolist() == [False, False, True]
    assert frame["RXX"].iloc[0]
    assert polars_frame(SMALL)["FREQ"].to_list() == [840, None, 880]
    assert polars_frame(SMALL)["RXX"].to_list() == [True, False, None]
    assert arrow_table(SMALL)["FREQ"].to_pylist() == [840, None, 880]
    assert arrow_table(SMALL)["RXX"].to_pylist() == [True, False, None]


@pytest.mark.parametrize("library", ["pandas", "polars", "pyarrow"])
def test_a_missing_library_is_named(drive, monkeypatch, library):
    recording = mikas.open(drive)
    monkeypatch.setitem(sys.modules, library, None)
    convert = getattr(recording, f"to_{library.replace('pyarrow', 'arrow')}")
    with pytest.raises(MissingExtra, match=f"pip install {library}") as caught:
        convert()
    assert isinstance(caught.value, ImportError)
    assert f"pip install {library}" in caught.value.text.ru


def test_a_recording_without_readings_has_no_channels_and_empty_tables(tmp_path):
    path = tmp_path / "empty.pcapng"
    with CaptureWriter(path, url=PORT):
        pass
    recording = mikas.open(path)
    assert recording.channels == ()
    assert list(recording.rows()) == []
    recording = mikas.open(path, names="TWAT")
    assert recording.absent == ("TWAT",)
    for frame in (recording.to_pandas(), recording.to_polars(), recording.to_arrow()):
        assert len(frame) == 0
        assert "TWAT" in list(getattr(frame, "column_names", frame.columns))


def test_wrong_names_files_and_interpretations_are_refused(drive, tmp_path):
    with pytest.raises(UnknownParameter, match="TWAT"):
        mikas.open(drive, names=["TWATT"])
    with pytest.raises(UsageError, match="0x1A"):
        mikas.open(drive, names=["0x1A"])
    with pytest.raises(UsageError, match="sideways"):
        mikas.open(drive, interpretation="sideways")
    with pytest.raises(CaptureError, match="nowhere"):
        mikas.open(tmp_path / "nowhere.pcapng")
    with pytest.raises(CatalogError, match=r"none\.toml"):
        mikas.open(drive, catalogs=[tmp_path / "none.toml"])


def test_a_cut_recording_has_the_rows_before_the_cut_and_one_problem(drive):
    whole = len(mikas.open(drive).to_pandas())
    drive.write_bytes(drive.read_bytes()[:-3001])
    recording = mikas.open(drive)
    assert 0 < len(recording.to_pandas()) < whole
    assert recording.problem_count == len(recording.problems) == 1
    assert 0 < recording.problems[0].offset < drive.stat().st_size


def test_formulas_take_the_corrected_reading_whatever_is_shown(drive, tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(
        '[derived.HALF]\nformula = "UACC / 2"\nunit = "V"\n'
        'text = { en = "Half", ru = "Половина" }\n',
        "utf-8",
    )
    corrected = mikas.open(drive, catalogs=[own]).to_pandas()
    literal = mikas.open(drive, catalogs=[str(own)], interpretation="literal").to_pandas()
    assert (corrected.UACC > 10).all()
    assert (literal.UACC < 0).all()  # E2: a signed byte
    np.testing.assert_array_equal(literal.HALF, corrected.UACC / 2)


def test_a_derived_channel_has_a_value_where_an_input_is_new(tmp_path):
    path = record(tmp_path / "one.pcapng", "FREQ", "INJ", "TWAT", method="single", count=10)
    frame = mikas.open(path).to_pandas()
    assert len(frame) == 30
    assert frame.FREQ.notna().sum() == 10  # nothing recorded is repeated
    assert frame.FUEL_FLOW.notna().sum() == 19  # from the second row on, where an input is new
    assert not (frame.FUEL_FLOW.notna() & frame.TWAT.notna()).any()
    assert frame.FUEL_USED.max() > 0


def rows(times, **values):
    return Rows(np.array(times), {name: np.array(column) for name, column in values.items()})


def test_an_input_holds_for_a_second_and_across_stretches():
    whole = rows(
        [0.0, 0.5, FRESH + 0.1, 1.2, 1.3],
        FREQ=[800.0, NAN, NAN, NAN, 900.0],
        INJ=[NAN, 4.0, 5.0, NAN, NAN],
    )
    at_once = Deriver(shipped(), ["DUTY"]).columns(whole)["DUTY"]
    expected = [NAN, 100 * 4 * 800 / 120_000, NAN, NAN, 100 * 5 * 900 / 120_000]
    np.testing.assert_allclose(at_once, expected)
    deriver = Deriver(shipped(), ["DUTY"])
    parts = [
        deriver.columns(
            Rows(whole.times[i : i + 1], {n: v[i : i + 1] for n, v in whole.values.items()})
        )
        for i in range(5)
    ]
    np.testing.assert_array_equal(np.concatenate([part["DUTY"] for part in parts]), at_once)


def test_an_input_holds_for_a_cycle_that_is_longer_and_no_longer_than_that():
    times, speeds, pulses = [], [], []
    for cycle in (0, 6, 12, 30, 36):  # a hole before the fourth
        times += [cycle, cycle + 2.5]
        speeds += [800.0, NAN]
        pulses += [NAN, 4.0]
    whole = rows(times, FREQ=speeds, INJ=pulses)
    at_once = Deriver(shipped(), ["DUTY"]).columns(whole)["DUTY"]
    there = [0, 0, 0, 1, 1, 1, 0, 1, 1, 1]  # once a cycle's length is known
    np.testing.assert_array_equal(np.isfinite(at_once), np.array(there, dtype=bool))
    deriver = Deriver(shipped(), ["DUTY"])
    parts = [
        deriver.columns(
            Rows(whole.times[i : i + 1], {n: v[i : i + 1] for n, v in whole.values.items()})
        )["DUTY"]
        for i in range(len(times))
    ]
    np.testing.assert_array_equal(np.concatenate(parts), at_once)


def test_a_slow_parameter_holds_for_a_second_beside_a_fast_one():
    times = np.arange(0, 12, 0.5)
    pulses = np.where(times % 4 == 0, 4.0, NAN)
    column = Deriver(shipped(), ["DUTY"]).columns(
        rows(times, FREQ=np.full(times.size, 800.0), INJ=pulses)
    )["DUTY"]
    np.testing.assert_array_equal(np.isfinite(column), times % 4 <= FRESH)


def test_a_clock_that_runs_back_holds_nothing():
    deriver = Deriver(shipped(), ["DUTY"])
    deriver.columns(rows([10.0], FREQ=[800.0], INJ=[NAN]))
    assert np.isnan(deriver.columns(rows([5.0], FREQ=[NAN], INJ=[4.0]))["DUTY"]).all()


def test_what_adds_up_is_the_same_as_it_was_live_though_responses_were_spoilt(tmp_path):
    """A row without values is a response that was asked for again, and no gap."""
    path, port = tmp_path / "spoilt.pcapng", PORT + "&seed=3&damaged=0.01&cut=0.01&foreign=0.02"
    with CaptureWriter(path, url=port) as sink:
        made = Acquisition(
            ReconnectingPort(port, sink=sink),
            ConnectionOptions().create_ecu,
            shipped(),
            ["FUEL_USED"],
            method="list",
        )
        with closing(made.run()) as events:
            samples = (event for event in events if isinstance(event, Sampled))
            live = [next(samples).derived["FUEL_USED"] for _ in range(400)]
    times = [value.time for value in live]
    assert live[-1].gaps == (np.diff(times) > 2).sum()
    (table,) = mikas.open(path, names=["FREQ", "FUEL_USED"]).rows()
    spoilt = np.isnan(table.values["FREQ"])
    assert spoilt.any()
    used = np.interp(times, table.times[~spoilt], table.values["FUEL_USED"][~spoilt])
    np.testing.assert_allclose(used - used[0], [value.value for value in live], atol=1e-9)


def test_it_names_the_methods_used_and_not_the_first_guess(tmp_path):
    path = tmp_path / "measured.pcapng"
    wanted = (PlannedParameter(shipped().parameter("FREQ")),)
    with CaptureWriter(path, url=PORT) as sink:
        write_session_header(
            sink, 1.0, version_code=10, passports=[None] * 8, catalog_version="1",
            plan=Plan(wanted, "batch"),
        )  # fmt: skip
        sink.note(note_of(MethodChosen(2.0, "stream", {"stream": 34.0}, Limits())))
        sink.note(note_of(MethodChosen(9.0, "list", {"list": 29.0}, Limits())))
    assert mikas.open(path).about["method"] == "stream, list"
