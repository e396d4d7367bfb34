"""What recordings can be replayed: several in a file, damaged ones, none; the port's options."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from replay_harness import NAMES, RECEIVED, SENT, again, do, session, sim

from mikas.errors import BadPortUrl, CaptureError, UsageError
from mikas.framing import encode
from mikas.link import open_link
from mikas.link.base import CaptureTee
from mikas.link.virtual import RealTimeVirtualLink
from mikas.recording import CaptureWriter
from mikas.replay import load, playing, replay_bus

# Several recordings, damage, what is no recording


def test_sessions_in_one_file_follow_each_other_with_a_silence_between(tmp_path):
    path = tmp_path / "a.pcapng"
    lasted = []
    for model in ("5.4", "7.1"):
        with session(sim(model=model), tmp_path, path) as ecu:
            ecu.passport()
            ecu.read("TWAT")
        lasted.append(ecu.tester.link.now())
    recorded = load(path)
    [(off, on)] = recorded.silences
    assert on - off > 2
    assert recorded.version.values == [9, 0x0A]
    with session(again(path, seek=round(on, 1) + 0.1), tmp_path) as ecu:
        assert ecu.version_code == 0x0A
    with session(again(path), tmp_path) as ecu:
        assert ecu.version_code == 9
        ecu.tester.wait(ecu.tester.link.now() + on - off + 1)
        assert ecu.raw(b"\x01") == b"\x0a"


def test_times_that_run_back_go_on(tmp_path):
    path = tmp_path / "a.pcapng"
    with CaptureWriter(path, url="a") as writer:
        for time, value in ((100.0, 1), (101.0, 2), (50.0, 3), (51.0, 4)):
            writer.record(SENT, encode(b"\x61\x1a"), time)
            writer.record(RECEIVED, encode(b"\x61\x1a") + encode(bytes([value])), time + 0.02)
    car = playing(open_link(again(path)))
    assert car.duration == pytest.approx(2.52 + 0.02, abs=0.03)
    reported = []
    for tenth in range(25):
        car.seek(tenth / 10, 0.0)
        reported.append(car.raw(0x1A, 0.0)[0])
    assert sorted(set(reported)) == [1, 2, 3, 4]
    assert reported == sorted(reported)


@given(st.data())
@settings(max_examples=25)
def test_a_cut_or_damaged_recording_replays_what_is_left(data):
    whole = recorded_bytes()
    at = data.draw(st.integers(200, len(whole)))
    damage = data.draw(st.binary(max_size=60))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.pcapng"
        tail = whole[at + len(damage) :] if data.draw(st.booleans()) else b""
        path.write_bytes(whole[:at] + damage + tail)
        try:
            recorded = load(path)
        except CaptureError as error:
            assert "nothing to replay" in str(error)
            return
        assert recorded.frames
        for code, places in recorded.places.items():
            assert all(len(series.datum(0, at, size)) == size for series, at, size in places)
            assert recorded.size_of(code)
        link = open_link(again(path, unknown="01"))
        link.write(encode(b"\x01"))
        assert link.read(link.now() + 5).data


@pytest.fixture(scope="module", autouse=True)
def _one_recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    with session(sim(scenario="city"), folder, folder / "a.pcapng") as ecu:
        do(ecu, [("list", NAMES, 5, 0), ("stream", ["FREQ"], 5, 0)])
        ecu.passport()
    recorded_bytes.whole = (folder / "a.pcapng").read_bytes()


def recorded_bytes():
    return recorded_bytes.whole


def test_what_is_no_recording_is_refused_with_a_reason(tmp_path):
    cases = {
        "empty.pcapng": (b"", "empty"),
        "table.csv": (b"Time,TWAT\n0,85\n", "not a recording"),
        "old.pcap": (bytes.fromhex("d4c3b2a1") + bytes(40), "old pcap"),
        "head.pcapng": (recorded_bytes()[:200], "nothing to replay"),
    }
    for name, (data, reason) in cases.items():
        (tmp_path / name).write_bytes(data)
        with pytest.raises(CaptureError, match=reason):
            open_link(again(tmp_path / name))
    with pytest.raises(CaptureError, match="no such file"):
        open_link(again(tmp_path / "missing.pcapng"))


def test_without_parameters_the_rest_is_replayed(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(faults="13"), tmp_path, path) as ecu:
        ecu.faults()
    with session(again(path), tmp_path) as ecu:
        assert [fault.code for fault in ecu.faults()] == [13]
        assert ecu.raw(b"\x61\x1a") is None


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ("speed=fast", "not a valid value for speed"),
        ("speed=-1", "not a valid value for speed"),
        ("speed=nan", "not a valid value for speed"),
        ("seek=1e12", "not a valid value for seek"),
        ("seek=99999", "behind the end"),
        ("loop=maybe", "not a valid value for loop"),
        ("clock=sundial", "not a valid value for clock; allowed: real, simulated"),
        ("scenario=city", "no option “scenario”"),
        ("sped=2", "Did you mean speed"),
        ("unknown=maybe", "not a valid value for unknown"),
    ],
)
def test_a_wrong_option_is_refused(tmp_path, options, reason):
    path = tmp_path / "a.pcapng"
    path.write_bytes(recorded_bytes())
    with pytest.raises(BadPortUrl, match=reason):
        open_link(f"replay:{path}?{options}")


def test_a_replay_port_needs_a_file_and_keeps_its_options(tmp_path):
    path = tmp_path / "поездка 1.pcapng"
    path.write_bytes(recorded_bytes())
    with pytest.raises(BadPortUrl, match="names no file"):
        open_link("replay:?speed=2")
    with open_link(f"replay://{path}", speed=2, loop=True, echo="0", latency_ms=16) as link:
        assert isinstance(link, RealTimeVirtualLink)
        car = playing(CaptureTee(link, None))
        assert (car.speed, car.loop) == (2, True)
        assert link.bus.adapter.kind.echo is False
        assert link.bus.adapter.kind.latency == 0.016
    with open_link("sim:?clock=simulated") as link:
        assert playing(link) is None
    with pytest.raises(UsageError, match="scenario"):
        replay_bus(path, {"scenario": "city"})
