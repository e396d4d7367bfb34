"""A recorded session played back: a tester that does the same gets the same."""

from __future__ import annotations

import tempfile
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.client import connect
from mikas.errors import BadPortUrl, CaptureError, EchoOnly, MikasError, UsageError
from mikas.framing import encode
from mikas.link import open_link
from mikas.link.tee import CaptureTee, Direction
from mikas.link.virtual import RealTimeVirtualLink, VirtualLink
from mikas.recording import CaptureWriter, Coalescer, write_session_header
from mikas.recording.replay import load, playing, replay_bus
from mikas.virtual.assumptions import LongList, Unknown

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED
METHODS = ["single", "batch", "list", "stream"]
NAMES = ["TWAT", "FREQ", "UACC", "INJ", "JAIR", "RXX", "RDET", "THR", "UOZ", "TAIR", "FREQX"]


@contextmanager
def session(url, folder, path=None, *, joined=True, **options):
    """A connected ECU, recorded to `path`."""
    folder = Path(folder)
    common = {"state": folder, "journal": folder / "journal", **options}
    if path is None:
        with connect(url, **common) as ecu:
            yield ecu
        return
    with (
        CaptureWriter(path, url=url, append=True) as writer,
        Coalescer(writer) as sink,
        connect(url, sink=sink if joined else writer, **common) as ecu,
    ):
        yield ecu


def sim(**settings):
    return "sim:?clock=simulated&" + "&".join(f"{k}={v}" for k, v in settings.items())


def again(path, **settings):
    return f"replay:{path}?clock=simulated&" + "&".join(f"{k}={v}" for k, v in settings.items())


def do(ecu, steps):
    """Each step reads for a while and waits; what came, with the times from the begin."""
    got = []
    began = None
    for method, names, count, pause in steps:
        for sample in ecu.watch(*names, method=method, count=count):
            began = sample.time if began is None else began
            raw = {name: reading.raw for name, reading in sample.readings.items()}
            got.append((sample.time - began, raw))
        ecu.tester.wait(ecu.tester.link.now() + pause)
    return got


def linger(ecu):
    """Goes on for a minute, so that the recording does."""
    ecu.tester.wait(ecu.tester.link.now() + 60)
    ecu.raw(b"\x01")


def a_step(*methods):
    return st.tuples(
        st.sampled_from(methods),
        st.lists(st.sampled_from(NAMES), min_size=1, max_size=6, unique=True),
        st.integers(1, 6),
        st.floats(0, 20),
    )


