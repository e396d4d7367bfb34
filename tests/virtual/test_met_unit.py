"""A virtual unit made of a profile behaves as the profile says: every key, asked over the wire."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.commands import ReadFaults, ReadProgramPassport
from mikas.framing import checksum, encode
from mikas.virtual.build import met_bus
from mikas.virtual.memory import pattern
from mikas.virtual.quirks import BadWrite, ChecksumForm, LongList, StreamEnd
from mikas.virtual.unit_profile import CodeProfile, Moves, UnitProfile

from .met_tester import BYTE, MetTester, with_commands
from .profile_strategies import profiles

SIZES = dict(shipped().codes)
A_CODE = CodeProfile(1, (b"\x7d",))
few = settings(max_examples=20)
# A read of each family, whose answer is no refusal: the commands of `supported` and `missing`.
REQUESTS = {
    0x02: b"\x02", 0x11: b"\x11\x00", 0x13: b"\x13\x00\x00", 0x15: b"\x15\x00\x00",
    0x21: b"\x21\x00\x01", 0x23: b"\x23\x00\x00\x01", 0x25: b"\x25\x00\x00\x01",
    0x31: b"\x31\x81", **{code: bytes([code]) for code in (*range(0x51, 0x59), 0x60)},
}  # fmt: skip
CHECKED: set[str] = set()


def of(*keys: str):
    """Marks a test as that of these keys."""
    CHECKED.update(keys)
    return lambda test: test


def plain(profile: UnitProfile, *commands: int, **changes: object) -> UnitProfile:
    """`profile` with these commands and changes, whose 1A is known."""
    changes.setdefault("codes", {0x1A: A_CODE, **(profile.codes or {}), 0x33: A_CODE})
    return replace(with_commands(profile, *commands), **changes)


@pytest.fixture(scope="module")
def standing(tmp_path_factory) -> str:
    """A scenario with the key on and the engine off."""
    path = tmp_path_factory.mktemp("car") / "standing.toml"
    path.write_text("duration = 60\n[timeline]\nkey = [[0, 1]]\n", "utf-8")
    return str(path)


@of("version_code")
@few
@given(profiles())
def test_it_says_its_version(profile):
    expected = 0x0A if profile.version_code is None else profile.version_code
    assert MetTester(profile).ask(b"\x01") == bytes([expected])


@of("echo")
@few
@given(profiles())
def test_its_adapter_echoes_or_does_not(profile):
    tester = MetTester(profile)
    tester.ask(b"\x01")
    assert tester.echo == (b"" if profile.echo is False else b"\x01\xff\x0d")


@of("turn_round", "turn_round_spread", "inter_byte")
@few
@given(profiles())
def test_its_response_comes_at_its_time_and_pace(profile):
    tester = MetTester(profile)
    turn_round = 0.002 if profile.turn_round is None else profile.turn_round
    spread, pause = profile.turn_round_spread or 0.0, profile.inter_byte or 0.0
    delays = []
    for _ in range(4):
        begin = tester.now + 0.25 + 3 * BYTE
        tester.ask(b"\x01")
        delays.append(tester.times[0] - BYTE - begin)
        for before, after in pairwise(tester.times):
            assert after - before == pytest.approx(BYTE + pause, abs=1e-6)
    assert max(delays) <= turn_round + spread + 1e-6
    assert min(delays) >= max(0.0, turn_round - spread) - 1e-6
    assert max(delays) - min(delays) >= min(spread, turn_round) * 0.9 - 1e-6


@of("least_pause")
@few
@given(profiles(), st.floats(0.01, 0.2))
def test_it_ignores_a_request_that_comes_sooner_than_its_pause(profile, pause):
    profile = replace(profile, least_pause=round(pause, 4))
    tester = MetTester(profile)
    for share, answered in ((0.5, False), (0.97, False), (1.03, True)):
        assert tester.ask(b"\x01")
        tester.now = tester.times[-1] + profile.least_pause * share - 0.25  # `say` adds that
        assert (tester.ask(b"\x01") is not None) is answered


@of("supported", "missing", "unknown")
@few
@given(profiles())
def test_it_has_the_commands_that_were_answered_and_lacks_the_missing_ones(profile):
    tester = MetTester(replace(profile, parameter_count=3))
    assert tester.ask(b"\x99") == tester.refusal
    for code, request in REQUESTS.items():
        if code in profile.missing:
            assert tester.ask(request) == tester.refusal
        elif code in profile.supported:
            assert len(tester.ask(request)) >= 1
            assert len(tester.echo) in (0, len(tester.wire(request)))
    for code in profile.missing - REQUESTS.keys():
        assert tester.ask(bytes([code, 0x1A])) == tester.refusal


@of("bad_write")
@few
@given(profiles())
def test_it_refuses_a_write_in_its_way(profile):
    tester = MetTester(plain(profile, 0x62, 0x64))
    expected = None if profile.bad_write is BadWrite.SILENT else b"\x01"
    assert tester.ask(b"\x64") == expected
    assert tester.ask(b"\x62\x1a\x00\x00\x00") == expected


@of("counted_blocks", "max_block")
@few
@given(profiles())
def test_its_blocks_have_its_form_and_length(profile):
    tester = MetTester(with_commands(profile, 0x21, 0x23, 0x25))
    most = profile.max_block or 255
    count = bytes([1]) if profile.counted_blocks else b""
    assert tester.ask(b"\x23\x05\x00\x01") == b"\x05\x00" + count + pattern("xram")[5:6]
    assert tester.ask(b"\x25\x05\x00\x01") == b"\x05\x00" + count + pattern("code")[5:6]
    assert tester.ask(bytes([0x21, 0, most])) == bytes([0, most]) + pattern("ram")[:most]
    if most < 255:
        assert tester.ask(bytes([0x21, 0, most + 1])) == tester.refusal


@of("max_list_61", "max_list_64", "max_list_71", "long_list")
@few
@given(profiles())
def test_its_lists_have_their_length_each(profile):
    tester = MetTester(plain(profile, 0x61, 0x64, 0x71, stream_end=StreamEnd.BREAK, inter_byte=0.0))
    datum = tester.ask(b"\x61\x33")
    assert datum == b"\x7d"
    for command, most in ((0x61, profile.max_list_61 or 255), (0x71, profile.max_list_71 or 255)):
        for count in {most, min(255, most + 1)}:
            request = bytes([command]) + b"\x33" * count
            bodies = tester.bodies(request, 3.0)
            tester.bus.send_break(0.05, tester.now)
            tester.now += 0.5
            if count <= most or profile.long_list is LongList.SHORT:
                assert bodies[0] == datum * min(count, most)
            else:
                assert bodies == ([] if tester.refusal is None else [tester.refusal])
    most = profile.max_list_64 or 255
    assert tester.ask(b"\x64" + b"\x33" * most) == b"\x00"
    if most < 255:
        refused = None if profile.bad_write is BadWrite.SILENT else b"\x01"
        assert tester.ask(b"\x64" + b"\x33" * (most + 1)) == refused


@of("accepts")
@few
@given(profiles())
def test_it_understands_its_form_of_a_checksum(profile):
    tester = MetTester(with_commands(profile, 0x11))
    for form, raw in ((ChecksumForm.STUFFED, False), (ChecksumForm.RAW, True)):
        answered = profile.accepts in (None, ChecksumForm.BOTH, form)
        assert bool(tester.came(encode(b"\x11\xe2", raw_checksum=raw))) is answered


@of("sends")
@few
@given(profiles())
def test_it_sends_its_form_of_a_checksum(profile):
    tester = MetTester(with_commands(profile, 0x13))
    raw = profile.sends is ChecksumForm.RAW
    cells, found = pattern("xram"), set()
    for address in range(0x10000):
        body = bytes([address & 0xFF, address >> 8, cells[address]])
        if (check := checksum(body)) in {0x0D, 0x40} - found:
            found.add(check)
            request = tester.wire(b"\x13" + body[:2])
            assert tester.came(request) == encode(body, raw_checksum=raw)
        if len(found) == 2:
            break


@of("stream_end")
@few
@given(profiles())
def test_its_stream_ends_as_its_streams_do(profile):
    tester = MetTester(plain(profile, 0x71, stream_gap=0.02, inter_byte=0.0, least_pause=0.0))
    ends = profile.stream_end or StreamEnd.BYTE
    assert len(tester.bodies(b"\x71\x33", 3.0)) > 10
    tester.came(b"\xff", 0.3)
    assert bool(tester.came(b"", 1.0)) is (ends is not StreamEnd.BYTE)
    for _ in range(30):  # in a gap, or on a response: then it is lost
        tester.now += 0.003
        tester.came(tester.wire(b"\x01"), 0.4)
    assert bool(tester.came(b"", 1.0)) is (ends is StreamEnd.BREAK)
    tester.bus.send_break(0.05, tester.now)
    assert len(tester.came(b"", 1.0)) < 3  # the break's own byte


@of("stream_gap", "stream_load")
@few
@given(profile=profiles(), stands=st.booleans(), load=st.sampled_from([None, 2.0, 5.0]))
def test_its_stream_has_its_period_at_every_speed(profile, stands, load, standing):
    profile = replace(profile, stream_load=load)
    tester = MetTester(plain(profile, 0x71), scenario=standing if stands else "warm-idle")
    pause = profile.inter_byte or 0.0
    tester.came(tester.wire(b"\x71\x33"), 2.5)
    period = [after - before for before, after in pairwise(tester.times[::3])]
    rpm = tester.bus.ecu.responder.car.engine_speed(tester.now)
    assert (rpm == 0) is stands
    gap = 0.0004 if profile.stream_gap is None else profile.stream_gap
    more = (0.1 if load is None else load) * rpm / 1e6
    expected = 3 * BYTE + 2 * pause + gap + more
    assert sorted(period)[len(period) // 2] == pytest.approx(expected, abs=5e-4)


@of("strokes")
@pytest.mark.parametrize("rate", [None, 0.0, 0.125, 0.25, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("code", [0x7F, 0x80, 0x83])
def test_it_responds_as_often_a_turn_as_it_did(rate, code):
    profile = UnitProfile(strokes={} if rate is None else {code: rate})
    tester = MetTester(profile)
    count = len(tester.bodies(bytes([code, 0x1A]), 20.0))
    turns = tester.bus.ecu.responder.car.engine_speed(tester.now) / 60 * 20
    assert count == pytest.approx(turns * (0.5 if rate is None else rate), rel=0.06, abs=2)


@pytest.mark.parametrize("rate", [5e-324, 1e-300, 1e-9])
def test_a_rate_that_no_engine_reaches_is_none_and_takes_no_time(rate):
    tester = MetTester(UnitProfile(strokes={0x7F: rate}))
    assert tester.bodies(b"\x7f\x1a", 20.0) == []


@of("codes")
@few
@given(profiles())
def test_it_knows_its_codes_with_their_sizes_and_samples(profile):
    tester = MetTester(with_commands(profile, 0x61))
    for code in range(256):
        sent = tester.ask(bytes([0x61, code]))
        expected = (profile.codes or {}).get(code)
        if profile.codes is None:
            known_here = code in tester.bus.ecu.responder.car.codes
            assert (sent == tester.refusal) is not known_here or len(sent) == SIZES[code]
        elif expected is None:
            assert sent == tester.refusal
        else:
            assert len(sent) == expected.size
            if SIZES.get(code) != expected.size:
                assert sent in (expected.samples or (bytes(expected.size),))


@of("parameter_count", "passports", "faults")
@few
@given(profiles())
def test_it_says_its_count_passports_and_faults(profile):
    codes = [0x02, 0x60, *range(0x51, 0x59)]
    tester = MetTester(with_commands(profile, *codes))
    if profile.parameter_count is not None:
        assert tester.ask(b"\x60") == bytes([profile.parameter_count])
    read = profile.passports or (None,) * 8
    for code, text in zip(range(0x51, 0x59), read, strict=True):
        sent = tester.ask(bytes([code]))
        assert len(sent) == 16
        if text is not None:
            assert sent == ReadProgramPassport(1).respond(text)
    assert tester.ask(b"\x02") == ReadFaults().respond(tuple(profile.faults or ()))


def test_every_key_of_a_profile_has_its_test():
    assert {each.name for each in fields(UnitProfile)} == CHECKED


MOVES = {
    Moves.CONSTANT: {"standing": {b"\x01"}, "idle": {b"\x01"}},
    Moves.KEY: {"standing": {b"\x01"}, "idle": {b"\x03"}},
    Moves.RPM: {"standing": {b"\x01"}, "idle": {b"\x02"}},
    Moves.OTHER: {"standing": {b"\x01", b"\x02", b"\x03"}, "idle": {b"\x01", b"\x02", b"\x03"}},
}


@pytest.mark.parametrize("moves", Moves)
@pytest.mark.parametrize("regime", ["standing", "idle"])
def test_a_sample_is_given_by_what_the_datum_follows(moves, regime, standing):
    profile = UnitProfile(codes={0x33: CodeProfile(1, (b"\x01", b"\x02", b"\x03"), moves)})
    tester = MetTester(profile, scenario=standing if regime == "standing" else "warm-idle")
    assert {tester.ask(b"\x61\x33") for _ in range(12)} == MOVES[moves][regime]


def test_a_sample_can_be_written_until_the_key_is_turned():
    profile = UnitProfile(codes={0x33: A_CODE, 0x1A: A_CODE})
    tester = MetTester(profile)
    for code in (0x33, 0x1A):
        assert tester.ask(bytes([0x62, code, 0x11])) == b"\x00"
        assert tester.ask(bytes([0x61, code])) == b"\x11"
    tester.bus.ecu.responder.power_cycle()
    assert tester.ask(b"\x61\x33") == b"\x7d"
    assert tester.ask(b"\x61\x1a") != b"\x11"


def test_a_stored_fault_of_the_unit_does_not_stop_the_engine():
    """53 is the crankshaft's sensor: present, it lets no engine run."""
    profile = UnitProfile(faults=(53, 13, 13))
    for given_faults, runs in (({}, True), ({"faults": "53"}, False)):
        tester = MetTester(profile, **given_faults)
        assert bool(tester.ask(b"\x61\x29")[0]) is runs
        assert tester.ask(b"\x61\x72") == bytes([13])  # MINERR
        assert tester.ask(b"\x02") == b"\x03\x35\xe0\x0d\xe0\x0d\xe0"
        assert tester.ask(b"\x62\x0e\x08") == tester.ask(b"\x62\x0e\x00") == b"\x00"
        assert tester.ask(b"\x02") == b"\x00"
        assert tester.ask(b"\x61\x72") == b"\x00"


def test_a_profile_without_answers_is_the_usual_unit():
    usual, met = met_bus(UnitProfile()), met_bus(UnitProfile(), {})
    assert usual.ecu.responder.quirks == met.ecu.responder.quirks
    assert met.ecu.responder.identity.passports[0] == "МИКАС 7.1"
    assert len(met.ecu.responder.car.codes) == len(SIZES)
