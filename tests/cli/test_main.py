"""Exit statuses, and the words of each error in both languages (docs/reference/cli.md)."""

from __future__ import annotations

import pytest
from cli_harness import is_hex, is_one_short_paragraph, is_russian

USAGE = [
    [],
    ["--json"],
    ["nosuch"],
    ["mem"],
    ["mem", "nosuch"],
    ["--bad"],
    ["read", "--por", "x"],
    ["read", "--json=1"],
    ["read", "--port"],
    ["read", "TWAT", "--lang", "de"],
    ["read", "--timeout", "0"],
    ["read", "--timeout", "nan"],
    ["read", "--timeout", "61"],
    ["read", "--inter-byte", "0"],
    ["read", "--inter-byte", "0.0009"],
    ["read", "--inter-byte", "fast"],
    ["read", "--pause", "-0.1"],
    ["read", "--pause", "2.5"],
    ["read", "--pause", "soon"],
    ["read", "--checksum", "stuff"],
    ["read", "--strict=1"],
    ["read", "--no-strict=1"],
    ["read", "--retries", "-1"],
    ["read", "--retries", "many"],
    ["read", "--echo", "maybe"],
    ["read", "--interpretation", "other"],
    ["params", "extra", "more"],
    ["faults", "zap"],
    ["watch", "--method", "foo"],
    ["watch", "--rate", "0"],
    ["watch", "--rate", "inf"],
    ["watch", "--count", "0"],
    ["watch", "--count", "x"],
    ["watch", "--duration", "-1"],
    ["watch", "NOSUCH"],
    ["log"],
    ["log", "-o"],
    ["log", "-o", "."],
    ["log", "-o", "a.pcapng", "--rotate", "10"],
    ["log", "-o", "a.pcapng", "--rotate", "0s"],
    ["log", "-o", "a.pcapng", "--rotate", "often"],
    ["watch", "NOSUCH", "--price"],
    ["watch", "TWAT/0"],
    ["read", "TWAAT"],
    ["read", "0x"],
    ["read", "0x1A:9"],
    ["write"],
    ["write", "UOZ"],
    ["write", "UOZ", "1", "--raw", "14"],
    ["write", "UOZ", "abc"],
    ["write", "UOZ", "1000"],
    ["write", "UOZ", "nan"],
    ["write", "UOZ", "inf"],
    ["write", "UOZ", "--nosuch"],
    ["write", "UOZ", "5", "--nosuch"],
    ["write", "NOSUCH", "5"],
    ["write", "DET", "1"],
    ["write", "INJ", "--raw", "14"],
    ["mem", "read"],
    ["mem", "read", "rom", "40"],
    ["mem", "read", "ram"],
    ["mem", "read", "ram", "zz"],
    ["mem", "read", "ram", "4_0"],
    ["mem", "read", "ram", "-1"],
    ["mem", "read", "ram", "100"],
    ["mem", "read", "ram", "F0", "0x20"],
    ["mem", "read", "ram", "40", "0"],
    ["mem", "read", "code", "FFFF", "2"],
    ["mem", "write", "ram", "40", "0"],
    ["mem", "write", "ram", "FF", "0102"],
    ["mem", "write", "ram", "40", "xy"],
    ["mem", "goto", "10000", "--yes", "--i-know-what-this-does"],
    ["mem", "dump", "ram"],
    ["mem", "dump", "ram", "-o", "x", "--from", "80", "--to", "7F"],
    ["mem", "dump", "ram", "-o", "x", "--to", "100"],
    ["mem", "dump", "ram", "-o", "x", "--block", "0"],
    ["mem", "dump", "ram", "-o", "x", "--block", "300"],
    ["mem", "verify", "ram", "empty", "--block", "256"],
    ["log", "-o", "a.pcapng", "NOSUCH"],
    ["log", "-o", "a.pcapng", "--port", "nosuch://x"],
    ["watch", "--port", "sim:?nosuch=1"],
    ["report", "-o", "a.html", "--port", "nosuch://x"],
    ["report", "-o", "a.html", "--duration", "0"],
    ["causes", "empty"],
    ["causes", "absent"],
    ["causes", "--complaint", "nosuch"],
    ["causes", "note.txt", "--duration", "5"],
    ["scan", "-o", "a.toml", "--port", "nosuch://x"],
    ["survey"],
    ["survey", "-o", "a.txt", "--yes"],
    ["survey", "-o", "nosuch/a.zip", "--yes"],
    ["survey", "-o", "a.zip", "--voltmeter", "-1"],
    ["survey", "-o", "a.zip", "--yes", "--port", "nosuch://x"],
    ["export", "empty", "-o", "a.csv"],
    ["export", "note.txt", "-o", "a.mf4"],
    ["mem", "restore", "ram", "empty"],
    ["mem", "dump", "ram", "-o", "nosuch/x"],
    ["mem", "verify", "ram", "absent"],
    ["list", "set", "NOSUCH"],
    ["list", "set"],
    ["mem", "verify", "ram", "empty"],
    ["mem", "diff", "absent", "empty"],
    ["mem", "diff", "."],
    ["raw"],
    ["raw", "xyz"],
    ["raw", ""],
    ["raw", "123"],
    ["decode"],
    ["decode", "absent"],
    ["decode", "."],
    ["decode", "empty"],
    ["decode", "note.txt"],
    ["read", "--capture", "note.txt"],
    ["read", "--capture", "nosuch/x.pcapng"],
    ["log", "-o", "note.txt"],
    ["log", "-o", "a.pcapng", "--capture", "b.pcapng"],
    ["sim", "--model", "9"],
    ["sim", "--scenario", "nosuch"],
    ["sim", "--car", "nosuch"],
    ["sim", "--car", "blind"],
    ["sim", "--answer", "leak:x"],
    ["sim", "--unit", "nosuch.zip"],
    ["sim", "--unit", "note.txt"],
    ["sim", "--set", "x"],
    ["sim", "--set", "nosuch=1"],
    ["sim", "--baud", "x"],
    ["sim", "--faults", "999"],
    ["sim", "--line-fault", "damaged=2"],
    ["sim", "--tcp", "nowhere"],
    ["sim", "--tcp", "127.0.0.1:70000"],
    ["demo", "--scenario", "nosuch"],
    ["read", "--port", "nosuch://x"],
    ["read", "--port", "sim:?nosuch=1"],
    ["read", "--port", "sim:?clock=9"],
]  # fmt: skip


