"""`mikas fleet add`, `sql` and `report` on the command line: output, status, words."""

from __future__ import annotations

import json
import os
import re
import sys
from multiprocessing import resource_tracker

import pytest

import mikas as program
from fleet_rig import BEGAN, DAY, HereRunner, make
from mikas import fleet


@pytest.fixture
def recordings(tmp_path):
    for number in range(2):
        make(tmp_path / "in" / f"{number}.pcapng", began=BEGAN + number * DAY)
    return tmp_path / "in"


@pytest.fixture(scope="module", autouse=True)
def _tracker() -> None:
    """Start multiprocessing's tracker in a folder that stays.

    A pool starts it, and with a test's folder gone Python 3.13.0 can't import `socket`.
    """
    if os.name == "posix":
        resource_tracker.ensure_running()


@pytest.fixture(autouse=True)
def _here(monkeypatch) -> None:
    """The work is done in this process: test_executors.py has the others."""
    from mikas.fleet import executors

    def of(executor: str, workers: int):
        return HereRunner() if executor == "processes" else original(executor, workers)

    original = executors.runner_of
    monkeypatch.setattr(executors, "runner_of", of)


def test_add_says_what_it_did(mikas, recordings) -> None:
    ran = mikas("fleet", "add", "in", "--to", "set")
    assert (ran.status, ran.out) == (0, "")
    assert "set: recordings added: 2, 0.0 h; there already: 0" in ran.err
    ran = mikas("fleet", "add", "in", "--to", "set", "--lang", "ru", "--car", "моя")
    assert "добавлено записей: 2 (из них заново: 2)" in ran.err
    assert mikas("fleet", "sql", "set", "SELECT DISTINCT car FROM drives").lines == ["car", "МОЯ"]


def test_add_says_that_a_folder_has_no_recordings(mikas, tmp_path) -> None:
    (tmp_path / "empty").mkdir()
    ran = mikas("fleet", "add", "empty", "--to", "set")
    assert ran.status == 0
    assert ran.err.startswith("There are no recordings (.pcapng).\nset: recordings added: 0")


def test_add_in_json_and_its_status_with_a_bad_file(mikas, recordings) -> None:
    (recordings / "\x1b[31mbad.pcapng").write_text("no")
    ran = mikas("fleet", "add", "in", "--to", "set", "--json")
    assert ran.status == 2
    ((bad,),) = ([*ran.object["bad"]],)
    assert bad["file"].endswith("\x1b[31mbad.pcapng")
    assert bad["reason"]["en"]
    assert bad["reason"]["ru"]
    assert "\x1b" not in ran.out
    kept = ("schema", "added", "skipped", "replaced", "damaged", "dataset")
    assert [ran.object[key] for key in kept] == [1, 2, 0, 0, [], "set"]
    assert ran.object["seconds"] == pytest.approx(2 * 59.5, abs=1)
    ran = mikas("fleet", "add", "in", "--to", "set")
    assert ran.status == 2
    assert "\\x1b[31mbad.pcapng: " in ran.err
    assert "there already: 2; not read: 1" in ran.err


def test_add_reports_damage_and_adds_the_rest(mikas, recordings) -> None:
    data = bytearray((recordings / "0.pcapng").read_bytes())
    data[9000:9300] = bytes(300)
    (recordings / "0.pcapng").write_bytes(data)
    ran = mikas("fleet", "add", "in", "--to", "set")
    assert ran.status == 0
    assert "0.pcapng: damaged places: 1; the readable rest was added." in ran.err


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("add", "nothing", "--to", "set"), "nothing: there is no such file or folder."),
        (("add", "in"), "--to is missing"),
        (("add", "--to", "set"), "FOLDER is missing"),
        (("add", "in", "--to", "set", "--executor", "threads"), "There is no executor “threads”"),
        (("add", "in", "--to", "set", "--workers", "0"), "--workers"),
        (("sql", "nothing", "SELECT 1"), "nothing: this is no dataset of recordings"),
        (("sql", "in", "SELECT 1"), "in: this is no dataset of recordings"),
        (("report", "nothing"), "nothing: this is no dataset of recordings"),
        (("report", "nothing", "-o", "x.pdf"), "x.pdf: a report is an .html file"),
        (("add", "in", "--to", "in"), "in: this folder has other files in it"),
    ],
)
def test_wrong_use_is_status_2_with_words(mikas, recordings, argv, words) -> None:
    ran = mikas("fleet", *argv)
    assert (ran.status, ran.out) == (2, "")
    assert words in ran.err
    assert mikas("fleet", *argv, "--json").object["error"]["advice"] is not None


@pytest.mark.parametrize("missing", ["duckdb", "fsspec"])
def test_a_missing_library_is_said_with_its_command(
    mikas, recordings, monkeypatch, missing
) -> None:
    # Its modules are imported anew; afterwards the package has the present ones again.
    monkeypatch.setattr(program, "fleet", fleet)
    for name in [name for name in sys.modules if name.startswith("mikas.fleet")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, missing, None)
    if missing == "fsspec":
        monkeypatch.setitem(sys.modules, "fsspec.core", None)
    place = "in" if missing == "duckdb" else "memory://in"
    for argv in (("add", place, "--to", "memory://set"), ("sql", place, "SELECT 1")):
        ran = mikas("fleet", *argv)
        assert ran.status == 2, ran.err
        assert 'pip install "mikas[fleet]"' in ran.err


