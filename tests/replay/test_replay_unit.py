"""The replayed unit is who the recorded one was, can what it could, and is silent as it was."""

from __future__ import annotations

from contextlib import suppress

import pytest
from replay_harness import NAMES, RECEIVED, SENT, again, do, linger, session, sim

from mikas.errors import EchoOnly, MikasError, RecordingOver
from mikas.framing import encode
from mikas.recording import CaptureWriter
from mikas.replay import load, playing
from mikas.virtual.quirks import LongList, Unknown
from session_header_harness import write_session_header

# Who it was, and what it could do


def test_faults_and_identity_are_answered_as_recorded_also_after_an_erase(tmp_path):
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


def test_an_answer_that_was_never_recorded_is_not_made_up(tmp_path):
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
        for code in (0x51, 0x54, 0x60):  # refused: that can't be taken for an answer (D10)
            assert ecu.raw(bytes([code])) == b"\x01"
        assert ecu.info().parameter_count is None
        assert ecu.raw(b"\x11\x40") is None
        assert ecu.raw(b"\x62\x29\x10") == b"\x01"  # a write is refused
        assert ecu.raw(b"\x99") is None


def test_the_unit_is_known_from_a_note_without_a_recorded_request(tmp_path):
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
    assert recorded.quirks.missing == {0x51, 0x54, 0x71}
    assert recorded.quirks.unknown is Unknown(unknown)
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
    quirks = load(path).quirks
    assert (quirks.max_list, quirks.max_block) == (8, 16)
    assert quirks.long_list is LongList(how)


def test_one_lost_answer_proves_nothing(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(lost=0.1, seed=3), tmp_path, path, retries=9) as ecu:
        for _ in range(40):
            with suppress(MikasError):
                ecu.read("TWAT", "FREQ")
    recorded = load(path)
    assert recorded.quirks.missing == frozenset()
    assert recorded.quirks.max_list == 255
    assert recorded.silences == []


def test_unknown_commands_are_answered_as_recorded(tmp_path):
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


def test_memory_is_answered_as_it_was_read_and_written(tmp_path):
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


def test_behind_its_end_it_is_over_or_begins_again(tmp_path):
    path = tmp_path / "a.pcapng"
    with session(sim(scenario="cold-start"), tmp_path, path) as ecu:
        do(ecu, [("batch", ["TWAT", "FREQ"], 40, 0)])
    duration = load(path).duration
    with session(again(path), tmp_path) as ecu:
        with pytest.raises(RecordingOver):
            ecu.tester.wait(ecu.tester.link.now() + duration)
        with pytest.raises(RecordingOver):
            ecu.read("TWAT")
        assert playing(ecu.tester.link).position() == duration
    with session(again(path, loop=1), tmp_path) as ecu:
        first = ecu.read("TWAT", "FREQ")
        ecu.tester.wait(ecu.tester.link.now() + 7 * duration)
        assert playing(ecu.tester.link).position(ecu.tester.link.now()) < duration
        assert set(ecu.read("TWAT", "FREQ")) == set(first)
