"""When a response began on the wire, as its bytes tell that come in lumps (D14)."""

from __future__ import annotations

from itertools import islice, pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tester_rig import SLOW, VERSION, ScriptedLink, Watched, make

from mikas import commands as c
from mikas.framing import encode
from mikas.tester import Timing

BYTE = 10 / 9600
SIX = tuple(c.Datum(code, 1) for code in range(6))
WIRE = encode(bytes(range(0x20, 0x26)))  # 8 bytes
FIRST = 0.003  # when it begins, behind the request
STREAM = encode(bytes([0x71, *range(6)]))


def lumps(handed_over: list[int], late: list[float], responses: int) -> list[tuple[float, bytes]]:
    """`responses` of `WIRE` one behind another, in lumps that end at these bytes of each and come
    so much later than their last byte.
    """
    ends = [r * len(WIRE) + end for r in range(responses) for end in handed_over]
    ends = sorted({*ends, responses * len(WIRE)})
    came, start, last = [], 0, 0.0
    for number, end in enumerate(ends):
        last = max(last, FIRST + end * BYTE + late[number % len(late)])
        came.append((last, (WIRE * responses)[start:end]))
        start = end
    return came


def talking(request: bytes, coming: list[tuple[float, bytes]]):
    """A tester whose unit answers `request` by what is `coming`."""

    def answer(sent: bytes) -> list[tuple[float, bytes]]:
        return coming if sent == request else [(0.005, encode(bytes([VERSION])))]

    tester = make(ScriptedLink(answer), timing=Timing(inter_byte_timeout=0.1))
    tester.connect()
    return tester


lateness = st.lists(st.floats(0, 0.015), min_size=1, max_size=9)
cuts = st.lists(st.integers(1, len(WIRE)), min_size=1, max_size=4)


def earliest(came: list[tuple[float, bytes]], offset: int) -> float:
    """What the lumps with the byte at `offset` and those behind it, up to the response's end, tell
    of its time.
    """
    reported, end = [], 0
    for time, data in came:
        begins, end = end, end + len(data)
        if end > offset and begins < offset + len(WIRE):
            reported.append(time - (end - offset) * BYTE)
    return min(reported)


@given(cuts, lateness)
def test_a_streams_response_began_no_later_than_any_of_its_lumps_says(handed_over, late):
    came = lumps(handed_over, late, 4)
    tester = talking(STREAM, came)
    asked = tester.link.now()
    with tester.stream(c.StreamCyclic(SIX)) as stream:
        times = [item.time - asked - len(STREAM) * BYTE for item in islice(stream, 4)]
    for number, time in enumerate(times):
        began = earliest(came, number * len(WIRE))
        before = times[number - 1] if number else 0.0
        if abs(began - before) > 1e-9:  # else either is right
            assert time == pytest.approx(began if began > before else before + BYTE, abs=1e-9)
        assert time > before


def test_late_bytes_in_one_chunk_do_not_run_back_in_time():
    """The first response was held up for 0.2 s, and the others with it: they come right behind."""
    ends = [FIRST + (r + 1) * len(WIRE) * BYTE for r in range(40)]
    came = [(max(end, ends[0] + 0.2), WIRE) for end in ends]
    with talking(STREAM, came).stream(c.StreamCyclic(SIX)) as stream:
        times = [item.time for item in islice(stream, 40)]
    steps = [after - before for before, after in pairwise(times)]
    assert min(steps) > 0
    assert steps[-1] == pytest.approx(len(WIRE) * BYTE)  # in time again
    assert times[-1] - times[0] == pytest.approx(39 * len(WIRE) * BYTE - 0.2)


@given(cuts, lateness)
def test_one_response_to_a_request_began_no_later_than_its_lumps_say(handed_over, late):
    came = lumps(handed_over, late, 1)
    request = encode(b"\x63")
    tester = talking(request, came)
    asked = tester.link.now()
    reply = tester.exchange(c.ReadList(SIX))[1]
    assert reply.wire == WIRE
    began = reply.began - asked - len(request) * BYTE
    assert began == pytest.approx(earliest(came, 0), abs=1e-9)


def test_with_an_adapter_of_16_ms_it_is_right_to_one_chunk_less_its_bytes():
    """A response of 6 bytes by strokes: within 16 ms less 5 bytes; it was up to 16 ms."""
    unit = Watched(adapter=SLOW, rpm=3100.0)
    tester = unit.connected()
    command = c.StreamAtStroke(tuple(c.Datum(code, 1) for code in (16, 17, 18, 22)), 0)
    begins = []
    transmit = unit.ecu.transmit

    def watched(now: float) -> bytes:
        wire = transmit(now)
        if wire:
            begins.append(now)
        return wire

    unit.ecu.transmit = watched
    with tester.stream(command) as stream:
        times = [item.time for item in islice(stream, 40)]
    late = [min(t - b for b in begins if b <= t + 1e-6) for t in times]
    assert min(late) >= -1e-6
    assert max(late) < 0.016 - 5 * BYTE
