""".mlg (written here from the format's description alone), .msl and MDF4 of other programs."""

from __future__ import annotations

import gc
import struct
from datetime import UTC, datetime
from math import isnan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import ForeignLogError
from mikas.foreign_logs import LogChoice, preview_log, read_log

SCALAR = {0: "B", 1: "b", 2: "H", 3: "h", 4: "I", 5: "i", 6: "q", 7: "f"}


def field(version, kind, name, unit, scale=1.0, transform=0.0):
    packed = struct.pack(">B34s10sB", kind, name.encode(), unit.encode(), 0)
    if kind < 10:
        packed += struct.pack(">ffb", scale, transform, 2)
    else:
        packed += struct.pack(">BIB3x", 0, 0, 8)
    return packed + (b"Engine".ljust(34, b"\0") if version == 2 else b"")


def mlg(version, fields, blocks, started=1_700_000_000, info=b"info\0"):
    size = 24 if version == 2 else 22
    begins = size + len(b"".join(fields)) + len(info)
    codes = [SCALAR.get(it[0], {10: "B", 11: "H", 12: "I"}.get(it[0])) for it in fields]
    record = struct.calcsize(">" + "".join(codes))
    head = struct.pack(
        ">6sHIIIHH" if version == 2 else ">6sHIHIHH",
        b"MLVLG\0", version, started, begins - len(info), begins, record, len(fields),
    )  # fmt: skip
    return head + b"".join(fields) + info + b"".join(blocks)


def block(code, *values, clock=0):
    data = struct.pack(f">{code}", *values)
    return struct.pack(">BBH", 0, 0, clock) + data + bytes([sum(data) & 0xFF])


def marker(words):
    return struct.pack(">BBH50s", 1, 0, 0, words.encode())


@pytest.mark.parametrize("version", [1, 2])
def test_an_mlg_is_read_by_its_own_names_and_units(version):
    fields = [
        field(version, 4, "Time", "s", 0.001),
        field(version, 2, "RPM", "rpm"),
        field(version, 1, "CLT", "°C", 1.0, 40.0),
        field(version, 7, "AFR", ""),
        field(version, 6, "big", "", 0.1),
    ]
    blocks = [
        block("IHbfq", 1500, 850, 45, 14.7, 5),
        marker("стук"),
        block("IHbfq", 1600, 900, -60, float("nan"), -7),
    ]
    data = mlg(version, fields, blocks)
    assert [(it.name, it.unit) for it in preview_log(data, "a.mlg").columns] == [
        ("RPM", "rpm"), ("CLT", "°C"), ("AFR", ""), ("big", ""),
    ]  # fmt: skip
    log = read_log(data, "a.mlg")
    assert list(log.times) == [1.5, 1.6]
    assert list(log["RPM"].values) == [850, 900]
    assert list(log["CLT"].values) == [85, -20]
    assert log["AFR"].values[0] == 14.7  # not 14.699999809
    assert isnan(log["AFR"].values[1])
    assert list(log["big"].values) == [0.5, -0.7]
    assert log.started == datetime(2023, 11, 14, 22, 13, 20, tzinfo=UTC)
    assert [(it.time, it.text) for it in log.marks] == [(1.5, "стук")]
    assert not log.problems
    chosen = read_log(data, "a.mlg", LogChoice(columns={"CLT": "K"}))
    assert [(it.name, it.unit) for it in chosen.columns] == [("CLT", "K")]
    with pytest.raises(ForeignLogError, match="no column “TWAT”"):
        read_log(data, "a.mlg", LogChoice(columns={"TWAT": None}))


def test_bits_are_the_number_that_they_make_and_the_blocks_clock_is_a_time():
    fields = [field(2, 10, "flags", ""), field(2, 0, "flags", "")]
    blocks = [block("BB", at, at, clock=(at * 40_000) % 65_536) for at in range(4)]
    log = read_log(mlg(2, fields, blocks), "a.mlg")
    assert [it.name for it in log.columns] == ["flags", "flags (2)"]
    assert list(log["flags"].values) == [0, 1, 2, 3]
    assert list(log.times) == pytest.approx([0, 0.4, 0.8, 1.2])


