"""When bytes come: the pace of §1, the arithmetic of §5, the strokes of D15."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas import commands as c
from mikas.framing import encode
from mikas.virtual.bus import Bus
from mikas.virtual.ecu import PARTIAL_REQUEST_LIFE, VirtualEcu
from mikas.virtual.quirks import EcuQuirks, StreamEnd
from mikas.virtual.responder import Responder
from virtual_harness import DATA, IDENTITY, TableCar, connected, make_bus

from .raw_tester import BYTE, TURN, RawTester

EXACT = 1e-9
QUIRKS = EcuQuirks()
RPM = 850
GAP = QUIRKS.stream_gap + QUIRKS.stream_load / 1000 * RPM / 1000  # D16
DATUMS = tuple(c.Datum(code, len(raw)) for code, raw in DATA.items())


def test_every_byte_takes_ten_bits():
    tester = RawTester(make_bus())
    tester.say(encode(b"\x51"))
    tester.listen(1.0)
    request, response = 3, 18
    starts = [n * BYTE for n in range(request)]
    starts += [request * BYTE + TURN + n * BYTE for n in range(response)]
    assert tester.times == pytest.approx([start + BYTE for start in starts], abs=EXACT)


@pytest.mark.parametrize("baud", [300, 9600, 10400, 115200])
def test_at_another_baud_rate_bytes_take_its_time(baud):
    ecu = VirtualEcu(Responder(TableCar(DATA), IDENTITY), baud=baud)
    tester = RawTester(Bus(ecu))
    tester.say(b"\x01\xff\x0d")
    tester.listen(5.0)
    assert tester.times[-1] == pytest.approx(6 * 10 / baud + TURN, abs=EXACT)


def test_bytes_written_in_pieces_are_sent_without_gaps():
    tester = RawTester(make_bus())
    for value in b"\x01\xff\x0d":
        tester.say(bytes([value]))
    tester.listen(1.0)
    assert tester.times[:3] == pytest.approx([BYTE, 2 * BYTE, 3 * BYTE], abs=EXACT)


def test_a_byte_does_not_arrive_before_its_last_bit():
    tester = RawTester(make_bus())
    tester.say(b"\x01")
    assert tester.listen(BYTE * 0.999) == b""
    assert tester.listen(BYTE * 1.001) == b"\x01"


# §5: 21 codes, 25 data bytes, d = 2 ms. The table has two more stuffed bytes in every full set.


def seconds_of(act, times=20):
    tester = connected()
    act(tester)
    began = tester.link.now()
    for _ in range(times):
        act(tester)
    return (tester.link.now() - began) / times


def stuffing(*bodies: bytes) -> int:
    return sum(len(encode(body)) - len(body) - 2 for body in bodies)


def test_one_request_a_code_takes_the_time_of_the_law():
    def single(tester):
        for datum in DATUMS:
            tester.request(c.ReadParameters((datum,)))

    data_stuffed = stuffing(*DATA.values())
    requests_stuffed = stuffing(*(bytes([0x61, code]) for code in DATA))
    wire = (151 + requests_stuffed + data_stuffed) * BYTE + 21 * TURN
    assert requests_stuffed == 1  # so 152, as §5 counts it
    assert seconds_of(single) == pytest.approx(wire, rel=0.01)
    assert pytest.approx(0.200, rel=0.01) == 152 * BYTE + 21 * TURN


def test_all_codes_in_one_request_take_the_time_of_the_law():
    body = b"\x61" + bytes(DATA)
    answer = b"".join(DATA.values())
    assert len(encode(body)) == 25
    assert len(answer) + 2 == 27
    took = seconds_of(lambda tester: tester.request(c.ReadParameters(DATUMS)))
    assert took == pytest.approx((52 + stuffing(answer)) * BYTE + TURN, rel=0.01)
    assert pytest.approx(0.056, rel=0.01) == 52 * BYTE + TURN


def test_a_list_takes_the_time_of_the_law():
    def read(tester):
        if not tester.has_answered(0x63):
            tester.request(c.WriteList(DATUMS))
        tester.request(c.ReadList(DATUMS))

    answer = b"".join(DATA.values())
    assert seconds_of(read) == pytest.approx((30 + stuffing(answer)) * BYTE + TURN, rel=0.01)
    assert pytest.approx(0.033, rel=0.01) == 30 * BYTE + TURN


def test_a_stream_has_the_period_of_the_law():
    answer = encode(b"".join(DATA.values()))
    tester = RawTester(make_bus(rpm=RPM))
    tester.say(encode(b"\x71" + bytes(DATA)))
    tester.listen(10.0)
    ends = [tester.times[n] for n in range(25 + len(answer), len(tester.heard), len(answer))]
    period = (ends[-1] - ends[0]) / (len(ends) - 1)
    assert period == pytest.approx(len(answer) * BYTE + GAP, rel=0.001)
    assert pytest.approx(0.028, rel=0.02) == 27 * BYTE + QUIRKS.stream_gap  # §5


def test_a_stream_begins_a_turn_round_after_its_request_and_goes_on_after_its_gap():
    tester = RawTester(make_bus(rpm=RPM))
    tester.say(encode(b"\x71\x1a"))  # 4 bytes; each response has 3
    tester.listen(0.2)
    for number in range(5):
        start = 4 * BYTE + TURN + number * (3 * BYTE + GAP)
        assert tester.times[4 + 3 * number] == pytest.approx(start + BYTE, abs=EXACT)


# D15


def stroke_times(rpm: float, code: int, parameters: bytes = b"\x1a", seconds: float = 10.0):
    """When each response began."""
    tester = RawTester(make_bus(rpm=rpm))
    request = encode(bytes([code]) + parameters)
    tester.say(request)
    tester.listen(seconds)
    size = len(encode(b"".join(DATA[p] for p in parameters)))
    assert (len(tester.heard) - len(request)) % size in range(size)
    return [t - BYTE for t in tester.times[len(request) :: size]]


@pytest.mark.parametrize(("rpm", "rate"), [(850, 7.083), (5200, 43.33)])
def test_strokes_bring_one_response_a_cycle(rpm, rate):
    times = stroke_times(rpm, 0x7F)
    assert len(times) == pytest.approx(10 * rate, abs=1.5)
    for a, b in pairwise(times):
        assert b - a == pytest.approx(120 / rpm, abs=1e-6)


@pytest.mark.parametrize(("code", "phase"), [(0x7F, 0), (0x80, 0), (0x81, 1), (0x82, 2), (0x83, 3)])
@pytest.mark.parametrize("rpm", [850, 3000])
def test_a_stroke_begins_at_its_quarter_of_the_cycle(code, phase, rpm):
    cycle = 120 / rpm
    for time in stroke_times(rpm, code):
        place = (time / cycle - phase / 4) % 1
        assert min(place, 1 - place) < 1e-6


def test_cycles_are_skipped_while_a_response_is_being_sent():
    """25 data bytes take 28 ms and more: at 5200 rpm, a cycle of 23 ms, every second one."""
    times = stroke_times(5200, 0x7F, bytes(DATA))
    for a, b in pairwise(times):
        assert b - a == pytest.approx(2 * 120 / 5200, abs=1e-6)


def test_nothing_from_a_standing_engine_until_it_starts():
    bus = make_bus(rpm=0.0)
    tester = RawTester(bus)
    tester.say(encode(b"\x7f\x1a"))
    tester.listen(20.0)
    assert tester.data == encode(b"\x7f\x1a")
    bus.ecu.responder.car.rpm = 850
    tester.listen(30.0)
    assert (len(tester.heard) - 4) / 3 == pytest.approx(70, abs=2)
    bus.ecu.responder.car.rpm = 0
    tester.listen(31.0)
    assert tester.listen(50.0) == b""
    assert tester.ask(b"\x01") == b"\x0a\xf6\x0d"


@given(
    rpm=st.floats(1, 20000),
    stroke=st.integers(0, 4),
    after=st.floats(0, 2e9),
)
def test_the_table_cars_next_stroke_is_never_past_nor_more_than_a_cycle_away(rpm, stroke, after):
    time = TableCar({}, rpm=rpm).next_stroke(stroke, after)
    assert after <= time <= after + 120 / rpm + 1e-6


# D2


def test_the_rest_of_a_request_may_be_late_up_to_a_limit():
    for pause, answered in ((0.9, True), (1.2, False)):
        tester = RawTester(make_bus())
        tester.say(b"\x01\xff")
        tester.say(b"\x0d", at=2 * BYTE + pause * PARTIAL_REQUEST_LIFE)
        assert (tester.listen(1.0)[-3:] == b"\x0a\xf6\x0d") is answered


def test_half_a_request_does_not_spoil_the_next_one():
    tester = RawTester(make_bus())
    tester.say(b"\x61\x1a")
    tester.listen(0.2)
    assert tester.ask(b"\x01") == b"\x0a\xf6\x0d"


def test_half_a_request_in_a_gap_stops_a_stream_only_for_a_moment():
    tester = RawTester(make_bus(quirks=EcuQuirks(stream_end=StreamEnd.REQUEST)))
    tester.say(encode(b"\x71\x1a"))
    frame = encode(DATA[0x1A])
    tester.listen(0.1)
    while tester.heard[-1][1] != 0x0D:
        tester.listen(tester.bus.next_event())
    said_at = tester.now
    tester.say(b"\x01")
    after = len(tester.heard) + 1  # its echo
    tester.listen(said_at + 1.0)
    assert tester.times[after] - BYTE == pytest.approx(said_at + BYTE + PARTIAL_REQUEST_LIFE)
    assert bytes(v for _, v in tester.heard[after:]).startswith(frame * 10)


def test_two_requests_at_once_are_answered_one_behind_the_other():
    tester = RawTester(make_bus())
    wire = b"\x01\xff\x0d" + encode(b"\x60")
    tester.say(wire)
    assert tester.listen(1.0) == wire + b"\x0a\xf6\x0d" + encode(b"\x15")
