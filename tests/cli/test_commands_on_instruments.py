"""Every command that takes a recording, given one with a λ meter and a GPS beside the unit."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from shutil import copyfile

import click
import pytest
from cli_harness import Mikas, Ran

import mikas as library
from mikas.cli.completion.values import RECORDING, files
from mikas.cli.main import cli

NAMES = ("FREQ", "TWAT", "JAIR", "INJ", "VALF", "UACC", "THR", "SSM", "FUEL_FLOW")
BESIDE = ("LAMBDA", "AFR", "GPS_SPEED", "GPS_LAT", "GPS_LON", "GPS_ALT", "GPS_COURSE")


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Two drives in town, each with a meter and a receiver."""
    folder = tmp_path_factory.mktemp("drives")
    for name, seed in (("one", 3), ("two", 4)):
        with library.session(
            f"sim:?clock=simulated&scenario=city&seed={seed}",
            NAMES,
            record=folder / f"{name}.pcapng",
            duration=90,
            rate=5,
            instruments=("aem=sim:", "nmea=sim:"),
        ) as session:
            assert session.run() > 300
    return folder / "one.pcapng", folder / "two.pcapng"


@pytest.fixture
def here(drives: tuple[Path, Path], tmp_path: Path) -> None:
    """The drives where the commands are run."""
    for each in drives:
        copyfile(each, tmp_path / each.name)


def _exported(ran: Ran) -> bool:
    data = Path(ran.object["out"]).read_bytes()
    return all(name.encode() in data for name in BESIDE) and ran.object["rows"] > 300


def _way(ran: Ran) -> bool:
    return b"LAMBDA" in Path(ran.object["out"]).read_bytes()


def _chosen(ran: Ran) -> bool:
    title = Path(ran.object["out"]).read_text("utf-8").splitlines()[0]
    return [cell.split()[0] for cell in title.split(",")[1:]] == ["GPS_SPEED", "LAMBDA", "FREQ"]


COMMANDS: dict[str, Callable[[Ran], bool]] = {
    **{f"export one.pcapng -o a{it} --json": _exported for it in (
        ".csv", ".parquet", ".mf4", ".msl", ".mlg",
    )},
    "export one.pcapng -o a.gpx --json": _way,
    "export one.pcapng -o a.geojson --json": _way,
    "export one.pcapng -o a.csv GPS_SPEED LAMBDA FREQ --json": _chosen,
    "export one.pcapng -o a.csv --dialect excel --json": _exported,
    "find one.pcapng FREQ>1500 --json": lambda ran: bool(ran.object["hits"]),
    "find one.pcapng LAMBDA>0.5 --json": lambda ran: bool(ran.object["hits"]),
    "trip one.pcapng two.pcapng --json": lambda ran: ran.object["total"]["kilometres"] > 0.5,
    "pull one.pcapng --mass 1600 --json": lambda ran: "pulls" in ran.object,
    "decode one.pcapng --json": lambda ran: len(ran.objects) > 500,
    "split one.pcapng": lambda ran: "nothing to split" in ran.err,
    "report one.pcapng -o a.html --json": lambda ran: (
        ran.object["trip"]["kilometres"] > 0.2 and ran.object["mixture"] is not None
    ),
    "report one.pcapng -o a.html --json --lang ru": lambda ran: ran.object["mixture"] is not None,
    "causes one.pcapng two.pcapng --json": lambda ran: ran.object["seconds"] > 60,
    "causes one.pcapng --complaint thirsty --json": lambda ran: "verdict" in ran.object,
    "test charging --recording one.pcapng --json": lambda ran: ran.object["test"] == "charging",
    "test idle --recording one.pcapng --json": lambda ran: ran.object["test"] == "idle",
    "info --port replay:one.pcapng --json": lambda ran: "version_code" in ran.object,
    "watch FREQ TWAT --port replay:one.pcapng?clock=simulated --count 50 --json": lambda ran: (
        set(ran.objects[-1]["values"]) == {"FREQ", "TWAT"}
    ),
    "read FREQ --port replay:one.pcapng?clock=simulated --json": lambda ran: bool(ran.lines),
}  # fmt: skip


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_takes_a_recording_with_instruments(mikas: Mikas, command: str) -> None:
    ran = mikas(*command.split())
    assert ran.status == 0, ran.err
    assert COMMANDS[command](ran), ran.out


@pytest.mark.usefixtures("here")
def test_a_fleet_takes_recordings_with_instruments(mikas: Mikas, tmp_path: Path) -> None:
    pytest.importorskip("duckdb", reason="questions need the extra fleet")
    ran = mikas(
        "fleet", "add", "one.pcapng", "two.pcapng", "--to", "set", "--json", "--workers", "1"
    )
    assert (ran.status, ran.object["added"], ran.object["bad"]) == (0, 2, [])
    sql = "SELECT count(LAMBDA), max(GPS_SPEED), count(DISTINCT drive) FROM samples"
    ran = mikas("fleet", "sql", "set", sql)
    assert (ran.status, 'write the channel as "LAMBDA"' in ran.err) == (2, True)
    sql = sql.replace("LAMBDA", '"LAMBDA"')
    ran = mikas("fleet", "sql", "set", sql, "--json")
    assert ran.status == 0, ran.out
    ((count, speed, both),) = ran.object["rows"]
    assert count > 600
    assert speed > 25
    assert both == 2
    sql = "SELECT kilometres FROM drives"
    for (way,) in mikas("fleet", "sql", "set", sql, "--json").object["rows"]:
        assert way > 0.2
    assert mikas("fleet", "report", "set", "-o", "fleet.html").status == 0


def _takers(command: click.Command, words: tuple[str, ...] = ()) -> Iterator[str]:
    """Yield the commands to which the Tab key offers recordings."""
    context = click.Context(command)
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            if (found := command.get_command(context, name)) is not None:
                yield from _takers(found, (*words, name))
    for each in command.params:
        offered = {(it.type, it.value) for it in each.shell_complete(context, "")}
        if offered & {(it.type, it.value) for it in files(*RECORDING)(context, each, "")}:
            yield " ".join(words)


def test_no_command_that_takes_a_recording_is_left_out() -> None:
    tried = {command.split()[0] for command in COMMANDS}
    elsewhere = {"fleet add", "sim"}  # below; `sim --replay` is `--port replay:` on a line
    assert {*_takers(cli)} - elsewhere <= tried
    assert {"export", "trip", *elsewhere} <= {*_takers(cli)}