@pytest.fixture
def bad_files(tmp_path):
    (tmp_path / "empty").touch()
    (tmp_path / "note.txt").write_text("not a capture\n" * 10, "utf-8")


@pytest.mark.parametrize("argv", USAGE, ids=" ".join)
def test_wrong_usage_is_status_2_in_both_languages(mikas, bad_files, argv):
    for language in ("en", "ru"):
        mikas.speaks(language)
        ran = mikas(*argv)
        assert ran.status == 2
        if "--json" in argv:
            assert is_error(ran, "UsageError")
            continue
        assert ran.out == ""
        if argv not in ([], ["mem"]):  # those get the whole help
            is_one_short_paragraph(ran.err)
            if language == "ru":
                is_russian(ran.err)


@pytest.mark.parametrize("argv", USAGE, ids=" ".join)
def test_wrong_usage_as_json_leaves_no_file(mikas, bad_files, tmp_path, argv):
    files = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    ran = mikas("--json", "--capture", "new.pcapng", *argv)
    assert ran.status == 2
    error = is_error(ran)
    assert (error["sent"], error["received"]) == (None, None)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == files


def is_error(ran, code=None):
    """The one object on stdout, by the contract of docs/reference/cli.md; nothing on stderr."""
    assert ran.err == ""
    assert ran.object.keys() == {"schema", "error"}
    error = ran.object["error"]
    assert error.keys() == {"code", "message", "sent", "received", "advice"}
    assert code in (None, error["code"])
    assert error["message"]
    assert all(error["advice"])
    for name in ("sent", "received"):
        assert error[name] is None or is_hex(error[name])
    return error


def test_an_error_begins_as_a_sentence_and_a_file_by_its_name(mikas, bad_files):
    assert mikas("sim", "--scenario", "nosuch").err.startswith("There is no scenario")
    assert mikas("sim", "--scenario", "nosuch", "--lang", "ru").err.startswith("Нет ни сценария")
    assert mikas("decode", "note.txt").err.startswith("note.txt: ")
    assert mikas("write", "UOZ", "nan").err.startswith("nan does not fit")


