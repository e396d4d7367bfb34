"""The pause before a request (D14): what a session finds out is kept for the unit, and all keep
to it.
"""

from __future__ import annotations

import json

import pytest
from client_harness import Bench, bench, ecu_on
from hypothesis import given
from hypothesis import strategies as st

from mikas import commands as c
from mikas.client import Ecu, connect
from mikas.client.connecting import ConnectionOptions
from mikas.client.doctor import examine
from mikas.client.limits import Limits, LimitsStore
from mikas.client.memory.dumps import Dump
from mikas.errors import UsageError
from mikas.link.virtual import VirtualLink
from mikas.tester.pauses import PAUSES
from mikas.virtual.responder import Identity

PAUSE = 0.1
OTHER = Identity(0x0A, ("ANOTHER",) + ("",) * 7)


def session(it: Bench, state=None, **options: object) -> Ecu:
    """The unit, connected as `connect` does."""
    link = VirtualLink(it.bus, start=it.link.now() if it.link else 0.0)
    it.link = link
    it.forget()
    ecu = ConnectionOptions(state=state, virtual_units=True, **options).create_ecu(link)
    ecu.tester.connect()
    return ecu


def too_soon(it: Bench) -> int:
    return sum(happened.kind == "too-soon" for happened in it.happenings)


@pytest.fixture
def it() -> Bench:
    return bench(least_pause=PAUSE)


def learnt(it: Bench, state) -> None:
    with session(it, state) as ecu:
        assert len(ecu.read()) == 23


def test_the_next_session_sends_no_request_too_soon(it, tmp_path):
    learnt(it, tmp_path)
    assert too_soon(it) > 0
    (kept,) = tmp_path.glob("*.json")
    assert json.loads(kept.read_text("utf-8"))["pause"] == PAUSE
    with session(it, tmp_path) as ecu:
        assert len(ecu.read()) == 23
        info = ecu.info()
        assert (info.pause, info.limits) == (PAUSE, Limits(pause=PAUSE))
        assert ecu.tester.statistics.failed == 0
    assert too_soon(it) == 0


@pytest.mark.parametrize("least", [0.03, 0.08, 0.1])
@pytest.mark.parametrize("task", ["faults", "info", "watch", "single", "list", "dump", "scan"])
def test_every_task_finds_the_pause_and_loses_nothing(least, task, tmp_path):
    it = bench(least_pause=least)
    with session(it, tmp_path) as ecu:
        match task:
            case "faults":
                assert len(ecu.faults()) == len(ecu.faults()) == 4
            case "info":
                assert ecu.info().passport.program[0]
                assert not [each.code for each in ecu.supported() if each.known is False]
            case "watch" | "single" | "list":
                method = "batch" if task == "watch" else task
                samples = list(ecu.watch(method=method, count=4))
                assert not samples[-1].gap
                assert len(samples[-1].readings) == 23
            case "dump":
                job = Dump(ecu, ecu.memory.ram, tmp_path / "d", first=0, last=255, resume=False)
                job.advance(block=64, progress=lambda _: None)
                assert job.manifest.complete
            case "scan":
                found = [code for code in ecu.scan() if code.size]
                assert len({code.code for code in found}) == 21
        it.forget()
        before = ecu.tester.link.now()
        assert len(ecu.tester.in_a_row(*[c.ReadFaults()] * 5)) == 5
        assert too_soon(it) == 0
        assert ecu.tester.link.now() - before >= 4 * least
        assert ecu.tester.line.pause == next(each for each in PAUSES if each >= least)


def test_another_unit_is_not_slowed_once_it_is_identified(it, tmp_path):
    learnt(it, tmp_path)
    other = bench(identity=OTHER)
    with session(other, tmp_path) as ecu:
        assert ecu.tester.line.pause == PAUSE  # this may be the unit that needs it
        assert len(ecu.read()) == 23
        assert (ecu.tester.line.pause, ecu.limits()) == (0.0, Limits())
    assert LimitsStore(tmp_path).longest_pause == PAUSE


@pytest.mark.parametrize(("least", "said"), [(PAUSE, "100 ms"), (0.0, "none failed")])
def test_the_doctor_says_so_of_this_unit_alone(it, tmp_path, least, said):
    learnt(it, tmp_path)
    other = it if least else bench(identity=OTHER)
    options = ConnectionOptions(state=tmp_path, virtual_units=True)
    link = VirtualLink(other.bus, start=other.link.now() if other.link else 0.0)
    steps = {step.name: step for step in examine(lambda: link, options.create_ecu)}
    assert steps["commands"].ok
    assert steps["line"].ok
    assert said in steps["line"].detail.en
    assert ("ignores a request" in steps["line"].detail.en) is bool(least)
    assert ("не слышит запрос" in steps["line"].detail.ru) is bool(least)


