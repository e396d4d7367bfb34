"""The decoders of instruments: worked bytes, and what holds for any bytes."""

from __future__ import annotations

import sys
from functools import reduce
from itertools import pairwise
from operator import xor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.instruments import (
    InstrumentDecoder,
    InstrumentValues,
    NoValues,
    decoder_of,
    definition_named,
)

SHIPPED = ("14point7", "aem", "gpsd", "innovate", "nmea")
LC1 = bytes.fromhex("B2 82 43 13 03 6B")


def decoder(name: str) -> InstrumentDecoder:
    return decoder_of(definition_named(name))


def sentence(body: str) -> bytes:
    return f"${body}*{reduce(xor, body.encode(), 0):02X}\r\n".encode()


def values(name: str, data: bytes) -> list[dict[str, float]]:
    """Return the values of all messages, rounded."""
    return [
        {channel: round(value, 6) for channel, value in event.values.items()}
        for event in decoder(name).feed(data)
        if isinstance(event, InstrumentValues)
    ]


def reasons(name: str, data: bytes) -> list[str]:
    return [event.reason.en for event in decoder(name).feed(data) if isinstance(event, NoValues)]


def test_a_gauge_of_aem_sends_the_ratio_or_lambda_and_both_are_given() -> None:
    assert values("aem", b"\r\n14.7\r\n0.98\r\n13.2\tx\r\n") == [
        {"AFR": 14.7, "LAMBDA": 1.0},
        {"LAMBDA": 0.98, "AFR": 14.406},
        {"AFR": 13.2, "LAMBDA": 0.897959},
    ]


def test_the_first_line_of_a_connection_is_left_out_as_its_begin_may_be_missing() -> None:
    assert values("aem", b"4.7\r\n14.7\r\n") == [{"AFR": 14.7, "LAMBDA": 1.0}]
    meter = decoder("aem")
    meter.feed(b"\r\n14.7\r\n1")
    meter.drop()  # “1” and the rest of another line are no 14.2
    assert meter.feed(b"4.2\r\n") == []
    assert [event for event in meter.feed(b"13.0\r\n") if isinstance(event, InstrumentValues)]


def test_a_line_that_is_none_says_why() -> None:
    assert reasons("aem", b"\r\nhello\r\n400\r\n" + b"1" * 300 + b"\r\n") == [
        "not understood",
        "a value that the instrument can't have",
        "a line without an end",
    ]


def test_a_spartan_may_name_its_value() -> None:
    assert values("14point7", b"\nLambda:0.987\nAFR=14.7\n") == [
        {"LAMBDA": 0.987, "AFR": 14.5089},
        {"AFR": 14.7, "LAMBDA": 1.0},
    ]


def test_an_innovate_sends_lambda_with_the_ratio_of_its_fuel() -> None:
    assert values("innovate", LC1) == [{"LAMBDA": 0.991, "AFR": 14.5677}]
    chain = bytes.fromhex("B2 87 43 13 03 6B") + bytes(10)  # other sensors behind it
    assert values("innovate", chain * 2) == [{"LAMBDA": 0.991, "AFR": 14.5677}] * 2


@pytest.mark.parametrize(
    ("function", "reason"),
    [(1, "leaner than can be measured"), (4, "the sensor warms up"), (6, "the controller reports")],
)
def test_an_innovate_without_a_value_says_why(function: int, reason: str) -> None:
    packet = bytearray(LC1)
    packet[2] |= function << 2
    assert values("innovate", bytes(packet)) == []
    assert reason in reasons("innovate", bytes(packet))[0]


@pytest.mark.parametrize("lost", range(len(LC1)))
def test_a_lost_byte_costs_an_innovate_two_packets_at_most(lost: int) -> None:
    broken = LC1[:lost] + LC1[lost + 1 :]
    found = values("innovate", LC1 + broken + LC1 * 2)
    assert set(map(str, found)) == {str({"LAMBDA": 0.991, "AFR": 14.5677})}
    assert len(found) >= 2


def test_minutes_are_the_two_digits_before_the_point() -> None:
    """Not what follows two digits: 807.038 without its zero was 80° 7.038′."""
    line = sentence("GPRMC,1,A,807.038,N,131.000,W,0,,230394,,")
    assert values("nmea", line) == [{"GPS_LAT": 8.1173, "GPS_LON": -1.516667, "GPS_SPEED": 0.0}]
    for wrong in ("-4807.038", "+4807.038", "07.038", "7.038", "4860.000", "48-7.038", "48", ""):
        line = sentence(f"GPRMC,1,A,{wrong},N,01131.000,E,0,,230394,,")
        assert reasons("nmea", line) == ["not understood"], wrong


