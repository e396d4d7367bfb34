"""Each switch for what the source leaves open, seen from the wire (D3, D7, D10, D11, D12, D14,
D16, D17).
"""

from __future__ import annotations

from itertools import pairwise

import pytest

from mikas.commands import COMMANDS_BY_CODE
from mikas.errors import UsageError
from mikas.framing import encode
from mikas.virtual.quirks import (
    GROUPS,
    ChecksumForm,
    EcuQuirks,
    LongList,
    StreamEnd,
    Unknown,
)
from virtual_harness import DATA, make_bus

from .raw_tester import BYTE, TURN, RawTester

NO = encode(b"\x01")
YES = encode(b"\x00")


def a_tester(**options: str) -> RawTester:
    return RawTester(make_bus(quirks=EcuQuirks().with_options(options)))


def test_the_defaults_are_the_letter():
    assert EcuQuirks() == EcuQuirks().with_options({})
    assert EcuQuirks().turn_round == 0.002
    assert EcuQuirks().max_list == EcuQuirks().max_block == 255


# D10


@pytest.mark.parametrize(
    "body",
    [
        "99",
        "",  # a frame with nothing in it
        "61",  # nothing asked
        "61 99",  # no such parameter
        "61 1A 99",
        "11",  # no address
        "11 00 00",
        "21 F0 11",  # over the end of RAM
        "23 00 FF",  # no count
        "25 FF FF 02",  # over the end of CODE
        "21 00 00",  # nothing
        "01 01",
        "41 00",
        "71",
        "71 99",
        "7F 99",
    ],
)
def test_what_a_unit_does_not_know_gets_silence_or_01(body):
    body = bytes.fromhex(body)
    assert a_tester().ask(body) == b""
    assert a_tester(unknown="01").ask(body) == NO


# D17


@pytest.mark.parametrize(
    "body",
    [
        "22 FE 03 01 02 03",  # beyond the end of RAM
        "22 00 02 01",  # a byte is missing
        "22 00 02 01 02 03",  # a byte too many
        "24 FF FF 02 01 02",  # beyond the end of XRAM
        "26 00 80 00",  # no data
        "62 99 00",  # no such parameter
        "62 1A",  # no data
        "62 1A 00 00",  # two bytes for one
        "62 3F 00",  # one byte for two
        "62 0E 00",  # the second write of the erase without the first
        "62 0E 01",
        "64",  # an empty list
        "64 1A 99",
    ],
)
def test_a_write_that_the_unit_can_not_do_gets_01_or_silence(body):
    body = bytes.fromhex(body)
    assert a_tester().ask(body) == NO
    assert a_tester(unknown="01", bad_write="silent").ask(body) == b""


@pytest.mark.parametrize("body", ["22 00 02 01", "62 99 00", "64 99"])
def test_a_unit_without_the_command_treats_a_bad_write_as_unknown(body):
    tester = a_tester(missing="blocks,write,list")
    assert tester.ask(bytes.fromhex(body)) == b""


# D16


@pytest.mark.parametrize(("rpm", "load"), [(0.0, 0.1), (850.0, 0.1), (5200.0, 0.1), (5200.0, 2.0)])
def test_a_faster_engine_slows_the_stream(rpm, load):
    tester = RawTester(make_bus(quirks=EcuQuirks(stream_load=load), rpm=rpm))
    tester.say(encode(b"\x71\x1a"))
    tester.listen(1.0)
    ends = [time for time, value in tester.heard if value == 0x0D][1:]
    period = len(encode(DATA[0x1A])) * BYTE + 0.0004 + load * rpm / 1e6
    for before, after in pairwise(ends):
        assert after - before == pytest.approx(period)


def test_goto_is_known_and_not_answered():
    assert a_tester(unknown="01").ask(b"\x41\x00\x80") == b""


# Missing groups

A_REQUEST = {
    "passports": b"\x51",
    "bytes": b"\x11\x00",
    "blocks": b"\x21\x00\x01",
    "sfr": b"\x31\x00",
    "count": b"\x60",
    "write": b"\x62\x1a\x00",
    "list": b"\x64\x1a",
    "stream": b"\x71\x1a",
    "stroke": b"\x7f\x1a",
}


def test_the_groups_hold_every_command_that_may_be_absent():
    """§3: everything but 01, 02, 61 (and the erase) may be absent."""
    assert frozenset().union(*GROUPS.values()) == set(COMMANDS_BY_CODE) - {1, 2, 0x61}


@pytest.mark.parametrize("group", A_REQUEST)
def test_a_missing_group_is_unknown_and_the_rest_works(group):
    assert a_tester().ask(A_REQUEST[group]) != b""
    assert a_tester(missing=group).ask(A_REQUEST[group]) == b""
    tester = a_tester(missing=group, unknown="01")
    for code in GROUPS[group]:
        assert tester.ask(bytes([code, 0x1A])) == NO
    for other in A_REQUEST.keys() - {group, "stream", "stroke"}:
        assert tester.ask(A_REQUEST[other]) != NO
    assert tester.ask(b"\x61\x29") == encode(DATA[0x29])


