"""CSV of other programs: every dialect, every form of a time, and what a wrong file says."""

from __future__ import annotations

from datetime import UTC, datetime
from math import isnan, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import ForeignLogError, UsageError
from mikas.foreign_logs import (
    ENCODINGS,
    LogChoice,
    TextSettings,
    open_log,
    preview_log,
    read_log,
)


def log_of(words, *, encoding="utf-8", name="log.csv", **choice):
    return read_log(words.encode(encoding), name, LogChoice(**choice))


def values(log):
    return {column.name: list(column.values) for column in log.columns}


def test_titles_units_and_values_are_those_of_the_file():
    log = log_of("Time (s),RPM (rpm),Lambda\n0.0,850,1.01\n0.1,,0.99\n")
    assert log.format == "csv"
    assert list(log.times) == [0.0, 0.1]
    assert [(it.name, it.unit) for it in log.columns] == [("RPM", "rpm"), ("Lambda", "")]
    assert list(log["Lambda"].values) == [1.01, 0.99]
    assert log["RPM"].values[0] == 850
    assert isnan(log["RPM"].values[1])
    with pytest.raises(KeyError):
        _ = log["FREQ"]  # nothing becomes a channel of ours


@pytest.mark.parametrize("delimiter", [";", "\t", "|"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "windows-1251", "utf-16"])
def test_a_russian_log_with_a_decimal_comma(delimiter, encoding):
    rows = (("Время (мс)", "Обороты (об/мин)", "ТОЖ"), ("0", "850,5", "-3,25"), ("40", "", "88"))
    log = log_of("\r\n".join(map(delimiter.join, rows)), encoding=encoding)
    assert list(log.times) == [0, 0.04]
    assert [(it.name, it.unit) for it in log.columns] == [("Обороты", "об/мин"), ("ТОЖ", "")]
    assert log["ТОЖ"].values[0] == -3.25


def test_a_line_of_units_and_lines_above_the_titles():
    text = "Logger 3.1;\nserial;17\nt;AFR;n\ns;;rpm\n1,0;14,7;800\n2,0;13,9;900\n"
    preview = preview_log(text.encode(), "a.csv")
    assert preview.layout is not None
    assert (preview.layout.names_line, preview.layout.units_line) == (3, 4)
    assert [(it.name, it.unit) for it in preview.columns] == [("t", "s"), ("AFR", ""), ("n", "rpm")]
    assert preview.columns[1].samples == ("14,7", "13,9")
    log = log_of(text, time="t", time_unit="s", columns={"AFR": "Afr", "n": None})
    assert [(it.name, it.unit) for it in log.columns] == [("AFR", "Afr"), ("n", "rpm")]


def test_what_the_file_leaves_open_is_asked_for():
    with pytest.raises(ForeignLogError, match="which column is the time: “a”, “b”"):
        log_of("a,b\n1,2\n")
    with pytest.raises(ForeignLogError, match="in what the column “Time” counts"):
        log_of("Time,b\n1,2\n")
    with pytest.raises(ForeignLogError, match="in what the column “Date” counts"):
        log_of("Date,b\n03/04/2026 10:00:00,2\n")  # March or April?
    with pytest.raises(ForeignLogError, match="no column “c”; there are: “Time”, “b”"):
        log_of("Time,b\n1,2\n", time="c")
    with pytest.raises(ForeignLogError, match="no unit of time “fortnight”"):
        log_of("Time,b\n1,2\n", time_unit="fortnight")


@pytest.mark.parametrize(
    ("unit", "cells", "expected"),
    [
        ("s", ["1.5", "2"], [1.5, 2]),
        ("ms", ["1234", "1235"], [1.234, 1.235]),
        ("us", ["1", "3"], [0.000001, 0.000003]),
        ("min", ["0.5", "1"], [30, 60]),
        ("h", ["1", "2"], [3600, 7200]),
        ("clock", ["23:59:59.5", "00:00:00.25"], [86399.5, 86400.25]),
        ("clock", ["1:02:03 PM", "1:02:04 pm"], [46923, 46924]),
        ("date", ["1970-01-02", "1970-01-02T00:00:01.5Z"], [86400, 86401.5]),
        ("date", ["02.01.1970 03:00:00", "1970-01-02 03:00:00+02:00"], [97200, nan]),
        ("date-dmy", ["02/01/1970 00:00", "03/01/1970 00:00"], [86400, 172800]),
        ("date-mdy", ["01/02/1970 00:00", "01/03/1970 00:00"], [86400, 172800]),
    ],
)
def test_every_form_of_a_time(unit, cells, expected):
    text = "t;x\n" + "".join(f"{cell};{at}\n" for at, cell in enumerate(cells))
    log = log_of(text, time="t", time_unit=unit)
    wanted = [it for it in expected if not isnan(it)]
    assert list(log.times) == wanted
    if unit.startswith("date"):
        assert log.started == datetime.fromtimestamp(wanted[0], UTC)


