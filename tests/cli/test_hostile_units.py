"""Every command against every manner of a hostile unit, on simulated time.

Each ends by itself or at Ctrl-C, in bounded time, calls and bytes, with a status of
docs/reference/cli.md and an error of mikas; no change is made that was not confirmed, or twice;
recordings can be read.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from pathlib import Path
from shutil import rmtree

import pytest

from hostile_rig import (
    CONNECTED,
    MANNERS,
    URL,
    Babble,
    EndlessFrame,
    EndlessStream,
    Flood,
    Manner,
    World,
    hostile,
)
from mikas import commands as c
from mikas.cli.commands import COMMANDS, groups
from mikas.commands.base import Write
from mikas.dashboard.session.port_threads import SamplingThread
from mikas.dashboard.settings import PlanSettings, PortSettings, Settings
from mikas.link import Direction
from mikas.link.flood import BACKLOG
from mikas.recording.capture.reader import CaptureReader, Problem
from mikas.recording.recorder import Recorder
from mikas.sampling.events import CycleFailed, StateChanged
from publish.broker_rig import InProcessBroker
from tester.tester_rig import case

CHANGES = {
    code for command in c.ALL_COMMANDS if issubclass(command, Write) for code in command.CODES
} | {0x12, 0x14, 0x16, 0x32, 0x41}
LIST = 0x64  # volatile; sampling sets it too
ENDINGS = {0, 3, 4, 5, 6}
RECORDING = Path("drive.pcapng")


@dataclass(frozen=True)
class Case:
    """A command line. `changes`: the codes of the changes that `confirmed` words let it make."""

    line: str
    changes: frozenset[int] = frozenset()
    confirmed: str = ""
    interrupted: float = inf


def changing(line: str, *codes: int, confirmed: str = "--yes") -> Case:
    return Case(line, frozenset(codes), confirmed)


CASES = {
    "doctor": Case("doctor --other-units"),
    "info": Case("info"),
    "read": Case(f"read FREQ TWAT --capture {RECORDING}"),
    "scan": Case("scan", interrupted=30.0),
    "watch": Case("watch FREQ --rate 10", interrupted=4.0),
    "log": Case(f"log -o {RECORDING} FREQ --rate 10", interrupted=4.0),
    "faults": Case("faults"),
    "faults erase": changing("faults erase", 0x62),
    "write": changing("write UOZ 1", 0x62),
    "co": changing("co --target 0.8 --measured 2", 0x62),
    "list set": changing("list set FREQ", 0x64),
    "list read": Case("list read FREQ"),
    "mem read": Case("mem read ram 0 64"),
    "mem write": changing("mem write ram 40 55", 0x12),
    "mem dump": Case("mem dump ram -o out.bin"),
    "mem restore": changing("mem restore ram ram.bin --ignore-manifest --from 0", 0x22),
    "mem verify": Case("mem verify ram ram.bin"),
    "mem goto": changing("mem goto 1000", 0x41, confirmed="--yes --i-know-what-this-does"),
    "raw": Case("raw 0129"),
    "test": Case("test sensors --duration 1"),
    "causes": Case("causes --duration 1"),
    "report": Case("report -o report.html --duration 1"),
    "survey": Case("survey -o unit.zip --yes", interrupted=60.0),
}
WITHOUT_A_UNIT = {
    "ports", "params", "evidence", "decode", "export", "find", "split", "trip", "pull",
    "wireshark", "sigrok", "fleet", "sim", "demo", "mem diff", "help",
    "completion",
}  # fmt: skip
APART = {"dash", "publish"}  # below


def test_every_command_has_a_case():
    split = {"mem": groups.mem.homes, "list": groups.list.homes}
    names = {name for name in COMMANDS if name not in split}
    names |= {f"{group} {name}" for group, inner in split.items() for name in inner}
    assert names | {"faults erase"} == set(CASES) | WITHOUT_A_UNIT | APART


@pytest.fixture
def unit(mikas, monkeypatch):
    """Run a command line on a hostile unit; return what it did, and the world."""
    monkeypatch.setenv("MIKAS_PORT", URL)
    Path("ram.bin").write_bytes(bytes(range(255, -1, -1)))

    def run(line, manner, **settings):
        for left in (RECORDING, Path("out.bin"), Path("out.bin.json"), Path("report.html")):
            left.unlink(missing_ok=True)
        rmtree("unit.zip.part", ignore_errors=True)
        with hostile(manner, **settings) as world:
            return mikas(*line.split()), world

    return run


def check_recording(path: Path, world: World) -> None:
    """Whole, and with all that came, up to Ctrl-C in the middle of a read; and no larger.

    Frames that were never requested are named, as in a file whose requests another tool cut off.
    """
    items = list(CaptureReader(path))
    problems = [it.text.en for it in items if isinstance(it, Problem)]
    assert all(it.startswith("a stream goes on here whose request is missing") for it in problems)
    assert not problems or isinstance(world.manner, Babble | EndlessStream)
    packets = [it for it in items if not isinstance(it, Problem)]
    received = sum(len(it.data) for it in packets if it.direction is Direction.RECEIVED)
    assert world.brought - BACKLOG <= received <= world.brought
    assert path.stat().st_size <= 50_000 + 20 * world.brought + 2000 * world.time


def check(ran, world: World, changes: frozenset[int]) -> None:
    assert ran.status in (ENDINGS | {130} if world.is_interrupted else ENDINGS), ran
    assert "Traceback" not in ran.err
    assert "bug in mikas" not in ran.err
    if ran.status in ENDINGS - {0}:
        assert (ran.err + ran.out).strip(), "no word"
    made = [body for body in world.bodies if body[0] in CHANGES]
    assert {body[0] for body in made} <= changes | {LIST}, made
    once = [body for body in made if body[0] != LIST]
    assert len(once) == len(set(once)), made
    assert world.brought <= world.most_bytes
    assert world.opened <= world.time + 2  # a port that fails is not opened without end
    if world.is_interrupted:
        assert world.calls_after_interrupt <= 200
        assert world.time - world.interrupted <= 10
    if RECORDING.exists():
        check_recording(RECORDING, world)


@pytest.mark.parametrize("name", CASES)
def test_every_command_ends_before_a_hostile_unit(unit, name):
    it = CASES[name]
    for manner in MANNERS:
        for since in (0.0, CONNECTED):
            with case(manner.__name__, since):
                line = f"{it.line} {it.confirmed}".strip()
                check(*unit(line, manner, since=since, interrupted=it.interrupted), it.changes)


@pytest.mark.realtime
def test_publishing_ends_before_a_hostile_unit(unit):
    broker = InProcessBroker()
    line = f"publish mqtt://127.0.0.1:{broker.port} FREQ --rate 10 --capture {RECORDING}"
    try:
        for manner in MANNERS:
            for since in (0.0, CONNECTED):
                with case(manner.__name__, since):
                    check(*unit(line, manner, since=since, interrupted=4.0), frozenset())
    finally:
        broker.close()


@pytest.mark.parametrize("name", [name for name, it in CASES.items() if it.changes])
def test_nothing_is_changed_that_was_not_confirmed(unit, name):
    for manner in MANNERS:
        with case(manner.__name__):
            ran, world = unit(CASES[name].line, manner)
            assert ran.status in ENDINGS - {0}
            assert not CHANGES & {body[0] for body in world.bodies}


def test_log_ends_though_the_unit_turns_hostile_while_it_is_recorded(unit):
    """While its methods are measured, and in a stream."""
    for manner in MANNERS:
        with case(manner.__name__):
            check(*unit(CASES["log"].line, manner, since=1.0, interrupted=10.0), frozenset())


def test_watch_names_a_babbling_line(unit):
    """And not a silent unit; once."""
    ran, _ = unit(CASES["watch"].line, Babble, since=1.0, interrupted=30.0)
    assert ran.err.count("The line does not become idle: something keeps sending.") == 1
    assert "silent" not in ran.err


@pytest.mark.parametrize("language", ["en", "ru"])
@pytest.mark.parametrize("manner", [Flood, EndlessFrame])
def test_log_names_a_flood_and_keeps_to_a_bound(unit, manner: type[Manner], language):
    ran, world = unit(
        f"{CASES['log'].line} --lang {language}", manner, since=1.0, interrupted=300.0
    )
    check(ran, world, frozenset())
    assert ran.status == 130
    assert world.opened <= 300 / 20 + 2
    words = {
        "en": ("bytes a second: a line of 9600 baud carries 960 at most", "resumes by itself"),
        "ru": ("линия на 9600 бод пропускает не больше 960", "опрос продолжится сам"),
    }
    for word in words[language]:
        assert word in ran.err
    assert len(ran.err) < 5000  # once, not at each attempt
    assert RECORDING.stat().st_size < 2_000_000  # in five minutes; an hour of the line is 11 MB


def test_the_sampling_of_the_dashboard_goes_on_until_it_is_stopped(tmp_path):
    """The thread of `dash`, run in this one."""
    for manner in MANNERS:
        for since in (0.0, CONNECTED, 1.0):
            with (
                case(manner.__name__, since),
                hostile(manner, since=since, interrupted=12.0) as world,
            ):
                path = tmp_path / f"{manner.__name__}{since}.pcapng"
                recorder, events, ends = Recorder(), [], []

                def take(_, event, recorder=recorder, events=events):
                    recorder.record_event(event)
                    events.append(event)

                recorder.start(path, url=URL)
                thread = SamplingThread(
                    PortSettings(URL),
                    Settings(tmp_path, state=tmp_path / "state"),
                    PlanSettings({"FREQ": 1}, rate=5.0),
                    sink=recorder,
                    confirm=lambda _: False,
                    on_event=take,
                    on_end=lambda _, error, ends=ends: ends.append(error),
                )

                def stop(thread=thread):  # as `SamplingThread.stop`, of another thread
                    thread._stoppable.stopping.set()  # noqa: SLF001
                    thread.acquisition.stop()
                    thread._stoppable.close()  # noqa: SLF001

                world.interrupt = stop
                thread.run()
                recorder.stop()
                assert not ends  # neither by itself nor by an error
                assert world.is_interrupted
                assert world.calls_after_interrupt <= 20
                assert world.time <= 14
                assert world.brought <= world.most_bytes
                assert world.opened <= world.time + 2
                failures = [e for e in events if isinstance(e, StateChanged | CycleFailed)]
                assert len(failures) <= 60
                check_recording(path, world)