def test_a_missing_goto_is_unknown():
    assert a_tester(missing="goto", unknown="01").ask(b"\x41\x00\x80") == NO


def test_names_groups_and_codes_may_be_missing_in_any_mixture():
    expected = GROUPS["list"] | {0x61, 0x71}
    for text in ("list,61,71", "list+0x61+71", "list 61 0x71", " list , 61,71,"):
        assert EcuQuirks().with_options({"missing": text}).missing == expected
    assert EcuQuirks().with_options({"missing": ""}).missing == frozenset()


# D11


def wanted(count: int) -> bytes:
    return bytes(list(DATA)[:count])


def data(count: int) -> bytes:
    return b"".join(list(DATA.values())[:count])


@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_a_list_over_the_limit_is_unknown(unknown):
    tester = a_tester(max_list="4", unknown=unknown)
    refusal = NO if unknown == "01" else b""
    assert tester.ask(b"\x61" + wanted(4)) == encode(data(4))
    assert tester.ask(b"\x61" + wanted(5)) == refusal
    assert tester.ask(b"\x71" + wanted(5)) == refusal
    assert tester.ask(b"\x80" + wanted(5)) == refusal


def test_a_list_over_the_limit_is_answered_short():
    tester = a_tester(max_list="4", long_list="short")
    assert tester.ask(b"\x61" + wanted(9)) == encode(data(4))
    frame = encode(data(4))
    assert tester.ask(b"\x71" + wanted(9)).startswith(frame + frame)


def test_a_list_that_is_set_is_refused_over_the_limit_and_the_old_one_stays():
    for long_list in ("silent", "short"):
        tester = a_tester(max_list="4", long_list=long_list)
        assert tester.ask(b"\x63") == NO  # none yet
        assert tester.ask(b"\x64" + wanted(3)) == YES
        assert tester.ask(b"\x64" + wanted(5)) == NO
        assert tester.ask(b"\x63") == encode(data(3))


def test_a_list_may_name_a_parameter_twice():
    assert a_tester().ask(b"\x61\x1a\x1a\x3f") == encode(DATA[0x1A] * 2 + DATA[0x3F])


def test_a_list_of_255_codes_is_answered():
    answer = a_tester().ask(b"\x61" + b"\x1a" * 255)
    assert answer == encode(DATA[0x1A] * 255)


# Blocks


@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_a_block_over_the_limit_is_refused(unknown):
    tester = a_tester(max_block="16", unknown=unknown)
    refusal = NO if unknown == "01" else b""
    for read in (b"\x21\x00", b"\x23\x00\x10", b"\x25\x00\x10"):
        assert len(tester.ask(read + b"\x10")) > 16
        assert tester.ask(read + b"\x11") == refusal
    for write in (b"\x22\x00", b"\x24\x00\x10", b"\x26\x00\x10"):
        assert tester.ask(write + b"\x10" + bytes(16)) == YES
        assert tester.ask(write + b"\x11" + b"\xff" * 17) == NO
    assert tester.ask(b"\x11\x00") == encode(b"\x00\x00")  # what was refused was not written


def test_a_block_response_has_its_count_if_set():
    for counted in ("0", "1", "on", "off", "true", "no"):
        tester = a_tester(counted_blocks=counted)
        count = b"\x02" if counted in ("1", "on", "true") else b""
        assert tester.ask(b"\x24\x34\x12\x02\x11\x22") == YES
        assert tester.ask(b"\x23\x34\x12\x02") == encode(b"\x34\x12" + count + b"\x11\x22")
        assert tester.ask(b"\x26\x34\x12\x02\x11\x22") == YES
        assert tester.ask(b"\x25\x34\x12\x02") == encode(b"\x34\x12" + count + b"\x11\x22")
        assert tester.ask(b"\x22\x34\x02\x11\x22") == YES
        assert tester.ask(b"\x21\x34\x02") == encode(b"\x34\x02\x11\x22")  # always


# D14


@pytest.mark.parametrize("turn_round", [0.0, 0.002, 0.1, 10.0])
def test_a_response_begins_after_the_turn_round_delay(turn_round):
    tester = a_tester(turn_round=str(turn_round))
    tester.say(b"\x01\xff\x0d")
    tester.listen(11.0)
    assert tester.times[3] == pytest.approx(3 * BYTE + turn_round + BYTE, abs=1e-9)


# D12


def streaming(stream_end: StreamEnd) -> RawTester:
    tester = a_tester(stream_end=stream_end.value)
    tester.say(encode(b"\x71\x1a\x29"))
    tester.listen(0.1)
    assert is_streaming(tester)
    return tester


def is_streaming(tester: RawTester) -> bool:
    return len(tester.listen(tester.now + 0.3)) > 20


def into_a_gap(tester: RawTester, wire: bytes) -> None:
    """Says `wire` right behind a response."""
    count = len(tester.heard)
    while len(tester.heard) == count or tester.heard[-1][1] != 0x0D:
        tester.listen(tester.bus.next_event())
    tester.say(wire)
    tester.listen(tester.now + len(wire) * BYTE + TURN)