def test_a_clock_and_a_date_that_leave_no_doubt_need_no_choice():
    assert list(log_of("Time,x\n10:00:00,1\n10:00:01,2\n").times) == [36000, 36001]
    log = log_of("Дата;x\n09.05.2026 10:00:00,5;1\n")
    assert log.started == datetime(2026, 5, 9, 10, 0, 0, 500_000, UTC)


def test_cells_that_are_no_numbers_are_said_with_their_line():
    log = log_of("Time (s),x,word\n0,1,on\n1,ERR,off\n2,n/a,on\n3,1 2,on\n")
    assert [it.name for it in log.columns] == ["x"]  # a column of words alone stays out
    assert [isnan(it) for it in log["x"].values] == [False, True, True, True]
    first, second = log.problems
    assert first.line == 3
    assert first.text.en == (
        "x: cells that are no number, left empty: 3; the first in line 3: “ERR”"
    )
    assert "word" in second.text.ru


def test_rows_without_a_time_or_going_back_stay_out_and_are_said():
    log = log_of("Time (s),x\n0,1\n,2\n5,3\n5,4\n1,5\n6,6\n")
    assert list(log.times) == [0, 5, 5, 6]
    assert [problem.line for problem in log.problems] == [3, 6]


def test_two_columns_of_one_name_stay_two():
    log = log_of("Time (s),T (front),T (rear),x,x,\n0,1,2,3,4,\n")
    assert list(values(log)) == ["T (front)", "T (rear)", "x", "x (2)"]


def test_many_columns_of_one_name_are_told_apart_at_once():
    """Each was compared with all before it: a line of 20,000 titles took 15 seconds."""
    titles = ["x", "x", "x (2)", "", "x", *["y"] * 30_000]
    preview = preview_log(f"t (s),{','.join(titles)}\n{'0,' * 30_006}\n".encode(), "a.csv")
    names = [column.name for column in preview.columns]
    assert names[:6] == ["t", "x", "x (2)", "x (2) (2)", "№ 5", "x (3)"]
    assert names[-1] == "y (30000)"
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("hint", ["sep=;", "SEP=;", '"sep=;"', "sep=;;;"])
def test_the_line_for_excel_is_no_row(hint, end):
    text = end.join([hint, "Time (s);RPM;A;B", "0,0;800;1;2", "0,1;810;1;2", ""])
    log = log_of(text)
    assert [(it.name, it.unit) for it in log.columns] == [("RPM", ""), ("A", ""), ("B", "")]
    assert list(log.times) == [0, 0.1]
    assert not log.problems
    log = log_of(end.join(["sep=|", "0|1", "1|2,5"]), time="№ 1", time_unit="s")
    assert values(log) == {"№ 2": [1, 2.5]}
    assert not log.problems


def test_first_rows_without_their_empty_cells_are_no_titles():
    """A meter that is connected later: a program writes its column from then on."""
    rows = ["0,800", "0.1,810", "0.2,820,14.7", "0.3,830,14.6", "0.4,840,14.5"]
    log = log_of("\n".join(["Logger,17", "Time,RPM,AFR", "s,rpm,", *rows]))
    assert [(it.name, it.unit) for it in log.columns] == [("RPM", "rpm"), ("AFR", "")]
    assert list(log.times) == [0, 0.1, 0.2, 0.3, 0.4]
    assert [isnan(value) for value in log["AFR"].values] == [True, True, False, False, False]
    log = log_of("\n".join(rows), time="№ 1", time_unit="s")
    assert len(log) == 5


@pytest.mark.parametrize(
    ("data", "line", "words"),
    [
        (b"Time (s),x\n0,1\n1,2,3\n", 3, "3 cells here, but 2 columns"),
        (b'Time (s),x\n0,1\n1,"2\n' + b"3,4\n" * 20, 23, "a quotation mark is open"),
        (b"Time (s),x\n0,1\0\n", 2, "bytes of zero"),
        (b"", None, "empty"),
        (b"\n\n\n", None, "no rows"),
        (b"Time (s),x\nhello,there\n", None, "no row of numbers"),
        (b"\n\r\r\n____", None, "a recording of mikas itself"),
        (b"PK\x03\x04...", None, "unpack"),
    ],
)
def test_a_wrong_file_is_an_error_with_its_line(data, line, words):
    with pytest.raises(ForeignLogError, match=words) as caught:
        read_log(data, "log.csv")
    assert caught.value.line == line
    assert caught.value.file == "log.csv"
    assert caught.value.text.ru
    if line:
        assert f"line {line}" in str(caught.value)


def test_bytes_outside_the_encoding_are_an_error_with_their_place():
    with pytest.raises(ForeignLogError, match="no text in windows-1251") as caught:
        read_log(b"Time (s),x\n0,\x98\xff\n", "a.csv")
    assert caught.value.offset == 13
    with pytest.raises(ForeignLogError, match="there are: utf-8, windows-1251"):
        log_of("Time (s),x\n0,1\n", text=TextSettings(encoding="koi8"))