# When the stroke after the last recorded one would have been, no recording tells, and it moves what
# comes then by milliseconds: so a stream by strokes is the last thing that is compared.
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
        # A recording does not know its baud rate from the URL: whoever opens the port tells it.
        with (
            CaptureWriter(path, url=url, baud=baud) as writer,
            Coalescer(writer, baud=baud) as sink,
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
def test_at_any_time_it_tells_what_was_recorded_last(moments):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.pcapng"
        with session(sim(scenario="city"), folder, path) as ecu:
            link = ecu.tester.link
            told = []
            for number in range(20):
                reading = ecu.read("TWAT" if number % 3 else "THR", "FREQ")["FREQ"]
                told.append((reading.time, reading.raw))
                ecu.tester.wait(link.now() + 0.7)
        recorded = load(path)
        car = playing(open_link(again(path)))
        code = next(code for code in car.codes if code == 0x29)
        for moment in moments:
            at = moment + 0.06  # the recording's second 0 is its first packet
            expected = [raw for time, raw in told if time + 0.001 <= at] or [told[0][1]]
            nearby = [raw for time, raw in told if abs(time - at) < 0.05]
            car.seek(moment, 0.0)
            assert car.raw(code, 0.0) in [expected[-1], *nearby]
        assert recorded.duration > 14


# Who it was, and what it could do


def test_faults_and_identity_as_they_were_read_and_an_erase(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(faults="13,53", model="5.4"), tmp_path, path) as ecu:
        info = ecu.info()
        assert [fault.code for fault in ecu.faults()] == [13, 53]
        ecu.tester.wait(10.0)
        ecu.erase_faults()
        linger(ecu)
    with session(again(path), tmp_path) as ecu:
        assert ecu.info() == info
        assert ecu.model == info.model
        assert [fault.code for fault in ecu.faults()] == [13, 53]
        ecu.tester.wait(ecu.tester.link.now() + 15)
        assert ecu.faults() == ()
        playing(ecu.tester.link).seek(1.0, ecu.tester.link.now())
        assert [fault.code for fault in ecu.faults()] == [13, 53]
        assert ecu.erase_faults().after == ()


def test_what_was_never_asked_is_not_made_up(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(), tmp_path, path) as ecu:
        ecu.read("FREQ")
    recorded = load(path)
    assert set(recorded.places) == {0x29}
    with session(again(path, loop=1), tmp_path) as ecu:
        assert set(ecu.read()) == {"FREQ"}
        assert ecu.passport().pieces == ("",) * 8
        assert ecu.passport().program == (None,) * 3
        assert ecu.raw(b"\x02") is None
        assert ecu.raw(b"\x60") is None
        assert ecu.raw(b"\x11\x40") is None
        assert ecu.raw(b"\x62\x29\x10") == b"\x01"  # a write is refused
        assert ecu.raw(b"\x99") is None


def test_the_unit_is_known_from_a_note_if_it_was_asked_before_the_recording_began(tmp_path):
    path = tmp_path / "a.pcapng"
    with CaptureWriter(path, url="a") as writer:
        write_session_header(
            writer, 0.0, version_code=9, passports=("МИКАС", None, *"CDEFGH"), catalog_version="1"
        )
        writer.record(SENT, encode(b"\x61\x1a"), 1.0)
        writer.record(RECEIVED, encode(b"\x61\x1a") + encode(b"\x7d"), 1.01)
    with session(again(path, loop=1), tmp_path) as ecu:
        assert ecu.version_code == 9
        assert ecu.passport().program == ("МИКАС", None, "C")
        assert ecu.read("TWAT")["TWAT"].raw == b"\x7d"


@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_it_lacks_what_the_recorded_unit_lacked(tmp_path, unknown):
    path = tmp_path / "a.pcapng"
    url = sim(missing="stream,passports", unknown=unknown)
    with session(url, tmp_path, path) as ecu:
        for names in (["TWAT", "FREQ"], ["TWAT"], ["FREQ"]):
            with suppress(MikasError):
                next(ecu.watch(*names, method="stream"))
        ecu.read("TWAT", "FREQ")
        pieces = ecu.passport()
        ecu.raw(b"\x61\x99\x98")
    answer = None if unknown == "silent" else b"\x01"
    recorded = load(path)
    assert recorded.assumptions.missing == {0x51, 0x54, 0x71}
    assert recorded.assumptions.unknown is Unknown(unknown)
    assert {recorded.refusals[code] for code in (0x51, 0x54, 0x71)} == {answer}
    with session(again(path), tmp_path) as ecu:
        assert ecu.passport() == pieces
        assert ecu.raw(b"\x71\x1a\x29") == answer
        assert ecu.read("TWAT", "FREQ")
        assert ecu.raw(b"\x61\x99\x98") == answer


@pytest.mark.parametrize("how", ["silent", "short"])
def test_it_takes_lists_and_blocks_as_long_as_the_recorded_unit_did(tmp_path, how):
    path = tmp_path / "a.pcapng"
    long = bytes([0x61, *([0x1A, 0x29] * 6)])
    with session(sim(max_list=8, max_block=16, long_list=how), tmp_path, path) as ecu:
        ecu.read(*NAMES)
        for _ in range(2):
            ecu.raw(long)
            ecu.raw(b"\x21\x40\x20")
        ecu.raw(long[:9])
        ecu.raw(b"\x21\x40\x10")
    assumptions = load(path).assumptions
    assert (assumptions.max_list, assumptions.max_block) == (8, 16)
    assert assumptions.long_list is LongList(how)


def test_one_lost_answer_proves_nothing(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(lost=0.1, seed=3), tmp_path, path, retries=9) as ecu:
        for _ in range(40):
            with suppress(MikasError):
                ecu.read("TWAT", "FREQ")
    recorded = load(path)
    assert recorded.assumptions.missing == frozenset()
    assert recorded.assumptions.max_list == 255
    assert recorded.silences == []


def test_commands_that_nobody_knows_are_answered_as_recorded(tmp_path):
    path = tmp_path / "a.pcapng"
    with CaptureWriter(path, url="a") as writer:
        time = 0.0
        for request, answer in [
            (b"\x01", b"\x0a"),
            (b"\x99\x01", b"\xaa\xbb"),
            (b"\x61\x99", b"\x05\x06"),
        ]:
            time += 0.1
            writer.record(SENT, encode(request), time)
            writer.record(RECEIVED, encode(request) + encode(answer), time + 0.02)
    with session(again(path, loop=1), tmp_path) as ecu:
        assert ecu.raw(b"\x99\x01") == b"\xaa\xbb"
        assert ecu.raw(b"\x99\x02") is None
        assert ecu.read("0x99:2")["0x99:2"].raw == b"\x05\x06"


# Memory and writes


def test_memory_as_it_was_read_and_written(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(), tmp_path, path, confirm=lambda _: True) as ecu:
        ram, xram = ecu.memory["ram"], ecu.memory["xram"]
        block = xram.read_block(0x1234, 40)
        before = ram.read(0x40)
        ecu.tester.wait(20.0)
        ram.write(0x40, before ^ 0xFF)
        ecu.memory["xram"].write_block(0x1236, b"\x01\x02\x03")
        linger(ecu)
    with session(again(path), tmp_path, confirm=lambda _: True) as ecu:
        ram, xram = ecu.memory["ram"], ecu.memory["xram"]
        assert xram.read_block(0x1234, 40) == block
        assert ram.read(0x40) == before
        ram.write(0x41, 0x77)
        ecu.tester.wait(ecu.tester.link.now() + 25)
        assert ram.read(0x40) == before ^ 0xFF
        assert ram.read(0x41) == 0x77
        assert xram.read_block(0x1234, 6) == block[:2] + b"\x01\x02\x03" + block[5:6]
        playing(ecu.tester.link).seek(1.0, ecu.tester.link.now())
        assert ram.read(0x40) == before
        assert ecu.raw(b"\x15\x00\x10") is None  # CODE was never read


def test_a_write_is_taken_where_the_recorded_unit_took_one(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(), tmp_path, path) as ecu:
        ecu.read("TWAT", "THR")
        ecu.write_parameter("THR", 50)
        linger(ecu)
    with session(again(path), tmp_path) as ecu:
        ecu.write_parameter("THR", 70)
        assert ecu.read("THR")["THR"].value == 70
        assert ecu.raw(b"\x62\x1a\x10") == b"\x01"


# Silence


def test_where_the_recorded_unit_had_no_supply_it_is_silent_and_then_has_forgotten_its_list(
    tmp_path,
):
    path = tmp_path / "a.pcapng"
    with session(sim(scenario="key-off"), tmp_path, path, timeout=0.1) as ecu:
        while ecu.tester.link.now() < 50:
            with suppress(MikasError):
                ecu.read("UACC")
            ecu.tester.wait(ecu.tester.link.now() + 0.2)
        ecu.set_list("UACC")
    recorded = load(path)
    [(off, on)] = recorded.silences
    assert 19 < off < 20.5
    assert 34.5 < on < 36
    with session(again(path), tmp_path, timeout=0.1) as ecu:
        car = playing(ecu.tester.link)
        car.seek(off - 1, ecu.tester.link.now())
        assert ecu.read("UACC")
        ecu.set_list("UACC")
        ecu.tester.wait(ecu.tester.link.now() + 2)
        with pytest.raises(EchoOnly):
            ecu.read("UACC")
        ecu.tester.wait(ecu.tester.link.now() + on - off)
        assert ecu.read("UACC")
        assert ecu.raw(b"\x63") == b"\x01"


def test_a_pause_of_the_tester_is_no_silence_of_the_unit(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(), tmp_path, path) as ecu:
        ecu.read("TWAT")
        ecu.tester.wait(600.0)
        ecu.read("TWAT")
    assert load(path).silences == []


def test_behind_its_end_it_is_silent_or_begins_again(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(scenario="cold-start"), tmp_path, path) as ecu:
        do(ecu, [("batch", ["TWAT", "FREQ"], 40, 0)])
    duration = load(path).duration
    with session(again(path), tmp_path) as ecu:
        ecu.tester.wait(ecu.tester.link.now() + duration)
        with pytest.raises(EchoOnly):
            ecu.read("TWAT")
        assert playing(ecu.tester.link).position() == duration
    with session(again(path, loop=1), tmp_path) as ecu:
        first = ecu.read("TWAT", "FREQ")
        ecu.tester.wait(ecu.tester.link.now() + 7 * duration)
        assert playing(ecu.tester.link).position(ecu.tester.link.now()) < duration
        assert set(ecu.read("TWAT", "FREQ")) == set(first)


# Speed and place


@pytest.mark.parametrize("speed", [0.5, 2, 10])
def test_the_car_runs_at_another_speed_and_the_wire_does_not(tmp_path, speed):
    path = tmp_path / "a.pcapng"
    with session(sim(scenario="city"), tmp_path, path) as ecu:
        do(ecu, [("batch", ["FREQ", "THR"], 200, 0)])
    plain, other = (
        VirtualLink(replay_bus(path, {"speed": str(it)}, start=0.0)) for it in (1, speed)
    )
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


def test_seek_and_hold_while_it_runs(tmp_path):
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
        ecu.tester.wait(link.now() + 2)
        with pytest.raises(EchoOnly):
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
    told = []
    for tenth in range(25):
        car.seek(tenth / 10, 0.0)
        told.append(car.raw(0x1A, 0.0)[0])
    assert sorted(set(told)) == [1, 2, 3, 4]
    assert told == sorted(told)


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
        "table.csv": (b"Time,TWAT\n0,85\n", "not a capture"),
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
        ("speed=fast", "no value for speed"),
        ("speed=-1", "no value for speed"),
        ("speed=nan", "no value for speed"),
        ("seek=1e12", "no value for seek"),
        ("seek=99999", "behind the end"),
        ("loop=maybe", "no value for loop"),
        ("clock=sundial", "clock is real or simulated"),
        ("scenario=city", "no setting “scenario”"),
        ("sped=2", "there is speed"),
        ("unknown=maybe", "no value for unknown"),
    ],
)
def test_a_wrong_option_is_refused(tmp_path, options, reason):
    path = tmp_path / "a.pcapng"
    path.write_bytes(recorded_bytes())
    with pytest.raises(BadPortUrl, match=reason):
        open_link(f"replay:{path}?{options}")


def test_the_port_and_its_options(tmp_path):
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
