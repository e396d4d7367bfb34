"""Instruments in a recording: their bytes beside the unit's, decoded again, through all readers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mikas
from instrument_recording import CHANNELS, Heard, record
from merged_harness import needs_wireshark, ran
from mikas.catalog import shipped
from mikas.errors import UsageError
from mikas.i18n import Text
from mikas.instruments import definition_named, definition_of_text
from mikas.recording import exchanges
from mikas.recording.capture.instruments import CONNECTED, instrument_packets, loss, loss_of
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.recording.export import export
from mikas.recording.recording import Recording
from mikas.recording.splitting import split

UNPLUGGED = loss(Text("unplugged", "отключён"))
BEGIN: list[Heard] = [(0, b"", 0.0, CONNECTED), (0, b"\r\n", 0.001, "")]
STEADY = [(0, BEGIN), *((at, [(0, b"14.7\r\n", 0.01, "")]) for at in range(1, 40))]


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("plain") / "a.pcapng", definitions=())


def table(path: Path, *names: str) -> dict[str, list[float]]:
    recording = mikas.open(path, names=names)
    rows = list(recording.rows())
    found = {name: np.concatenate([each.values[name] for each in rows]) for name in names}
    return {name: column.tolist() for name, column in found.items()}


def unit_of(path: Path) -> list[tuple[bytes, float]]:
    return [(it.data, it.time) for it in CaptureReader(path) if isinstance(it, Packet)]


def test_a_row_has_the_last_value_that_is_not_too_old(tmp_path: Path) -> None:
    said = [(0, BEGIN), (10, [(0, b"14.7\r\n", 0.0, "")]), (110, [(0, b"13.0\r\n", 0.0, "")])]
    path = record(tmp_path / "a.pcapng", said, count=120)
    recording = mikas.open(path)
    assert [each.name for each in recording.channels][-2:] == ["LAMBDA", "AFR"]
    (rows,) = recording.rows()
    spoken = rows.times[11] - rows.times[10]
    times, values = rows.times, rows.values["LAMBDA"]
    known = np.flatnonzero(np.isfinite(values))
    assert values[known[0]] == pytest.approx(1.0)
    first = float(times[known[0]])
    assert first - float(times[known[0] - 1]) == pytest.approx(spoken, abs=0.01)
    missing = known[np.flatnonzero(np.diff(known) > 1)[0]]  # the last row before it is too old
    held = float(times[missing]) - first
    assert 1.0 - 2 * spoken <= held <= 1.0  # `stale` of aem
    assert values[-1] == pytest.approx(13.0 / 14.7)
    assert recording.channels[-2].unit == "λ"


def test_after_a_loss_there_is_no_value_and_no_message_of_two_halves(tmp_path: Path) -> None:
    said = [
        (0, BEGIN),
        (5, [(0, b"14.7\r\n1", 0.0, ""), (0, b"", 0.001, UNPLUGGED)]),
        (8, [(0, b"", 0.0, CONNECTED), (0, b"3.9\r\n12.5\r\n", 0.001, "")]),
    ]
    path = record(tmp_path / "a.pcapng", said)
    found = set(np.round(table(path, "AFR")["AFR"], 6))
    assert {each for each in found if not np.isnan(each)} <= {14.7, 12.5}
    losses = [loss_of(packet) for packet in instrument_packets(path)]
    assert [each.ru for each in losses if each] == ["отключён"]


def test_the_unit_is_as_without_instruments(plain: Path, tmp_path: Path) -> None:
    path = record(tmp_path / "a.pcapng", STEADY)
    assert unit_of(path) == unit_of(plain)
    assert table(path, *CHANNELS) == table(plain, *CHANNELS)
    assert mikas.open(path).problem_count == 0


@given(data=st.data())
@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_no_bytes_of_an_instrument_change_what_is_read_of_the_unit(
    data: st.DataObject, plain: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    piece = st.one_of(
        st.binary(max_size=40), st.sampled_from([b"\x02\xfe\x0d", b"\x01\xff\x0d", b"14.7\r\n"])
    )
    chunk = st.tuples(
        st.integers(0, 1), piece, st.floats(-0.5, 0.5), st.sampled_from(["", CONNECTED, UNPLUGGED])
    )
    said = data.draw(st.dictionaries(st.integers(0, 39), st.lists(chunk, max_size=3)))
    path = tmp_path_factory.mktemp("any") / "a.pcapng"
    record(path, said.items(), (("aem", "a"), ("nmea", "b")))
    assert unit_of(path) == unit_of(plain)
    assert table(path, *CHANNELS) == table(plain, *CHANNELS)
    assert len(mikas.open(path).channels) >= len(CHANNELS)


def test_readers_in_a_browser_pass_over_instruments_too(
    plain: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = record(tmp_path / "a.pcapng", STEADY)
    expected = table(path, "LAMBDA", *CHANNELS)
    monkeypatch.setattr(exchanges, "has_whole_numpy", lambda: False)
    assert table(path, *CHANNELS) == table(plain, *CHANNELS)
    np.testing.assert_equal(table(path, "LAMBDA", *CHANNELS), expected)


def test_two_instruments_of_a_kind_have_their_labels(tmp_path: Path) -> None:
    said = [
        (1, [(0, b"\n14.7\n", 0.0, ""), (1, b"\n13.0\n", 0.0, "")]),
    ]
    path = record(tmp_path / "a.pcapng", said, (("aem", "left"), ("aem", "right")))
    found = table(path, "AFR_LEFT", "AFR_RIGHT")["AFR_LEFT"]
    assert set(np.round(found, 3)[np.isfinite(found)]) == {14.7}
    recording = mikas.open(path)
    names = ["LAMBDA_LEFT", "AFR_LEFT", "LAMBDA_RIGHT", "AFR_RIGHT"]
    assert [each.name for each in recording.channels][-4:] == names


OWN = (
    'text = "Manometer"\ndecoder = "line"\npatterns = ["{PRESSURE} kPa"]\n'
    '[instrument.PRESSURE]\ntext = "Pressure"\nunit = "kPa"\n'
)


def test_the_file_keeps_the_definition_and_a_changed_one_decodes_it_again(tmp_path: Path) -> None:
    said = [(0, [(0, b"\n", 0.0, "")])]
    said += [(at, [(0, b"101.5 kPa 20 C\n", 0.0, "")]) for at in range(1, 40)]
    path = record(tmp_path / "a.pcapng", said, ((definition_of_text("own", OWN), ""),))
    assert np.isnan(table(path, "PRESSURE")["PRESSURE"]).all()  # the pattern forgot the temperature
    mine = tmp_path / "own.toml"
    mine.write_text(OWN.replace('kPa"]', 'kPa *"]'), encoding="utf-8")
    again = Recording(path, shipped(), names=["PRESSURE"], instruments=[str(mine)])
    values = np.concatenate([rows.values["PRESSURE"] for rows in again.rows()])
    assert set(values[5:]) == {101.5}
    other = again.interpreted("literal", ["PRESSURE", "FREQ"])  # keeps the definitions
    assert set(np.concatenate([it.values["PRESSURE"] for it in other.rows()])[5:]) == {101.5}


def test_a_definition_that_nobody_has_leaves_the_unit_readable(tmp_path: Path) -> None:
    strange = replace(definition_of_text("own", OWN), toml='decoder = "gone"\ntext = "x"\n')
    path = record(tmp_path / "a.pcapng", STEADY, ((strange, ""),))
    recording = mikas.open(path)
    assert {each.name for each in recording.channels} >= {*CHANNELS}
    (unread,) = recording.instruments_unread
    assert "gone" in unread.en
    with pytest.raises(UsageError):
        mikas.open(path, names=["PRESSURE"])


def test_a_channel_of_no_instrument_here_is_absent(plain: Path) -> None:
    recording = mikas.open(plain, names=["GPS_SPEED", "FREQ"])
    assert recording.absent == ("GPS_SPEED",)
    assert np.isnan(table(plain, "GPS_SPEED")["GPS_SPEED"]).all()
    assert mikas.open(plain, names=["lambda"]).absent == ("VALF",)  # as the unit's is called


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mf4", ".msl", ".mlg"])
def test_exports_have_the_columns(tmp_path: Path, suffix: str) -> None:
    recording = mikas.open(record(tmp_path / "a.pcapng", STEADY))
    out = tmp_path / f"a{suffix}"
    result = export(out, recording.channels, recording.rows(), about=recording.about)
    assert result.channels[-2:] == ("LAMBDA", "AFR")
    assert b"LAMBDA" in out.read_bytes()
    if suffix == ".csv":
        last = out.read_text("utf-8").splitlines()[-1].split(",")
        assert last[-1].startswith("14.7")


@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_a_cut_file_is_read_up_to_its_cut(tmp_path: Path, share: float) -> None:
    path = record(tmp_path / "a.pcapng", STEADY)
    data = path.read_bytes()
    cut = tmp_path / "cut.pcapng"
    cut.write_bytes(data[: int(len(data) * share)])
    whole, part = unit_of(path), unit_of(cut)
    assert part == whole[: len(part)]
    mikas.open(cut).to_pandas()


@needs_wireshark
@pytest.mark.parametrize("how", ["mergecap", "mergecap -a", "cat"])
def test_a_merge_keeps_each_instrument_with_its_car(tmp_path: Path, how: str) -> None:
    """Two cars on two ports, each with a λ meter; the second one's says other values."""
    other = [(at, [(0, b"\n12.5\n", 0.01, "")]) for at in range(1, 40)]
    one = record(tmp_path / "one.pcapng", STEADY)
    two = record(tmp_path / "two.pcapng", other, seed=2, port="&model=5.4")
    both = tmp_path / "both.pcapng"
    if how == "cat":
        both.write_bytes(one.read_bytes() + two.read_bytes())
    else:
        ran(*how.split(), "-w", both, one, two)
    parts = [path for _, path in split(both, tmp_path / "part.pcapng")]
    assert len(parts) == 2
    for part, original in zip(parts, (one, two), strict=True):
        found, before = (table(each, "AFR", "FREQ") for each in (part, original))
        np.testing.assert_equal(found, before)


@needs_wireshark
def test_tools_that_cut_and_shift_keep_the_instrument(tmp_path: Path) -> None:
    path = record(tmp_path / "a.pcapng", STEADY)
    moved = tmp_path / "moved.pcapng"
    ran("editcap", "-t", "3600", path, moved)
    np.testing.assert_allclose(
        [it.time - 3600 for it in instrument_packets(moved)],
        [it.time for it in instrument_packets(path)],
        atol=1e-5,
    )
    np.testing.assert_equal(table(moved, "AFR"), table(path, "AFR"))
    assert definition_named("aem").toml == next(instrument_packets(moved)).source.definition