def test_settings_of_the_user_come_first():
    text = "junk;junk\n1#5 2#5\n2#5 3#5\n"
    settings = TextSettings(delimiter=" ", decimal=",", names_line=0)
    log = log_of(text.replace("#", ","), text=settings, time="№ 1", time_unit="s")
    assert list(log.times) == [1.5, 2.5]
    assert values(log) == {"№ 2": [2.5, 3.5]}
    for wrong in ("", "ab", '"'):
        with pytest.raises(ForeignLogError, match="one character"):
            log_of(text, text=TextSettings(delimiter=wrong or "\n"))
    with pytest.raises(ForeignLogError, match="decimal sign"):
        log_of(text, text=TextSettings(decimal=";"))
    with pytest.raises(ForeignLogError, match="give another one, or 0"):
        log_of("Time (s),x\n0,1\n", text=TextSettings(names_line=99))


def test_a_number_that_may_be_two_things_is_none():
    log = log_of('Time (s);x;y\n0;"1.234,5";1,5\n1;1_000;2,5\n2;7;1e999\n')
    assert [isnan(it) for it in log["x"].values] == [True, True, False]
    assert isnan(log["y"].values[2])


def test_a_file_is_opened_by_its_path(tmp_path):
    path = tmp_path / "лог.csv"
    path.write_bytes("Time (s);x;y\n0;1,5;2\n".encode("windows-1251"))
    log = open_log(path, columns=["y"])
    assert log.name == "лог.csv"
    assert values(log) == {"y": [2]}
    frame = open_log(path).to_pandas()
    assert frame.index.name == "time"
    assert frame["x"].tolist() == [1.5]
    assert frame.attrs["units"] == {"x": "", "y": ""}
    with pytest.raises(UsageError):
        open_log(tmp_path / "none.csv")
    with pytest.raises(UsageError):
        open_log(tmp_path)


def test_a_file_that_is_too_large_is_not_read(tmp_path):
    path = tmp_path / "large.csv"
    with path.open("wb") as file:
        file.truncate((64 << 20) + 1)
    with pytest.raises(ForeignLogError, match="larger than 64 MiB"):
        open_log(path)


_numbers = st.one_of(st.none(), st.floats(-1e6, 1e6).map(lambda it: round(it, 6)))
_titles = st.lists(
    st.text("abcXYZабвЖ _-", min_size=1, max_size=12).filter(lambda it: it.strip() == it),
    min_size=1, max_size=5, unique_by=lambda it: " ".join(it.split()).casefold(),
)  # fmt: skip


@given(
    titles=_titles,
    data=st.data(),
    delimiter=st.sampled_from(";\t|,~ "),
    decimal=st.sampled_from(".,"),
    encoding=st.sampled_from(ENCODINGS[:3]),
    quoted=st.booleans(),
)
def test_what_was_written_is_read(titles, data, delimiter, decimal, encoding, quoted):
    """Whatever the dialect: all numbers come back, missing ones are NaN, names stay."""
    if delimiter == decimal:
        decimal = "."
    if delimiter == " ":  # a blank can neither stand in a title nor frame an empty cell
        titles = [f"{it}-{at}".replace(" ", "-") for at, it in enumerate(titles)]
    cells = _numbers if delimiter != " " else _numbers.filter(lambda it: it is not None)
    row = st.lists(cells, min_size=len(titles), max_size=len(titles))
    rows = data.draw(st.lists(row, min_size=1, max_size=8))

    def cell(value):
        text = "" if value is None else repr(value).replace(".", decimal)
        return f'"{text}"' if quoted and delimiter != " " else text

    lines = [delimiter.join(["t0", *titles])]
    lines += [delimiter.join([str(at), *map(cell, each)]) for at, each in enumerate(rows)]
    settings = TextSettings(encoding, delimiter, decimal, names_line=1, units_line=0)
    choice = LogChoice(settings, "t0", "s", dict.fromkeys(" ".join(it.split()) for it in titles))
    log = read_log("\n".join(lines).encode(encoding), "a.csv", choice)
    assert list(log.times) == list(range(len(rows)))
    for at, column in enumerate(log.columns):
        wanted = [nan if each[at] is None else each[at] for each in rows]
        assert [repr(it) for it in column.values] == [repr(float(it)) for it in wanted]
    assert not log.problems


@given(st.binary(max_size=400))
def test_any_bytes_are_a_table_or_an_error(data):
    for name in ("a.csv", "a.msl"):
        try:
            log = read_log(data, name, LogChoice(time="a", time_unit="s"))
        except ForeignLogError as error:
            assert error.text.en
            assert error.text.ru
        else:
            assert all(len(column.values) == len(log) for column in log.columns)