def test_any_byte_ends_a_stream():
    tester = streaming(StreamEnd.BYTE)
    tester.say(b"\xff")
    tester.listen(tester.now + 0.05)
    assert not is_streaming(tester)


def test_only_a_sound_request_ends_such_a_stream():
    tester = streaming(StreamEnd.REQUEST)
    tester.say(b"\xff")  # in the middle of a response
    assert is_streaming(tester)
    into_a_gap(tester, b"\x01\xfe\x0d")  # damaged
    assert is_streaming(tester)
    into_a_gap(tester, b"\x01\xff\x0d")
    assert tester.listen(tester.now + 1.0) == b"\x0a\xf6\x0d"


def test_a_request_in_a_response_is_lost_and_the_stream_goes_on():
    tester = streaming(StreamEnd.REQUEST)
    while tester.heard[-1][1] == 0x0D:  # out of the gap
        tester.listen(tester.bus.next_event())
    tester.say(b"\x01")
    assert is_streaming(tester)


def test_only_a_break_ends_such_a_stream():
    tester = streaming(StreamEnd.BREAK)
    into_a_gap(tester, b"\x01\xff\x0d")
    assert is_streaming(tester)
    tester.bus.send_break(0.05, tester.now)
    tester.listen(tester.now + 0.06)
    assert tester.listen(tester.now + 1.0) == b""
    assert tester.ask(b"\x01") == b"\x0a\xf6\x0d"


@pytest.mark.parametrize("stream_end", StreamEnd)
def test_a_break_ends_every_stream(stream_end):
    tester = streaming(stream_end)
    tester.bus.send_break(0.05, tester.now)
    tester.listen(tester.now + 0.06)
    assert not is_streaming(tester)


@pytest.mark.parametrize("stream_end", [StreamEnd.BYTE, StreamEnd.REQUEST])
def test_one_stream_takes_the_place_of_another(stream_end):
    tester = streaming(stream_end)
    into_a_gap(tester, encode(b"\x71\x20\x3f"))
    tester.listen(tester.now + 0.02)
    body = DATA[0x20] + DATA[0x3F]
    assert encode(body) * 3 in tester.listen(tester.now + 0.3)


# Texts


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("turn_round", "0.05", 0.05),
        ("least_pause", "0.1", 0.1),
        ("max_list", "8", 8),
        ("max_block", "255", 255),
        ("long_list", "short", LongList.SHORT),
        ("unknown", "01", Unknown.ERROR),
        ("stream_end", "break", StreamEnd.BREAK),
        ("raw_checksum", "yes", True),
        ("counted_blocks", "FALSE", False),
        ("max_list_64", "9", 9),
        ("max_list_64", "0", None),
        ("unknown_body", "7f10", b"\x7f\x10"),
        ("accepts", "raw", ChecksumForm.RAW),
        ("lacking", "1A+0x29", frozenset({0x1A, 0x29})),
        ("extra", "33,0x34:2", ((0x33, 1), (0x34, 2))),
    ],
)
def test_options_are_read_from_text(name, text, value):
    assert getattr(EcuQuirks().with_options({name: text}), name) == value


@pytest.mark.parametrize(
    ("name", "text", "allowed"),
    [
        ("turn_round", "-1", "0 … 10"),
        ("turn_round", "nan", "0 … 10"),
        ("turn_round", "soon", "0 … 10"),
        ("turn_round", "11", "0 … 10"),
        ("max_list", "0", "1 … 255"),
        ("max_list", "256", "1 … 255"),
        ("max_block", "1.5", "1 … 255"),
        ("long_list", "loud", "silent, short"),
        ("unknown", "1", "silent, 01"),
        ("stream_end", "", "byte, request, break"),
        ("counted_blocks", "2", "0, 1"),
        ("raw_checksum", "", "0, 1"),
        ("max_list_61", "256", "0 … 255"),
        ("inter_byte", "2", "0 … 1"),
        ("unknown_body", "", "7F10"),
        ("unknown_body", "1", "7F10"),
        ("accepts", "any", "stuffed, raw, both"),
        ("lacking", "TWAT", "0x29"),
        ("lacking", "1A,100", "0x29"),
        ("extra", "33:0", "0x34:2"),
        ("extra", "33:256", "0x34:2"),
        ("extra", "33:", "0x34:2"),
        ("extra", "boost:1", "0x34:2"),
        ("missing", "lists", "passports"),
        ("missing", "99", "0x71"),
        ("missing", "0x171", "0x71"),
    ],
)
def test_an_invalid_value_is_reported_with_the_allowed_ones(name, text, allowed):
    with pytest.raises(UsageError) as caught:
        EcuQuirks().with_options({name: text})
    for language in (caught.value.text.en, caught.value.text.ru):
        assert name in language
        assert allowed in language


def test_an_unknown_switch_names_the_nearest():
    with pytest.raises(UsageError, match="max_list"):
        EcuQuirks().with_options({"maxlist": "3"})
    with pytest.raises(UsageError, match="stream_end"):
        EcuQuirks().with_options({"zzz": "3"})
