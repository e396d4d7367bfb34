"""The end of a stream (D12): `01` in a gap, a line break only where nothing else ends it."""

from __future__ import annotations

import pytest
from stream_cases import BY_STROKES, ONE, SEVERAL
from tester_rig import VERSION, ScriptedLink, Watched, make, right

from mikas import commands as c
from mikas.errors import LineNotQuiet, MikasError
from mikas.framing import encode
from mikas.virtual.quirks import StreamEnd

AVAILABILITY = encode(b"\x01")
ENDING_BY_01 = [StreamEnd.BYTE, StreamEnd.REQUEST]
OF_SEVERAL = c.StreamAtStroke(SEVERAL, 0)
OF_ONE = c.StreamAtStroke(ONE, 0)  # its datum looks like the answer to 01


def sent_by(unit: Watched) -> list[bytes]:
    """All frames sent from now on."""
    sent, write = [], unit.link.write

    def keep(data: bytes) -> None:
        sent.append(data)
        write(data)

    unit.link.write = keep
    return sent


@pytest.mark.parametrize("phase", range(12))
@pytest.mark.parametrize("end", ENDING_BY_01)
def test_the_01_waits_for_the_end_of_a_response(phase, end):
    unit = Watched(stream_end=end)
    tester = unit.connected()
    tester.wait(unit.link.now() + 2)
    with tester.stream(OF_SEVERAL) as stream:
        next(stream)
        start = unit.car.next_stroke(0, unit.link.now())
        stream.read(start + phase * unit.link.byte_time / 2)
        sent = sent_by(unit)
    assert sent == [AVAILABILITY, AVAILABILITY]  # the second one confirms
    assert tester.sync.breaks == 0
    right(tester)


@pytest.mark.parametrize("command", [OF_ONE, OF_SEVERAL], ids=lambda s: s.body().hex())
def test_a_unit_that_ignores_the_01_gets_one_break_a_stream(command):
    """After several attempts without one (D12)."""
    unit = Watched(stream_end=StreamEnd.BREAK, rpm=5200.0)
    tester = unit.connected()
    for count in (1, 2):
        sent = sent_by(unit)
        with tester.stream(command) as stream:
            next(stream)
        assert tester.sync.breaks == unit.count_of("stream-end") == count
        assert 3 <= sent.count(AVAILABILITY) <= 12
        right(tester)


@pytest.mark.parametrize("end", list(StreamEnd))
@pytest.mark.parametrize("command", BY_STROKES, ids=lambda s: s.body().hex())
def test_a_unit_that_may_not_have_heard_the_01_gets_a_break(command, end):
    """The engine stands: the unit is silent anyway, unless it has answered."""
    unit = Watched(stream_end=end)
    tester = unit.connected()
    with tester.stream(command) as stream:
        next(stream)
        unit.car.rpm = 0.0
    assert tester.sync.breaks == (command.parameters == ONE or end not in ENDING_BY_01)
    unit.car.rpm = 850.0
    right(tester)
    assert unit.count_of("stream-end") == 1


@pytest.mark.parametrize("command", [OF_ONE, OF_SEVERAL], ids=lambda s: s.body().hex())
def test_a_last_response_that_looks_like_the_answer_to_01_is_not_taken_for_it(command):
    """100 rpm: one response right behind the `01`, then none for longer than a late answer."""
    unit = Watched(stream_end=StreamEnd.BREAK, rpm=100.0)
    tester = unit.connected()
    with tester.stream(command) as stream:
        next(stream)
        stream.read(unit.car.next_stroke(0, unit.link.now()) - 0.05)
    assert tester.sync.breaks == 1
    assert unit.count_of("stream-end") == 1
    unit.car.rpm = 850.0
    right(tester)


@pytest.mark.parametrize("end", list(StreamEnd))
@pytest.mark.parametrize("command", BY_STROKES, ids=lambda s: s.body().hex())
def test_a_stream_that_failed_to_start_is_ended_though_the_engine_stands(command, end):
    """Its request came back damaged: whether the unit streams shows only at the next stroke."""
    unit = Watched(stream_end=end, rpm=0.0)
    tester = unit.connected()
    unit.fault_injector.spoils_next_echo = True
    with pytest.raises(MikasError):
        tester.stream(command)
    right(tester)
    assert tester.sync.breaks == 1
    unit.car.rpm = 850.0
    right(tester)
    assert unit.count_of("stream-end") == unit.count_of("stream") == 1


class Stubborn(ScriptedLink):
    """Streams at each stroke until a break, whatever it answers meanwhile."""

    def send_break(self, seconds: float) -> None:
        self.coming.clear()
        super().send_break(seconds)


def test_an_answer_to_01_is_not_the_end_of_a_stream_by_strokes():
    def answer(sent: bytes) -> list[tuple[float, bytes]]:
        if sent == AVAILABILITY:
            return [(0.005, encode(bytes([VERSION])))]
        return [(0.14 * stroke, encode(b"abcd")) for stroke in range(1, 100)]

    link = Stubborn(answer)
    tester = make(link)
    tester.connect()
    with tester.stream(OF_SEVERAL) as stream:
        assert next(stream).body == b"abcd"
    assert link.breaks == tester.sync.breaks == 1
    assert link.read(link.now() + 1).data == b""


def test_a_cable_that_ignores_the_break_ends_in_an_error_that_says_what_to_do():
    """A copy of a chip may take the request of a break and do nothing."""
    unit = Watched(stream_end=StreamEnd.BREAK, rpm=5200.0)
    unit.link.send_break = lambda seconds: None
    tester = unit.connected()
    stream = tester.stream(OF_SEVERAL)
    next(stream)
    start = unit.link.now()
    with pytest.raises(LineNotQuiet, match="a stream that the unit does not end") as caught:
        stream.close()
    assert "switch the ignition off for ten seconds" in str(caught.value)
    assert unit.link.now() - start < 2