NOBODY = [
    ("&supplied=0", "not even the echo", "01 FF 0D"),
    ("&lost=1", "the ECU does not answer", "01 FF 0D"),
    ("&lost=1&echo=0", "not even the echo", "01 FF 0D"),
    ("&adapter=elm327", "ELM327", "3F"),
]


@pytest.mark.parametrize(("sim", "message", "wire"), NOBODY)
def test_a_line_without_an_answer_is_status_3_with_the_bytes_sent(mikas, sim, message, wire):
    for argv in (["read", "TWAT"], ["watch", "--count", "1"], ["faults", "erase", "--yes"]):
        ran = mikas(*argv, sim=sim)
        assert (ran.status, ran.out) == (3, "")
        assert message in ran.err
        assert wire in ran.err
        is_one_short_paragraph(ran.err)
        as_json = mikas(*argv, "--json")
        error = is_error(as_json)
        assert as_json.status == 3
        assert message in error["message"]
        assert wire.replace(" ", "") in (error["sent"] or "") + (error["received"] or "")
        is_russian(mikas(*argv, "--lang", "ru").err)


@pytest.mark.parametrize(
    "port",
    ["/dev/nosuch", "socket://127.0.0.1:1", "rfc2217://127.0.0.1:1", "socket://no.invalid:1"],
)
def test_a_port_that_does_not_open_is_status_3_and_named(mikas, port):
    ran = mikas("read", "--port", port)
    assert (ran.status, ran.out) == (3, "")
    assert port in ran.err
    is_one_short_paragraph(ran.err)
    is_russian(mikas("read", "--port", port, "--lang", "ru").err)


def test_without_any_port_the_error_says_so(mikas, monkeypatch):
    monkeypatch.delenv("MIKAS_PORT")
    monkeypatch.setattr("mikas.link.ports.find_ports", lambda *_: [])
    ran = mikas("read", "TWAT")
    assert ran.status == 3
    assert "No port was named" in ran.err
    is_russian(mikas("read", "TWAT", "--lang", "ru").err)


@pytest.mark.parametrize("line_fault", ["damaged", "noise", "cut", "foreign", "doubled", "late"])
def test_line_faults_that_retries_do_not_cure_are_status_4(mikas, line_fault):
    ran = mikas("read", "TWAT", sim=f"&{line_fault}=1")
    assert (ran.status, ran.out) == (4, "")
    assert "sent 01 FF 0D" in ran.err
    is_one_short_paragraph(ran.err)
    is_russian(mikas("read", "TWAT", "--lang", "ru").err)


def test_line_faults_that_retries_cure_are_no_error(mikas):
    assert mikas("read", "TWAT", "--retries", "20", sim="&damaged=0.3&seed=5").status == 0


@pytest.mark.parametrize(
    ("argv", "sim"),
    [
        (["read", "TWAT"], "&missing=61"),
        (["read", "0x55"], ""),
        (["read", "0x55"], "&unknown=01"),
        (["faults"], "&missing=02"),
        (["write", "UOZ", "10", "--yes"], "&missing=write"),
        (["write", "UOZ", "10", "--yes"], "&missing=write&unknown=01"),
        (["faults", "erase", "--yes"], "&missing=write&faults=13"),
        (["mem", "read", "ram", "40", "4"], "&missing=bytes,blocks"),
        (["mem", "read", "sfr", "81"], "&missing=sfr"),
        (["mem", "dump", "ram", "-o", "x"], "&missing=bytes,blocks"),
        (["watch", "TWAT", "--method", "list", "--count", "1"], "&missing=list"),
        (["watch", "TWAT", "--method", "stream", "--count", "1"], "&missing=stream"),
        (["watch", "TWAT", "--method", "stroke1", "--count", "1"], "&missing=stroke"),
    ],
)
def test_what_the_unit_refuses_or_does_not_know_is_status_5(mikas, argv, sim):
    ran = mikas(*argv, sim=sim)
    assert ran.status == 5, ran.err
    assert ran.out == "" or "erase" in argv
    is_one_short_paragraph(ran.err.splitlines()[-1])
    is_russian(mikas(*argv, "--lang", "ru").err)


