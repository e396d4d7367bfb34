"""Every command with a hostile unit, recording, catalog, file name and argument.

On a pipe the output has no control character but line feed and tab, in both languages and as JSON.
The pty is `posix/test_hostile_pty.py`'s.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from test_terminal import steering

from dashboard.recordings_rig import record
from mikas.cli.commands import COMMANDS

ESC = "\x1b]52;c;QQ==\x07\x1b[2J\x9b2J\u202e\r"
PASSPORT = r"\u001b]52;c;Q\u0007\u001b[2J\u000d"  # at most 16 bytes
SCENARIO = f"""
duration = 60
text = "x"
passports = ["{PASSPORT}", "{PASSPORT}", "", "", "", "", "", "{PASSPORT}"]
faults = [13, 53]
"""
WORDS = json.dumps(ESC)
CATALOG = f"""
[parameter.EVIL]
code = 0x1A
size = 1
unit = {WORDS}
text = {{ en = {WORDS}, ru = {WORDS} }}
source = {WORDS}
[fault.13]
text = {{ en = {WORDS}, ru = {WORDS} }}
check = {{ en = {WORDS}, ru = {WORDS} }}
[model.0x0A]
text = {{ en = {WORDS}, ru = {WORDS} }}
"""
NAME = f"{ESC}\n.pcapng"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder with a scenario, a catalog and a recording, whose contents and names are hostile."""
    folder = tmp_path_factory.mktemp("hostile")
    (folder / "evil.toml").write_text(SCENARIO, "utf-8")
    (folder / "own.toml").write_text(CATALOG, "utf-8")
    record(folder / NAME, f"&scenario={folder / 'evil.toml'}", count=4)
    for name in (f"a{ESC}.bin", f"b{ESC}.bin"):
        (folder / name).write_bytes(bytes(16))
    (folder / f"bad{ESC}.toml").write_text(f"[parameter.{WORDS}]\ncode = {WORDS}\n", "utf-8")
    return folder


