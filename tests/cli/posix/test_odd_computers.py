"""Every command on odd computers: it does its work, or says why not; no bug, no traceback.

As root they run as a user without a name, for whom a folder can be sealed and a disk be full. What
needs root is skipped without it, unless `MIKAS_REQUIRE_ROOT` is set: then that is a failure.
"""

from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import pytest

from fleet_rig import make
from mikas.cli.main import cli
from mikas.files import beside

SIM = ("--port", "sim:?clock=simulated")
STANDING = ("--port", "sim:?clock=simulated&scenario=survey")
STRANGER = (
    "setpriv", "--reuid=54321", "--regid=54321", "--clear-groups",
    "--inh-caps=-all,+dac_read_search", "--ambient-caps=+dac_read_search",
)  # fmt: skip
"""A user without a name; it may read the Python that runs this, wherever that is installed."""
IS_ROOT = os.geteuid() == 0 and None not in (shutil.which("setpriv"), shutil.which("unshare"))
ROOT_ONLY = pytest.mark.skipif(
    not (IS_ROOT or os.environ.get("MIKAS_REQUIRE_ROOT")),
    reason="only root becomes a user without a name, and mounts a small disk",
)
PATTERN = "-[a]*? 'запись\" "
SERVING = ("dash", "demo", "sim")
KEPT = ("write", "list set", "mem write", "mem goto", "wireshark --install", "sigrok --install")
"""What is kept below the home, or not done."""


@dataclass(frozen=True, slots=True)
class Computer:
    """`home`: HOME, in which {folder} is the user's folder; None: absent. `prefix`: of the names
    of all files. `oddity`: see `odd_computers.py`. `is_relative`: the names are, to the current
    folder. `writes_none`: no output can be written there. `is_one_process`: as there.
    """

    home: str | None = "{folder}"
    keeps: bool = True
    prefix: str = ""
    umask: str = "022"
    oddity: str = ""
    is_relative: bool = False
    writes_none: bool = False
    missing: tuple[str, ...] = ()
    is_one_process: bool = True
    environment: dict[str, str] = field(default_factory=dict)


COMPUTERS = {
    "no home, files for the owner alone": Computer(
        None, keeps=False, umask="077", is_one_process=False
    ),
    "an empty HOME, no folder for temporary files, a terminal of another language": Computer(
        "",
        keeps=False,
        environment={
            "LANG": "xx_YY.KOI8-R", "LC_ALL": "xx_YY.KOI8-R", "TMPDIR": "/nonexistent",
        },
    ),
    "the root as HOME, closed streams": Computer(
        "/", keeps=False, oddity="closed", is_one_process=False
    ),
    "a read-only HOME, a current folder that can't be read": Computer(
        "{folder}/sealed", keeps=False, oddity="unreadable"
    ),
    "a device as HOME, a current folder that is gone": Computer(
        "/dev/null", keeps=False, oddity="gone", is_one_process=False
    ),
    "names in a current folder that is gone": Computer(
        oddity="gone", is_relative=True, writes_none=True
    ),
    "signs of patterns, files for all": Computer(
        "{folder}/-[a]*? дом", prefix=PATTERN, is_relative=True, umask="000"
    ),
    "an absent HOME, names at the limit": Computer("/nonexistent", keeps=False, prefix="ж" * 122),
    "a full disk": Computer(oddity="full", writes_none=True),
}  # fmt: skip
NEED_ROOT = ("no home, files for the owner alone", "a full disk")


