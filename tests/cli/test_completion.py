"""What a shell is offered: commands, options, and the values that people use."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import click
import pytest

from mikas.cli import completion
from mikas.cli.click_extensions import LocalizedGroup
from mikas.cli.commands import COMMANDS
from mikas.cli.language import set_language
from mikas.cli.main import cli, run
from mikas.link.ports import Port
from tester.tester_rig import case

PACKED = "pcapng,gz,bz2,xz,lzma,zip,zst,lz4,7z"


@pytest.fixture
def answered(monkeypatch, capsys, mikas):
    """Asks as bash does; returns the lines of the answer, without its first."""

    def ask(line: str) -> list[list[str]]:
        monkeypatch.setenv(completion.VARIABLE, "bash_complete")
        monkeypatch.setenv("COMP_LINE", line)
        capsys.readouterr()
        assert completion.is_asked()
        status = completion.answer(cli)
        shown = capsys.readouterr()
        assert (status, shown.err) == (0, "")
        lines = [each.split("\t") for each in shown.out.splitlines()]
        assert lines[0][0] == "word"
        return lines[1:]

    yield ask
    set_language("en")


@pytest.fixture
def offered(answered):
    """As `answered`, the values only."""
    return lambda line: [value for _, value, _ in answered(line)]


def test_commands_are_completed_with_what_they_do(answered, offered):
    assert answered("mikas re") == [
        ["plain", "read", "read parameters once"],
        ["plain", "report", "a report on the car, from a recording or measured now"],
    ]
    assert offered("mikas ") == list(COMMANDS)
    assert offered("mikas mem d") == ["dump", "diff"]
    assert offered("mikas help mem d") == ["dump", "diff"]
    assert answered("mikas --lang ru wat") == [["plain", "watch", "таблица текущих значений"]]


def test_names_of_channels_are_completed_by_any_of_their_names(answered, offered):
    assert answered("mikas read fr") == [
        ["plain", "FREQ", "Crankshaft speed"], ["plain", "FREQX", "Idle speed"],
    ]  # fmt: skip
    assert offered("mikas read FREQ fr") == ["FREQX"]
    assert "обороты" in offered("mikas watch об")
    assert offered("mikas log TWAT batt_") == ["batt_v"]
    assert "TWAT" in offered("mikas export a.pcapng tw")
    assert "TWAT" in offered("mikas write tw")
    assert answered("mikas find a.pcapng gps_sp") == [["plain", "GPS_SPEED", "Speed by GPS"]]
    assert offered("mikas read gps_sp") == []


def test_names_of_a_catalog_of_one_s_own_are_completed(offered, tmp_path):
    (tmp_path / "own.toml").write_text(
        '[parameter.BOOST]\ncode = 0x33\nsize = 1\nunit = "kPa"\n'
        'text = { en = "Boost", ru = "Наддув" }\n',
        "utf-8",
    )
    assert offered("mikas read --catalog own.toml BOO") == ["BOOST"]
    assert offered("mikas read --catalog none.toml FREQX") == ["FREQX"]


def test_options_are_completed_with_their_texts_and_once(answered, offered):
    assert answered("mikas mem dump --f") == [["plain", "--from", "first address (0)"]]
    assert answered("mikas mem dump --lang ru --f")[0][2] == "первый адрес (0)"
    assert "--to" not in offered("mikas mem dump --to 80 --")
    assert {"--catalog", "-v"} <= set(offered("mikas read -v --catalog a.toml -"))
    assert "--host-port" in offered("mikas dash ")  # it has no arguments


def test_values_of_options_are_completed(offered, monkeypatch):
    for line, values in (
        ("mikas watch --method s", ["single", "stream", *(f"stroke{n}" for n in range(5))]),
        ("mikas read --echo=o", ["--echo=on", "--echo=off"]),
        ("mikas read --lang ", ["en", "ru"]),
        ("mikas faults ", ["erase"]),
        ("mikas mem read ", ["ram", "xram", "code", "sfr"]),
        ("mikas sim --scenario ci", ["city", "toml"]),
        ("mikas sim --line-fault d", ["damaged=", "doubled="]),
        ("mikas sim --set late", ["latency_ms=", "late_by=", "late="]),
        ("mikas demo --car leak:8,batt", ["leak:8,battery"]),
        ("mikas demo --faults 13,53,5", [f"13,53,5{n}" for n in range(1, 5)]),
        ("mikas test id", ["idle"]),
        ("mikas test idle --skip ", ["warm", "idle", "fast"]),
        ("mikas causes --complaint h", ["hunts"]),
        ("mikas completion ", ["bash", "zsh", "fish", "powershell"]),
        ("mikas publish m", ["mqtt://", "mqtts://"]),
    ):  # fmt: skip
        with case(line):
            found = offered(line)
            assert found[: len(values)] == values or set(values) <= set(found)
    ports = [Port("/dev/ttyUSB7", "FT232", "")]
    monkeypatch.setattr("mikas.link.ports.find_ports", lambda: ports)
    assert offered("mikas --port /") == ["/dev/ttyUSB7"]
    assert {"/dev/ttyUSB7", "sim:", "replay:", "socket://"} <= set(offered("mikas --port "))
    assert offered("mikas --port=sim:?scenario=ci") == ["--port=sim:?scenario=city"]
    assert "sim:?seed=1&model=7.1" in offered("mikas read --port sim:?seed=1&model=")


def test_files_are_left_to_the_shell_with_their_endings(answered):
    for line, answer in (
        ("mikas decode dr", [["file", PACKED, ""]]),
        ("mikas export a.pcapng -o ", [["file", "csv,mf4,parquet,msl,mlg,gpx,geojson", ""]]),
        ("mikas read --capture=dr", [["file", "pcapng", "--capture="]]),
        ("mikas sim --unit ", [["file", "zip,json", ""]]),
        ("mikas --port sim:?unit=", [["file", "zip,json", "sim:?unit="]]),
        ("mikas read --port replay:", [["file", PACKED, "replay:"]]),
        ("mikas read --port=replay:", [["file", PACKED, "--port=replay:"]]),
        ("mikas mem diff a.bin ", [["file", "", ""]]),
        ("mikas fleet sql ", [["dir", "", ""]]),
        ("mikas dash --record ", [["dir", "", ""]]),
    ):
        with case(line):
            assert answered(line) == answer


# What is counted, measured or named freely.
FREE = {
    "--timeout", "--inter-byte", "--pause", "--retries", "--rate", "--count", "--duration",
    "--rotate", "--car", "--plate", "--mileage", "--workshop", "--topic", "--user", "--client-id",
    "--every", "--qos", "--discovery-prefix", "--name", "--raw", "--from", "--to", "--block",
    "--workers", "--baud", "--seed", "--latency-ms", "--host-port", "[VALUE]", "ADDR", "[COUNT]",
    "HEX", "SQL", "--voltmeter", "--tachometer", "--starter", "--since",
    "--mass", "--per-1000", "--drag-area", "--slope", "--target", "--within", "--measured",
}  # fmt: skip


def test_every_option_and_argument_offers_something_or_is_free(mikas):
    for path, command in commands():
        for it in command.params:
            if isinstance(it, click.Option) and (it.is_flag or it.count):
                continue
            name = it.opts[-1] if isinstance(it, click.Option) else it.make_metavar(None)
            ctx = click.Context(command, info_name="x", parent=click.Context(cli))
            with case(path, name):
                offers = it.shell_complete(ctx, "")
                assert offers or name in FREE or name == "--skip"


def commands(group=cli, path=()):
    for name in group.homes:
        inner = group.get_command(click.Context(group), name)
        if isinstance(inner, LocalizedGroup):
            yield from commands(inner, (*path, name))
        else:
            yield (*path, name), inner


def test_an_error_completes_nothing_and_says_nothing(offered, monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("MIKAS_CONFIG", str(tmp_path / "config.toml"))
    (tmp_path / "config.toml").write_text("port = 1 1\n", "utf-8")
    (tmp_path / "catalog.toml").write_text("[parameter.X\n", "utf-8")
    assert offered("mikas read FREQX") == ["FREQX"]
    assert offered("mikas decode 'a b") == [PACKED]
    for line in ("mikas nosuch ", "mikas mem nosuch re"):
        monkeypatch.setenv("COMP_LINE", line)
        assert completion.answer(cli) == 1
    for asked in ("nonsense", "", "bash_", "nosuch_source"):
        monkeypatch.setenv(completion.VARIABLE, asked)
        assert run([]) == 1
    assert "mikas" not in capsys.readouterr().err
    assert capsys.readouterr().err == ""


def test_a_line_with_version_or_help_in_it_is_only_completed(offered):
    assert "read" in offered("mikas --version re")
    assert "--port" in offered("mikas read --help --por")


@pytest.mark.parametrize("shell", completion.SHELLS)
def test_the_script_is_printed_by_a_command_and_as_click_would(mikas, monkeypatch, shell):
    script = completion.script(shell)
    assert mikas("completion", shell).out == script
    assert mikas("completion", shell, "--json").object == {
        "schema": 1, "shell": shell, "script": script,
    }  # fmt: skip
    monkeypatch.setenv(completion.VARIABLE, f"{shell}_source")
    assert mikas().out == script
    assert f"{shell}_complete" in script


def test_other_shells_ask_by_words(mikas, monkeypatch):
    for shell, words, value in (
        ("zsh", "mikas\nread\nfr", "FREQ"),
        ("fish", "mikas\ndecode\n'my dr", PACKED),
        ("powershell", "mikas\nsim\n--car\nleak,batt", "leak,battery"),
    ):
        monkeypatch.setenv(completion.VARIABLE, f"{shell}_complete")
        monkeypatch.setenv("COMP_WORDS", words)
        first, second, *_ = mikas().lines
        assert first == f"word\t{words.splitlines()[-1].lstrip(chr(39))}"
        assert second.split("\t")[1] == value


LIGHT = {"click", "mikas", "platformdirs", "serial"}


@pytest.mark.parametrize(
    "line", ["mikas ", "mikas re", "mikas read fr", "mikas sim --scenario ", "mikas log -o ",
             "mikas watch --", "mikas --port ", "mikas test ", "mikas export a.pcapng -o "],
)  # fmt: skip
def test_completion_loads_nothing_heavy(tmp_path, line):
    program = (
        "import json, sys\n"
        "from mikas.cli.main import run\n"
        "status = run([])\n"
        "sys.stderr.write(json.dumps([status, sorted(sys.modules)]))\n"
    )
    asked = {completion.VARIABLE: "bash_complete", "COMP_LINE": line}
    environment = os.environ | asked | {"MIKAS_CONFIG": str(tmp_path / "c")}
    ran = subprocess.run(
        [sys.executable, "-S", "-c", f"import sys; sys.path[:] = {sys.path!r}\n{program}"],
        capture_output=True, text=True, encoding="utf-8", env=environment, check=True,
    )  # fmt: skip
    status, loaded = json.loads(ran.stderr)
    assert status == 0
    foreign = {name.partition(".")[0] for name in loaded} - LIGHT - sys.stdlib_module_names
    assert not {name for name in foreign if not name.startswith("_")}