def test_damage_in_an_mlg_is_said_with_its_place():
    fields = [field(1, 4, "Time", "s", 0.001), field(1, 0, "x", "")]
    good = [block("IB", at, at) for at in range(3)]
    data = mlg(1, fields, good)
    at = len(data) - 2 * len(good[0])
    wrong = bytearray(data)
    wrong[at + 4] ^= 1
    log = read_log(bytes(wrong), "a.mlg")
    assert list(log["x"].values) == [0, 2]
    assert f"1, the first at byte {at}" in log.problems[0].text.en
    cut = read_log(data[:-3], "a.mlg")
    assert list(cut["x"].values) == [0, 1]
    assert f"at byte {len(data) - len(good[0])}" in cut.problems[0].text.en
    for broken, offset, words in (
        (data[:30], 22, "header is cut"),
        (data[:7] + b"\3" + data[8:], 6, "version 3"),
        (data[:22] + b"\x63" + data[23:], 22, "unknown type 99"),
        (b"something else", 0, "not a .mlg"),
        (data[:18] + b"\0\1" + data[20:], 18, "a record has 1 bytes, its fields 5"),
    ):
        with pytest.raises(ForeignLogError, match=words) as caught:
            read_log(broken, "a.mlg")
        assert caught.value.offset == offset
    with pytest.raises(ForeignLogError, match="no records"):
        read_log(mlg(1, fields, []), "a.mlg")


@given(
    kinds=st.lists(st.sampled_from(sorted(SCALAR)), min_size=1, max_size=6),
    version=st.sampled_from([1, 2]),
    data=st.data(),
)
def test_every_type_comes_back(kinds, version, data):
    ranges = {
        "B": st.integers(0, 255), "b": st.integers(-128, 127), "H": st.integers(0, 65535),
        "h": st.integers(-32768, 32767), "I": st.integers(0, 2**32 - 1),
        "i": st.integers(-(2**31), 2**31 - 1), "q": st.integers(-(2**50), 2**50),
        "f": st.floats(width=32, allow_nan=False, allow_infinity=False),
    }  # fmt: skip
    code = "".join(SCALAR[kind] for kind in kinds)
    rows = data.draw(st.lists(st.tuples(*(ranges[each] for each in code)), min_size=1, max_size=5))
    fields = [field(version, 4, "Time", "s"), *(field(version, it, "x", "V") for it in kinds)]
    blocks = [block(f"I{code}", at, *row) for at, row in enumerate(rows)]
    log = read_log(mlg(version, fields, blocks), "a.mlg")
    assert list(log.times) == list(range(len(rows)))
    for at, (column, letter) in enumerate(zip(log.columns, code, strict=True)):
        wanted = [row[at] for row in rows]
        if letter == "f":
            assert np.array_equal(np.float32(column.values), np.float32(wanted))
        else:
            assert list(column.values) == wanted


@given(st.binary(max_size=200), st.integers(0, 250), st.integers(0, 255))
def test_any_bytes_are_an_mlg_or_an_error(tail, at, byte):
    fields = [field(2, 4, "Time", "s", 0.001), field(2, 7, "x", "")]
    data = bytearray(mlg(2, fields, [block("If", 1, 2.0), marker("m")]) + tail)
    data[8 + at % (len(data) - 8)] = byte
    try:
        log = read_log(bytes(data), "a.mlg")
    except ForeignLogError as error:
        assert error.text.ru
    else:
        assert all(len(column.values) == len(log) for column in log.columns)


MSL = (
    '"speeduino 202402: a = b; \'c\'"\n"Capture Date: Sat May 09 10:00:00 UTC 2026"\n'
    "Time\tRPM\tAFR\n{unit}\trpm\t\n0.000\t850\t14.7\nMARK 000 - knock here\n"
    "0.050\tNaN\t13.9\n0.100\t900\n"
)