def test_a_receiver_sends_position_speed_and_altitude() -> None:
    rmc = b"$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\r\n"
    gga = b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\r\n"
    place = {"GPS_LAT": 48.1173, "GPS_LON": 11.516667}
    assert values("nmea", rmc + gga) == [
        {**place, "GPS_SPEED": 41.4848, "GPS_COURSE": 84.4},
        {**place, "GPS_ALT": 545.4},
    ]
    assert values("nmea", sentence("GNVTG,084.4,T,,M,022.4,N,041.5,K,A")) == [
        {"GPS_SPEED": 41.5, "GPS_COURSE": 84.4}
    ]
    south = sentence("GNRMC,1,A,3351.000,S,15112.000,W,0.0,,230394,,,A")
    assert values("nmea", south) == [{"GPS_LAT": -33.85, "GPS_LON": -151.2, "GPS_SPEED": 0.0}]


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6B\r\n", "checksum"),
        (b"$GPRMC,123519,A,4807.038,N\r\n", "checksum"),
        (sentence("GPRMC,1,V,,,,,,,,,"), "no position"),
        (sentence("GPGGA,1,,,,,0,,,,,,,,"), "no position"),
        (sentence("GPRMC,1,A,4861.0,N,01131.0,E,1,1,1,,"), "not understood"),
        (sentence("GPRMC,1,A,4807.0,X,01131.0,E,1,1,1,,"), "can't have"),
        (sentence("GPRMC,1,A"), "not understood"),
        (sentence("GPRMC,1,A,4807.0,N,01131.0,E,nan,1,1,,"), "not understood"),
    ],
)
def test_a_sentence_without_a_value_says_why(data: bytes, reason: str) -> None:
    assert values("nmea", data) == []
    assert reason in reasons("nmea", data)[0]


def test_the_rest_of_a_sentence_before_another_one_does_not_spoil_it() -> None:
    assert values("nmea", b"*47$GPR" + sentence("GNVTG,,T,,M,,N,5.0,K")) == [{"GPS_SPEED": 5.0}]


def test_gpsd_gives_metres_a_second_and_other_reports_that_are_no_concern() -> None:
    lines = (
        b'{"class":"VERSION","release":"3.25"}\r\n'
        b'{"class":"TPV","mode":3,"lat":56.1,"lon":43.9,"speed":10.0,"track":90,"altMSL":120.5}\n'
        b'{"class":"TPV","mode":2,"lat":56.1,"lon":43.9,"alt":100}\n'
    )
    place = {"GPS_LAT": 56.1, "GPS_LON": 43.9}
    assert values("gpsd", lines) == [
        {**place, "GPS_SPEED": 36.0, "GPS_ALT": 120.5, "GPS_COURSE": 90.0},
        {**place, "GPS_ALT": 100.0},
    ]
    assert reasons("gpsd", lines) == []
    odd = b'{"class":"TPV","mode":1}\n[1]\n{"class":"TPV","mode":3,"lat":true}\n' + b"[" * 9000
    assert reasons("gpsd", odd + b"\n") == ["no position yet", *["not understood"] * 3]


LIKELY = st.one_of(
    st.sampled_from([
        LC1, b"14.7\r\n", b"0.98\r", b"\n", b"1", b".", b"-", b"nan", b"\xb2\x82", b"\xff", b"$",
        b"*", b",", b"{", b'{"class":"TPV","mode":3,"lat":1e999,"lon":NaN}\n', b"1" * 300,
        sentence("GPRMC,1,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W"),
        sentence("GPGGA,1,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"),
    ]),
    st.binary(max_size=12),
)  # fmt: skip
WIRES = st.lists(LIKELY, max_size=30).map(b"".join)


@given(name=st.sampled_from(SHIPPED), wire=WIRES, cuts=st.lists(st.integers(0, 400), max_size=8))
def test_cutting_into_pieces_never_changes_the_events(
    name: str, wire: bytes, cuts: list[int]
) -> None:
    whole = decoder(name).feed(wire)
    one, found = decoder(name), []
    edges = [0, *sorted(cuts), len(wire)]
    for begin, end in pairwise(edges):
        found += one.feed(wire[begin:end])
    assert found == whole
    singly = decoder(name)
    assert [event for byte in wire for event in singly.feed(bytes([byte]))] == whole
    ends = [event.end for event in whole]
    assert ends == sorted(ends)
    assert all(0 < end <= len(wire) for end in ends)


@given(name=st.sampled_from(SHIPPED), wire=WIRES, head=st.binary(max_size=20))
def test_after_a_lost_connection_messages_are_those_of_a_new_one(
    name: str, wire: bytes, head: bytes
) -> None:
    again = decoder(name)
    again.feed(head)
    again.drop()
    new = decoder(name).feed(wire)
    found = again.feed(wire)
    assert [type(event) for event in found] == [type(event) for event in new]
    assert [event.end - len(head) for event in found] == [event.end for event in new]


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.parametrize("piece", [b"x", b"\xb2\xff", b"\x80", b"$GP", b"1", b"{"])
def test_memory_is_bounded_whatever_comes(name: str, piece: bytes) -> None:
    one = decoder(name)
    for _ in range(200):
        for event in one.feed(piece * 100):
            assert isinstance(event, NoValues)
            assert len(event.data) <= 520
    assert _size(one) < 40_000


def _size(found: object, seen: set[int] | None = None) -> int:
    """Return the bytes of the buffers within an object of ours."""
    seen = set() if seen is None else seen
    if id(found) in seen:
        return 0
    seen.add(id(found))
    if isinstance(found, bytes | bytearray):
        return sys.getsizeof(found)
    inside = vars(found).values() if hasattr(found, "__dict__") else ()
    return sum(_size(each, seen) for each in inside)