CHANGES = [
    ["faults", "erase"],
    ["write", "UOZ", "10"],
    ["write", "UOZ", "--raw", "14"],
    ["mem", "write", "ram", "40", "0D"],
    ["mem", "write", "code", "8000", "0D"],
    ["mem", "goto", "8000"],
    ["raw", "620E08"],
    ["raw", "99"],
]


@pytest.mark.parametrize("argv", CHANGES, ids=" ".join)
def test_without_a_terminal_a_change_needs_yes(mikas, argv):
    ran = mikas(*argv, "--json", sim="&faults=13")
    assert (ran.status, ran.object["error"]["code"]) == (6, "NotConfirmed")
    ran = mikas(*argv)
    assert ran.status == 6
    assert "--yes" in ran.err
    assert not list(mikas.home.glob("state/mikas/journal*"))
    is_russian(mikas(*argv, "--lang", "ru").err)


@pytest.mark.parametrize("answer", ["n\n", "\n", "", "maybe\n", "нет\n"])
@pytest.mark.parametrize("argv", CHANGES[:1] + CHANGES[5:6], ids=" ".join)
def test_the_answer_no_changes_nothing_and_is_status_6(mikas, argv, answer):
    mikas.answers(answer)
    ran = mikas(*argv, sim="&faults=13")
    assert ran.status == 6
    assert "Do it?" in ran.err
    assert not list(mikas.home.glob("state/mikas/journal*"))


@pytest.mark.parametrize("answer", ["y\n", "YES\n", "д\n", " Да \n"])
def test_the_answer_yes_makes_the_change(mikas, answer):
    for argv in CHANGES:
        mikas.answers(answer)
        ran = mikas(*argv, "--lang", "ru", sim="&faults=13")
        assert ran.status == 0, ran.err
        assert "Выполнить?" in ran.err
        is_russian(ran.err)
        is_russian(ran.out, wordy=False)


TWO_YESES = [["mem", "goto", "8000"], ["raw", "410080"], ["raw", "41"],
             ["raw", "1600800D"], ["raw", "26 00 80 01 0D"]]  # fmt: skip


@pytest.mark.parametrize("argv", TWO_YESES, ids=" ".join)
def test_a_jump_and_a_raw_write_to_code_take_two_yeses(mikas, argv):
    ran = mikas(*argv, "--yes", sim="&supplied=0")  # not even tried
    assert ran.status == 6
    assert "--i-know-what-this-does" in ran.err
    is_russian(mikas(*argv, "--yes", "--lang", "ru").err)
    assert mikas(*argv, "--i-know-what-this-does", sim="").status == 6
    both = ["--yes", "--i-know-what-this-does"]
    assert mikas(*argv, *both).status == 0
    assert [it["state"] for it in mikas.journal] == ["started", "done"]


@pytest.mark.parametrize("body", ["620E08", "1240 0D", "22 40 01 0D", "14 00 10 0D", "32 81 07"])
def test_another_raw_change_takes_one(mikas, body):
    assert mikas("raw", body, "--yes").status == 0


@pytest.mark.parametrize("verbose", [False, True])
def test_a_bug_says_that_it_is_one(mikas, monkeypatch, verbose):
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr("mikas.catalog.own.file.OwnCatalog.load", broken)
    ran = mikas("params", *(["-v"] if verbose else []))
    assert (ran.status, ran.out) == (1, "")
    assert "a bug in mikas" in ran.err
    assert ("Traceback" in ran.err) is verbose
    as_json = mikas("params", "--json")
    assert (as_json.status, is_error(as_json)["code"]) == (1, "InternalError")


def test_ctrl_c_ends_a_command_without_a_traceback(mikas, monkeypatch):
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("mikas.catalog.own.file.OwnCatalog.load", interrupted)
    for argv in (["params"], ["params", "--json"]):
        ran = mikas(*argv)
        assert (ran.status, ran.out, ran.err) == (130, "", "\n")


def test_a_slip_in_a_name_or_an_option_is_answered_with_the_nearest(mikas):
    assert "Did you mean TWAT" in mikas("read", "TWAAT").err
    assert "Did you mean read" in mikas("raed").err
    assert "Did you mean dump" in mikas("mem", "dmup").err
    assert "--port" in mikas("read", "--prot", "x").err