EXTRAS = (
    ("asammdf", "mdf", ["export", "-o", "e.mf4", "in.pcapng"]),
    ("duckdb", "parquet", ["export", "-o", "e.parquet", "in.pcapng"]),
    ("aiomqtt", "mqtt", ["publish", "mqtt://127.0.0.1", "TWAT", *SIM]),
    ("paho.mqtt", "mqtt", ["publish", "mqtt://127.0.0.1", "TWAT", *SIM]),
    ("duckdb", "fleet", ["fleet", "add", "in.pcapng", "--to", "set"]),
    ("duckdb", "fleet", ["fleet", "sql", "set", "SELECT 1"]),
    ("fsspec", "fleet", ["fleet", "report", "set"]),
    ("s3fs", "s3", ["fleet", "add", "s3://bucket/in", "--to", "set"]),
    ("distributed", "dask", [
        "fleet", "add", "in.pcapng", "--to", "set", "--executor", "dask://127.0.0.1:1",
    ]),
)  # fmt: skip
"""A library, the extra that has it, and a line that needs it."""
COMPUTERS["no extras"] = Computer(
    missing=tuple(dict.fromkeys(library for library, _, _ in EXTRAS)), writes_none=True
)


def lines(folder: str, prefix: str) -> list[list[str]]:
    """Return a line or more for each command, in the order in which one uses files of another."""

    def at(name: str) -> str:
        return f"{folder}{prefix}{name}"

    drive, dump, dataset = at("in.pcapng"), at("d.bin"), at("set")
    serve = ("--no-browser",)
    yes, risky = ("--yes", *SIM), ("--yes", "--i-know-what-this-does", *SIM)
    return [
        ["--version"], ["ports"], ["params"], ["evidence"], ["doctor", *SIM], ["info", *SIM],
        ["read", "TWAT", "--capture", at("c.pcapng"), *SIM],
        ["scan", "--retries", "0", "-o", at("s.toml"), *SIM],
        ["watch", "TWAT", "--count", "2", *SIM],
        ["log", "-o", at("log.pcapng"), "TWAT", "--count", "2", *SIM],
        ["publish", f"mqtt://127.0.0.1:{free_port()}", "TWAT", "--count", "1", *SIM],
        ["faults", *SIM], ["write", "UOZ", "5", *yes],
        ["co", "--target", "0.8", "--measured", "2", *yes], ["list", "set", "TWAT", *yes],
        ["list", "read", "TWAT", *SIM], ["mem", "read", "ram", "0x10", "4", *SIM],
        ["mem", "write", "ram", "0x10", "01", *yes], ["mem", "dump", "ram", "-o", dump, *SIM],
        ["mem", "verify", *SIM, "--", "ram", dump], ["mem", "restore", *yes, "--", "ram", dump],
        ["mem", "diff", "--", dump, dump], ["mem", "goto", "0x8000", *risky],
        ["raw", "01", *risky], ["decode", "--", drive],
        *(["export", "-o", at(f"e.{kind}"), "--", drive] for kind in ("csv", "mf4", "parquet")),
        ["find", "--", drive, "FREQ>0"], ["trip", "--", drive],
        ["pull", "--mass", "1600", "--per-1000", "23", "--", drive],
        ["split", "--", at("2.pcapng")],
        ["report", "-o", at("r.html"), "--", drive], ["causes", "--", drive],
        ["help", "read"], ["completion", "bash"],
        ["wireshark"], ["wireshark", "--install"], ["sigrok"], ["sigrok", "--install"],
        ["fleet", "add", "--to", dataset, "--workers", "1", "--", drive],
        ["fleet", "sql", "--", dataset, "SELECT count(*) FROM samples"],
        ["fleet", "report", "-o", at("f.html"), "--", dataset],
        ["survey", "-o", at("unit.zip"), "--yes", "--without-engine", *STANDING],
        ["evidence", "--patch", at("unit.diff"), "--", at("unit.zip")],
        ["test"], ["test", "idle", "--duration", "3", *SIM], ["sim"],
        ["dash", *serve, *SIM], ["dash", *serve, "--lan"], ["demo", *serve, "--record", at("recs")],
    ]  # fmt: skip


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def leaves(command: click.Command, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    if not isinstance(command, click.Group):
        yield path
        return
    for name in command.list_commands(context := click.Context(command)):
        yield from leaves(command.get_command(context, name), (*path, name))


def test_no_command_is_left_out():
    given = {tuple(words[:count]) for words in lines("", "") for count in (1, 2)}
    assert [path for path in leaves(cli) if path not in given] == []


Run = Callable[[dict], list[tuple[int, str]]]


@contextmanager
def program(disk: Path, **environment: str) -> Iterator[Run]:
    """Start the program on whose computers the commands run; `disk`: a small one, for root."""
    command = [sys.executable, Path(__file__).with_name("odd_computers.py")]
    if IS_ROOT:
        mounting = 'mount -t tmpfs -o size=1m,mode=777 none "$0" && exec "$@"'
        command = ["unshare", "--mount", "sh", "-c", mounting, disk, *STRANGER, *command]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env={"PATH": os.environ["PATH"], "OPENBLAS_NUM_THREADS": "1", **environment},
    ) as process:  # fmt: skip

        def run(computer: dict) -> list[tuple[int, str]]:
            print(json.dumps(computer), file=process.stdin, flush=True)
            return json.loads(process.stdout.readline())

        yield run
        process.stdin.close()