@pytest.mark.parametrize("unit", ["s", ""])
def test_an_msl_has_its_units_and_its_marks(unit):
    log = read_log(MSL.format(unit=unit).encode(), "a.msl")
    assert log.format == "msl"
    assert list(log.times) == [0, 0.05, 0.1]
    assert [(it.name, it.unit) for it in log.columns] == [("RPM", "rpm"), ("AFR", "")]
    assert [str(it) for it in log["AFR"].values] == ["14.7", "13.9", "nan"]
    assert [(it.time, it.text) for it in log.marks] == [(0.05, "knock here")]
    assert not log.problems


@pytest.fixture
def mdf_of_two_clocks(tmp_path):
    asammdf = pytest.importorskip("asammdf", reason="MDF4 needs the extra mdf")
    mdf = asammdf.MDF(version="4.10")
    fast = asammdf.Signal(np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.5, 1.0]), name="AFR")
    slow = asammdf.Signal(np.array([10, 20]), np.array([0.5, 2.0]), name="Oil", unit="bar")
    text = asammdf.Signal(
        np.array([b"a", b"b"]), np.array([0.0, 1.0]), name="word", encoding="utf-8"
    )
    for each in (fast, slow, text):
        mdf.append([each])
    mdf.start_time = datetime(2026, 5, 9, 10, tzinfo=UTC)
    data = mdf.save(tmp_path / "a.mf4").read_bytes()
    mdf.close()
    return data


def test_an_mdf_of_two_clocks_is_one_table(mdf_of_two_clocks):
    data = mdf_of_two_clocks
    names = [(it.name, it.unit) for it in preview_log(data, "a.mf4").columns]
    assert names == [("AFR", ""), ("Oil", "bar"), ("word", "")]
    log = read_log(data, "a.mf4")
    assert list(log.times) == [0, 0.5, 1, 2]
    assert [str(it) for it in log["AFR"].values] == ["1.0", "2.0", "3.0", "nan"]
    assert [str(it) for it in log["Oil"].values] == ["nan", "10.0", "nan", "20.0"]
    assert log.started == datetime(2026, 5, 9, 10, tzinfo=UTC)
    assert [problem.text.en for problem in log.problems] == ["word: no numbers, left out"]
    assert list(read_log(data, "a.mf4", LogChoice(columns={"Oil": None})).times) == [0.5, 2]


# asammdf leaves its own temporary file to the garbage collector where it can't read a file.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_damaged_mdf_is_an_error(mdf_of_two_clocks):
    data = mdf_of_two_clocks
    for wrong in (data[:100], data[: len(data) // 2], data[:8] + b"3.30" + data[12:]):
        with pytest.raises(ForeignLogError, match=r"as MDF4|another version|header is cut"):
            read_log(wrong, "a.mf4")
        gc.collect()


def test_an_mdf_without_the_library_names_the_extra(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "asammdf", None)
    from mikas.errors import MissingExtra

    with pytest.raises(MissingExtra, match=r"mikas\[mdf\]"):
        read_log(b"MDF     4.10    ", "a.mf4")


def test_an_mdf_without_its_header_block_is_not_given_to_the_library(mdf_of_two_clocks):
    """It would print a traceback at its end, and name the bytes by their place in memory."""
    wrong = mdf_of_two_clocks[:64] + b"\xff" * 500
    with pytest.raises(ForeignLogError, match="byte 64: the header is cut"):
        read_log(wrong, "a.mf4")
    gc.collect()


def test_the_columns_that_there_are_stand_in_the_languages_own_quotation_marks():
    with pytest.raises(ForeignLogError) as caught:
        read_log("Время, с;Обороты\n0;800\n1;801\n".encode(), "a.csv")
    assert "“Время, с”, “Обороты”" in caught.value.text.en
    assert "«Время, с», «Обороты»" in caught.value.text.ru
