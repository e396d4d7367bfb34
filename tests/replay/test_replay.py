"""A recorded session played back: a tester that does the same gets the same."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from replay_harness import METHODS, NAMES, again, begun, do, session, sim

from capture_writing_harness import coalescing
from mikas.errors import RecordingOver
from mikas.framing import encode
from mikas.link import open_link
from mikas.link.virtual import VirtualLink
from mikas.recording import CaptureWriter
from mikas.replay import load, playing, replay_bus


def a_step(*methods):
    return st.tuples(
        st.sampled_from(methods),
        st.lists(st.sampled_from(NAMES), min_size=1, max_size=6, unique=True),
        st.integers(1, 6),
        st.floats(0, 20),
    )


# A recording does not contain the time of the stroke after the last recorded one, which shifts all
# that follows by milliseconds: so a stream by strokes is compared last.
steps = st.builds(
    lambda most, last: [*most, *last],
    st.lists(a_step(*METHODS), min_size=1, max_size=5),
    st.lists(a_step("stroke0", "stroke3"), max_size=1),
)


@settings(max_examples=15)
@given(
    steps,
    st.sampled_from(["city", "warm-idle"]),
    st.integers(0, 9),
    st.sampled_from([{}, {"echo": 0}, {"turn_round": 0.011, "raw_checksum": 1}, {"baud": 10400}]),
    st.booleans(),
)
def test_the_same_questions_at_the_same_times_get_the_recorded_answers(
    wanted, scenario, seed, how, joined
):
    baud = how.get("baud", 9600)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.pcapng"
        url = sim(scenario=scenario, seed=seed, **how)
        # A recording does not know its baud rate from the URL: the opener of the port gives it.
        with (
            CaptureWriter(path, url=url, baud=baud) as writer,
            coalescing(writer, baud=baud) as sink,
            session(url, folder, sink=sink if joined else writer) as ecu,
        ):
            recorded = do(ecu, wanted), ecu.version_code, ecu.faults(), ecu.info()
        with session(again(path), folder) as ecu:
            replayed = do(ecu, wanted), ecu.version_code, ecu.faults(), ecu.info()
        assert [raw for _, raw in replayed[0]] == [raw for _, raw in recorded[0]]
        # Microseconds are lost in the file, and add up.
        assert [time for time, _ in replayed[0]] == pytest.approx(
            [time for time, _ in recorded[0]], abs=0.002
        )
        assert replayed[1:] == recorded[1:]


@given(st.lists(st.floats(0, 15), min_size=1, max_size=8))
@settings(max_examples=15)
def test_at_any_time_it_gives_the_value_recorded_last(moments):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.pcapng"
        with session(sim(scenario="city"), folder, path) as ecu:
            link = ecu.tester.link
            reported = []
            for number in range(20):
                reading = ecu.read("TWAT" if number % 3 else "THR", "FREQ")["FREQ"]
                reported.append((reading.time, reading.raw))
                ecu.tester.wait(link.now() + 0.7)
        recorded = load(path)
        car = playing(open_link(again(path)))
        code = next(code for code in car.codes if code == 0x29)
        for moment in moments:
            at = moment + 0.06  # the recording's second 0 is its first packet
            expected = [raw for time, raw in reported if time + 0.001 <= at] or [reported[0][1]]
            nearby = [raw for time, raw in reported if abs(time - at) < 0.05]
            car.seek(moment, 0.0)
            assert car.raw(code, 0.0) in [expected[-1], *nearby]
        assert recorded.duration > 14


# Speed and place


@pytest.mark.parametrize("speed", [0.5, 2, 10])
def test_the_car_runs_at_another_speed_and_the_wire_does_not(tmp_path, speed):
    path = tmp_path / "a.pcapng"
    with session(sim(scenario="city"), tmp_path, path) as ecu:
        do(ecu, [("batch", ["FREQ", "THR"], 200, 0)])
    plain, other = (VirtualLink(begun(replay_bus(path, {"speed": str(it)}))) for it in (1, speed))
    request = encode(b"\x61\x29\x20")
    ends = []
    for link, now in ((plain, 2.0), (other, 2.0 / speed)):
        link.read(now)
        link.write(request)
        came, began = b"", link.now()
        while len(came) < len(request) + 4:
            chunk = link.read(began + 1)
            assert chunk.data
            came += chunk.data
        ends.append((came, round(chunk.time - began, 5)))
    assert ends[0] == ends[1]


def test_seek_and_hold_work_while_it_runs(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(scenario="cold-start"), tmp_path, path) as ecu:
        recorded = do(ecu, [("batch", ["TWAT", "FREQ"], 500, 0)])
    with session(again(path, seek=5), tmp_path) as ecu:
        link = ecu.tester.link
        car = playing(link)
        assert 5 <= car.position() < 7
        car.seek(0.0, link.now())
        car.set_speed(0, link.now())
        held = {ecu.read("FREQ")["FREQ"].raw for _ in range(9)}
        assert held == {recorded[0][1]["FREQ"]}
        car.seek(car.duration - 0.5)
        assert ecu.read("FREQ")["FREQ"].raw == recorded[-1][1]["FREQ"]
        car.set_speed(1, link.now())
        with pytest.raises(RecordingOver):
            ecu.tester.wait(link.now() + 2)
        with pytest.raises(RecordingOver):
            ecu.read("FREQ")
        for speed in (-1, float("inf"), float("nan")):
            with pytest.raises(ValueError, match="speed"):
                car.set_speed(speed)


def test_it_waits_for_its_tester(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(), tmp_path, path) as ecu:
        ecu.read("TWAT")
    link = VirtualLink(replay_bus(path))
    link.read(1e6)
    assert playing(link).position(link.now()) == 0
    link.write(encode(b"\x01"))
    assert link.read(link.now() + 1).data
    assert playing(link).position(link.now()) == pytest.approx(10 / 9600)