@pytest.fixture(scope="module")
def disk() -> Iterator[Path]:
    with TemporaryDirectory(prefix="mikas-") as name:
        yield Path(name)


@pytest.fixture
def drive(tmp_path) -> Path:
    """Give a recording of one car; beside it, one of two."""
    one, other = make(tmp_path / "in.pcapng"), make(tmp_path / "other.pcapng", plate="Е777КХ99")
    (tmp_path / "2.pcapng").write_bytes(one.read_bytes() + other.read_bytes())
    return one


@pytest.fixture
def folder() -> Iterator[Path]:
    """Give a folder of the user without a name, who can't look into those of pytest."""
    with TemporaryDirectory(prefix="mikas-") as name:
        if IS_ROOT:
            os.chown(name, 54321, 54321)
        yield Path(name)


@pytest.fixture(scope="module")
def run(disk) -> Iterator[Run]:
    with program(disk) as run:
        yield run


def results(
    computer: Computer, folder: Path, drive: Path, run: Run, words: list[list[str]]
) -> list[tuple[int, str]]:
    """Run command lines on `computer`, whose files are in `folder`."""
    given = {"LANG": "C.UTF-8", "MIKAS_LANG": "en", "PATH": os.environ["PATH"]}
    if computer.home is not None:
        given["HOME"] = computer.home.format(folder=folder)
    is_elsewhere = computer.oddity or not computer.is_relative
    return run({
        "environment": given | computer.environment, "umask": computer.umask,
        "folder": str(folder), "current": "current" if is_elsewhere else ".",
        "files": {
            f"{computer.prefix}{name}": str(drive.with_name(name))
            for name in ("in.pcapng", "2.pcapng")
        },
        "oddity": computer.oddity, "missing": computer.missing, "lines": words,
        "is_one_process": computer.is_one_process,
    })  # fmt: skip


def check(computer: Computer, folder: Path, drive: Path, run: Run) -> None:
    """Run every command on `computer`."""
    words = lines("" if computer.is_relative else f"{folder}/", computer.prefix)
    found = results(computer, folder, drive, run, words)
    wrong = [
        (line, status, text)
        for line, (status, text) in zip(words, found, strict=True)
        if status not in allowed(line, computer)
        or "bug in mikas" in text
        or "Traceback" in text
        or text.count("can't be kept") + text.count("can't be saved") not in said(line, computer)
    ]
    assert not wrong, "\n".join(map(str, wrong))


def allowed(line: list[str], computer: Computer) -> set[int]:
    if line[0] == "publish":
        return {2} if computer.missing else {3}  # there is no broker
    if line[:2] == ["list", "read"]:
        return {5}  # a new virtual unit has no list
    done = 130 if line[0] in SERVING else 0
    is_kept = " ".join(line).startswith(KEPT)
    return {done, 2} if computer.writes_none or (is_kept and not computer.keeps) else {done}