def test_sql_is_printed_as_text_csv_and_json(mikas, recordings) -> None:
    mikas("fleet", "add", "in", "--to", "set")
    asked = "SELECT car, day, max(TWAT) AS t, NULL AS n, true AS b, 'a\tb' AS s, min(utc) AS u"
    asked += " FROM samples GROUP BY car, day ORDER BY day"
    plain = mikas("fleet", "sql", "set", asked)
    assert plain.lines[0] == "car\tday\tt\tn\tb\ts\tu"
    assert plain.lines[1].startswith("A101MP52\t2026-03-02\t")
    assert len(plain.lines) == 3
    csv = mikas("fleet", "sql", "set", asked, "--csv")
    assert csv.lines[0] == "car,day,t,n,b,s,u"
    assert csv.lines[1].split(",")[3:5] == ["", "true"]
    rows = mikas("fleet", "sql", "set", asked, "--json").object
    assert rows["columns"] == ["car", "day", "t", "n", "b", "s", "u"]
    assert rows["rows"][0][:2] == ["A101MP52", "2026-03-02"]
    assert rows["rows"][0][3:6] == [None, True, "a\tb"]
    russian = mikas("fleet", "sql", "set", "SELECT 1.5::DOUBLE AS x", "--lang", "ru")
    assert russian.lines == ["x", "1,5"]
    assert mikas("fleet", "sql", "set", "SELECT 1.5::DOUBLE AS x", "--csv").lines == ["x", "1.5"]
    numbers = "SELECT 1234567.25::DOUBLE, 0.1::DOUBLE + 0.2::DOUBLE, max(utc) FROM samples"
    whole, third, time = mikas("fleet", "sql", "set", numbers).lines[1].split("\t")
    assert (whole, third) == ("1234567.25", "0.3")
    assert re.fullmatch(r"2026-03-03 07:30:59\.\d{6}", time)
    nested = "SELECT [1.5, 2], {'a': 'ж', 'b': NULL}, 'x'::BLOB, 2.5::DECIMAL(4, 2)"
    assert mikas("fleet", "sql", "set", nested, "--csv").lines[1] == (
        '"[1.5, 2.0]","{""a"": ""ж"", ""b"": null}",78,2.50'
    )
    cells = ["[1.5, 2.0]", '{"a": "ж", "b": null}', "78", "2.50"]
    assert mikas("fleet", "sql", "set", nested).lines[1].split("\t") == cells
    special = "SELECT 'nan'::DOUBLE, [1, 2], {'a': 1.5}, 'x'::BLOB, 1.5::DECIMAL(3,1)"
    ((row,),) = (mikas("fleet", "sql", "set", special, "--json").object["rows"],)
    assert row == [None, [1, 2], {"a": 1.5}, "78", 1.5]


def test_a_cars_name_is_no_formula_in_a_spreadsheet(mikas, tmp_path) -> None:
    make(tmp_path / "in" / "drive.pcapng", plate="", car="=cmd|' /C calc'!A0;=1")
    mikas("fleet", "add", "in", "--to", "set")
    asked = "SELECT name, -5 AS n, -1.5::DOUBLE AS x, '-5' AS \"@t\", '\uff1dx' AS w FROM drives"
    cells = ["'=cmd|' /C calc'!A0;'=1", "-5", "-1.5", "-5", "'\uff1dx"]
    for options, separator in (((), "\t"), (("--csv",), ",")):
        lines = mikas("fleet", "sql", "set", asked, *options).lines
        assert lines == [separator.join(["name", "n", "x", "'@t", "w"]), separator.join(cells)]
    assert mikas("fleet", "sql", "set", asked, "--json").object["rows"][0][0].startswith("=cmd")


def test_an_error_of_sql_has_its_place(mikas, recordings) -> None:
    mikas("fleet", "add", "in", "--to", "set")
    ran = mikas("fleet", "sql", "set", "SELECT * FORM drives")
    assert (ran.status, ran.err.startswith("SQL, column 15: ")) == (2, True)
    ran = mikas("fleet", "sql", "set", "SELECT *\nFORM drives", "--lang", "ru")
    assert ran.err.startswith("SQL, строка 2, знак 6: ")
    ran = mikas("fleet", "sql", "set", "SELECT count(*) FROM read_text('/etc/passwd')")
    assert "root:" not in ran.out + ran.err
    assert ran.status == 2


def test_a_report_is_written_as_text_json_and_page(mikas, recordings, tmp_path) -> None:
    make(recordings / "2.pcapng", began=BEGAN + 2 * DAY, faults=(13,))
    mikas("fleet", "add", "in", "--to", "set")
    ran = mikas("fleet", "report", "set")
    assert ran.lines[0] == "1 of 1 cars: attention needed"
    assert ran.lines[1].startswith("A101MP52: Fault 13 is stored: ")
    found = mikas("fleet", "report", "set", "-o", "fleet.html", "--json", "--lang", "ru").object
    assert found["outcome"] == "attention"
    (car,) = found["cars"]
    assert (car["car"], car["drives"], car["found"]) == ("A101MP52", 3, True)
    assert [it["code"] for it in car["faults"]] == [13]
    page = (tmp_path / "fleet.html").read_text("utf-8")
    assert "Отчёт по автопарку" in page
    assert "A101MP52" in page
    again = mikas("fleet", "report", "set", "-o", "fleet.html")
    assert (again.status, "already" in again.err) == (2, True)
    ran = mikas("fleet", "report", "set", "-o", "fleet.html", "--overwrite")
    assert ran.err.splitlines() == ["1 of 1 cars: attention needed", "fleet.html"]


def test_the_commands_of_fleet_are_listed_and_none_needs_a_port(mikas) -> None:
    ran = mikas("fleet")
    assert ran.status == 2
    for name in ("add", "sql", "report"):
        assert f"  {name} " in ran.err
    assert json.loads(mikas("fleet", "--json").out)["error"]["code"] == "UsageError"