# `{folder}` is the hostile one. Each command at least once well and once in error.
LINES = [
    ("ports",), ("doctor",), ("info",), ("params",), ("params", "EVIL"), ("evidence",), ("read",),
    ("read", "EVIL", ESC), ("scan",), ("scan", "-o", f"s{ESC}.toml"), ("faults",),
    ("watch", "EVIL", "--count", "2"), ("watch", f"no{ESC}"), ("watch", "--price", "EVIL"),
    ("log", "-o", f"l{ESC}.pcapng", "--count", "2"), ("log", "-o", f"l{ESC}.csv"),
    ("log", "-o", f"no{ESC}/l.pcapng"), ("faults", "erase"), ("faults", "erase", "--yes"),
    ("write", "EVIL", "1"), ("write", "EVIL", ESC, "--yes"), ("list", "set", "EVIL"),
    ("list", "read"), ("list", ESC), ("mem", "read", "ram", "0", "16"), ("mem", "read", ESC, ESC),
    ("mem", "write", "ram", "0", ESC), ("mem", "dump", "ram", "-o", f"d{ESC}.bin", "--to", "3"),
    ("mem", "dump", "ram", "-o", f"no{ESC}/d.bin"), ("mem", "verify", "ram", f"a{ESC}.bin"),
    ("mem", "diff", f"a{ESC}.bin", f"b{ESC}.bin"), ("mem", "diff", f"a{ESC}.bin", f"n{ESC}.bin"),
    ("mem", "restore", "ram", f"a{ESC}.bin"), ("mem", "goto", ESC), ("raw", "01"), ("raw", ESC),
    ("decode", NAME), ("decode", f"none{ESC}"), ("decode", f"a{ESC}.bin"),
    ("export", NAME, "-o", f"o{ESC}.csv", "--overwrite"), ("export", NAME, "-o", f"o{ESC}"),
    ("export", NAME, "-o", f"o{ESC}.csv", ESC), ("report", NAME, "-o", f"r{ESC}.html"),
    ("report", f"a{ESC}.bin", "-o", "r.html"), ("sim", "--tcp", ESC), ("sim", "--set", ESC),
    ("causes", NAME), ("causes", ESC), ("causes", f"a{ESC}.bin"),
    ("split", NAME), ("split", ESC), ("split", f"a{ESC}.bin"),
    ("pull", NAME, "--mass", "1400"), ("pull", ESC, "--mass", ESC), ("co", ESC), ("co", f"--{ESC}"),
    ("trip", NAME), ("trip", ESC), ("trip", NAME, "--since", ESC),
    ("find", NAME, "EVIL > 1"), ("find", NAME, ESC), ("find", f"a{ESC}.bin", "FREQ > 1"), ("test",),
    ("test", ESC), ("test", "idle", "--recording", NAME), ("test", "idle", "--recording", ESC),
    ("sim", "--replay", f"a{ESC}.bin"), ("sim", "--scenario", ESC), ("dash", "--record", NAME),
    ("sim", "--unit", f"a{ESC}.bin"), ("survey", ESC), ("survey", "-o", f"no{ESC}/s.zip", "--yes"),
    ("survey", "-o", f"s{ESC}.zip", "--yes", "--without-engine"),
    ("dash", "--http", ESC), ("demo", ESC), (ESC,), (f"--{ESC}",), ("read", f"--{ESC}=1"),
    ("info", "--port", f"sim:?{ESC}=1"), ("info", "--port", f"/dev/{ESC}"), ("info", "--port", ESC),
    ("info", "--port", f"replay:{NAME}?clock=simulated"), ("info", "-v"), ("read", "EVIL", "-vv"),
    ("params", "--catalog", f"bad{ESC}.toml"), ("params", "--catalog", f"no{ESC}"),
    ("info", "--capture", f"no{ESC}/c.pcapng"), ("info", "--lang", ESC), ("info", "--timeout", ESC),
    ("fleet", "add", NAME, "--to", f"s{ESC}"), ("fleet", "add", f"n{ESC}", "--to", "s"),
    ("fleet", "sql", f"s{ESC}", ESC), ("fleet", "report", f"n{ESC}", "-o", "f.html"),
    ("fleet", ESC),
    ("publish", ESC), ("publish", f"mqtt://{ESC}"), ("publish", "mqtt://h", "--topic", ESC),
    ("publish", "mqtt://h", ESC), ("publish", "mqtts://h", "--tls-ca", f"n{ESC}"),
    ("publish", "mqtt://h", "--user", "u", "--password-file", f"n{ESC}"),
    ("--version",), ("--help",), ("read", "--help"), ("wireshark",), ("sigrok",),
    ("sigrok", "-o", f"d{ESC}"), ("sigrok", "-o", NAME), ("help", ESC), ("help", "mem", ESC),
    ("completion", ESC), ("completion", "bash"),
]  # fmt: skip
IN_JSON = [
    ("info",), ("params",), ("read", "EVIL"), ("faults",), ("scan",), ("decode", NAME), (ESC,),
    ("watch", "EVIL", "--count", "2"), ("export", NAME, "-o", f"o{ESC}.csv"), ("ports",),
    ("mem", "dump", "ram", "-o", f"d{ESC}.bin", "--to", "3"), ("decode", f"none{ESC}"),
]  # fmt: skip


@pytest.fixture
def here(mikas, made, tmp_path, monkeypatch):
    shutil.copytree(made, tmp_path / "here")
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("MIKAS_PORT", "sim:?clock=simulated&scenario=evil.toml")
    config = tmp_path / "home/config/mikas/config.toml"
    config.parent.mkdir(parents=True)
    config.write_text(f"catalog = [{json.dumps(str(Path('own.toml').resolve()))}]\n", "utf-8")
    return mikas


def test_the_list_of_lines_has_every_command():
    assert {line[0] for line in LINES} >= set(COMMANDS)


def test_no_command_steers_the_terminal(here):
    hostile = 0
    for number, line in enumerate(LINES):
        here.speaks(("en", "ru")[number % 2])
        ran = here(*line)
        assert not steering(ran.out), line
        assert not steering(ran.err), line
        assert ran.status != 1, (line, ran.err)
        hostile += any(mark in ran.out + ran.err for mark in (r"\x1b", "\ufffd", "\u241b"))
    assert hostile > len(LINES) / 2


def test_a_name_of_two_lines_forges_no_line(here):
    forged = "a\nEverything works.\n.pcapng"
    shutil.copy(NAME, forged)
    for line in (("decode", f"no{forged}"), ("export", forged, "-o", f"{forged}.csv")):
        ran = here(*line)
        assert "Everything works" in ran.err
        assert len(ran.err.splitlines()) == 1


def test_json_output_stays_json_and_steers_no_terminal(here):
    for line in IN_JSON:
        ran = here(*line, "--json")
        assert not steering(ran.out), line
        assert not steering(ran.err), line
        assert ran.status != 1, (line, ran.out)
        assert ran.objects