def said(line: list[str], computer: Computer) -> set[int]:
    """How often a line says that something can't be kept."""
    makes_certificate = line[0] == "dash" and "--lan" in line
    if makes_certificate and not computer.keeps:
        return {1}
    return {0, 1} if makes_certificate and computer.writes_none else {0}


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=ROOT_ONLY if name in NEED_ROOT else ()) for name in COMPUTERS
])  # fmt: skip
def test_every_command_does_its_work(name, folder, drive, disk, run):
    """It was “a bug in mikas” for all but two without a home."""
    check(COMPUTERS[name], disk if name == "a full disk" else folder, drive, run)
    if name.endswith("files for all"):
        (certificate,) = folder.rglob("dashboard.pem")
        assert certificate.stat().st_mode & 0o077 == 0


def test_every_command_does_its_work_where_the_system_knows_ascii_only(folder, drive, disk):
    ascii_only = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    computer = Computer("{folder}/дом", prefix="запись ", environment=ascii_only)
    with program(disk, **ascii_only) as run:
        check(computer, folder, drive, run)


@pytest.mark.parametrize(("library", "extra", "line"), EXTRAS)
def test_a_command_names_the_extra_that_is_not_installed(library, extra, line, folder, drive, run):
    computer = Computer(is_relative=True, missing=(library,))
    ((status, text),) = results(computer, folder, drive, run, [line])
    assert f'pip install "mikas[{extra}]"' in text
    assert status == 2


@ROOT_ONLY
@pytest.mark.parametrize("name", ["no home, files for the owner alone", "a full disk"])
def test_what_can_not_be_kept_is_said_once(name, folder, drive, disk, run):
    computer = COMPUTERS[name]
    log = ["log", "-o", f"{folder}/log.pcapng", "TWAT", "--duration", "9", "--plate", "A1", *SIM]
    words = [log, ["dash", "--no-browser", "--lan"], ["demo", "--no-browser"], ["read", *SIM]]
    place = disk if name == "a full disk" else folder
    environment = {**computer.environment, "MIKAS_STATE": f"{place}/sealed/state"}
    odd = replace(computer, environment=environment)
    (logged, dash, demo, read) = results(odd, place, drive, run, words)
    assert [logged[0], dash[0], demo[0], read[0]] == [0, 130, 130, 0]
    assert logged[1].count("can't be kept for the next one") == 1, logged
    learnt = f"What was learnt of this unit can't be saved in {place}/sealed/state/units ("
    assert [text.count(learnt) for _, text in (logged, read)] == [1, 0], (logged, read)
    assert dash[1].count("can't be kept, so the next start") == 1, dash
    if name != "a full disk":  # where the first recording says it
        assert [text.count("is not writable") for _, text in (dash, demo)] == [1, 1], (dash, demo)


@ROOT_ONLY
def test_the_library_reads_and_writes_without_a_home(folder):
    line = (
        "import mikas, mikas.link\n"
        "link = mikas.link.open_link('sim:?clock=simulated')\n"
        "link.is_virtual = False  # a virtual unit has no journal\n"
        "with mikas.connect(link=link, confirm=lambda _: True) as ecu:\n"
        "    print(*ecu.read('TWAT'), ecu.faults())\n"
        "    try:\n"
        "        ecu.write_parameter('UOZ', 5)\n"
        "    except mikas.MikasError as error:\n"
        "        print(error)\n"
    )
    done = subprocess.run(
        [*STRANGER, sys.executable, "-c", line], cwd=folder, check=False, capture_output=True,
        env={"PATH": os.environ["PATH"]}, text=True,
    )  # fmt: skip
    assert done.stdout.startswith("TWAT"), done
    assert "no home folder; set HOME" in done.stdout
    assert "MIKAS_STATE" in done.stdout
    assert done.stderr == ""
    assert [*folder.iterdir()] == []


def test_a_name_at_the_limit_of_the_system_gets_a_second_one(tmp_path):
    """`NAME.part` was refused by the system, though NAME was not."""
    paths = [tmp_path / f"{'ж' * 123}{end}.csv" for end in "ab"]
    seconds = [beside(path, ".part") for path in paths]
    for path in (*paths, *seconds):
        path.write_text("", "utf-8")
    assert len(set(seconds)) == 2
    assert all(second.name.endswith(".part") for second in seconds)
    assert beside(tmp_path / "short", ".part").name == "short.part"