def test_another_unit_on_the_same_line_has_a_pause_of_its_own(it, tmp_path):
    with session(it, tmp_path) as ecu:
        ecu.read()
        assert ecu.tester.line.pause == PAUSE
        responder = it.bus.ecu.responder
        responder.identity = OTHER
        responder.quirks = responder.quirks.with_options({"least_pause": "0"})
        ecu.passport(again=True)
        assert ecu.limits() == Limits()
        assert ecu.tester.line.pause == 0.0


def test_a_unit_without_a_passport_is_tried_in_each_session(tmp_path):
    passports = "+".join(f"{code:02X}" for code in range(0x51, 0x59))
    it = bench(least_pause=PAUSE, missing=passports)
    for _ in range(2):
        with session(it, tmp_path) as ecu:
            assert len(ecu.read()) == 23
            assert ecu.tester.line.pause == PAUSE
        assert too_soon(it) > 0


def test_it_can_be_learnt_again(it, tmp_path):
    learnt(it, tmp_path)
    quirks = it.bus.ecu.responder.quirks
    it.bus.ecu.responder.quirks = quirks.with_options({"least_pause": "0.02"})
    with session(it, tmp_path) as ecu:
        ecu.read()
        assert ecu.tester.line.pause == PAUSE
        ecu.forget_limits()
        assert ecu.tester.line.pause == 0.0
        assert len(ecu.read()) == 23
        ecu.faults()
        assert ecu.limits().pause == 0.025
    (kept,) = tmp_path.glob("*.json")
    assert json.loads(kept.read_text("utf-8"))["pause"] == 0.025


def test_a_pause_that_is_set_is_not_kept_and_none_is_taken_over(it, tmp_path):
    learnt(it, tmp_path)
    with session(it, tmp_path, pause=0.15) as ecu:
        ecu.read()
        info = ecu.info()
        assert (info.pause, info.limits.pause) == (0.15, PAUSE)
    with session(bench(), tmp_path, pause=0) as ecu:
        ecu.read()
        assert ecu.info().pause == 0.0


SAVED = st.one_of(
    st.none(), st.booleans(), st.text(), st.lists(st.integers()), st.integers(), st.floats()
)


@given(pause=SAVED)
def test_a_file_with_any_pause_is_no_obstacle(pause, tmp_path_factory):
    folder = tmp_path_factory.mktemp("units")
    it = bench()
    LimitsStore(folder).save(0x0A, it.bus.ecu.responder.identity.passports, Limits(max_list=9))
    (kept,) = folder.glob("*.json")
    kept.write_text(json.dumps(json.loads(kept.read_text("utf-8")) | {"pause": pause}), "utf-8")
    with session(it, folder) as ecu:
        assert 0.0 <= ecu.tester.line.pause <= 2.0
        assert set(ecu.read("TWAT")) == {"TWAT"}
        assert 0.0 <= ecu.limits().pause <= 2.0


@pytest.mark.parametrize("pause", [-0.1, 2.1, float("nan"), float("inf"), "soon", True, None])
def test_what_is_no_pause_is_refused(pause):
    with pytest.raises(UsageError, match="allowed: auto, 0 … 2"):
        ConnectionOptions(pause=pause)
    with pytest.raises(UsageError, match="pause"):
        connect("sim:?clock=simulated", pause=pause)


def test_a_recording_of_such_a_unit_is_played_as_one_without(it, tmp_path):
    """What was recorded at a pause is answered at any speed, unless a pause is set there too."""
    file = tmp_path / "drive.pcapng"
    with session(it, tmp_path) as ecu, ecu.record(file):
        assert len(list(ecu.watch("TWAT", "FREQ", count=30))) == 30
    for settings, pause in (("", 0.0), ("&least_pause=0.05", 0.05)):
        with connect(f"replay:{file}?loop=1&clock=simulated{settings}") as ecu:
            samples = list(ecu.watch("TWAT", "FREQ", count=10))
            assert not samples[-1].gap
            assert samples[-1].readings["TWAT"].raw == it.car.data[0x1A]
            assert ecu.tester.line.pause == pause


def test_readings_of_several_threads_keep_the_pause_together(it):
    """The pause is the line's, not a caller's."""
    from concurrent.futures import ThreadPoolExecutor

    ecu = ecu_on(it)
    ecu.read()
    it.forget()
    with ThreadPoolExecutor(3) as pool:
        done = [pool.submit(ecu.faults) for _ in range(12)]
        assert all(len(each.result()) == 4 for each in done)
    assert too_soon(it) == 0
