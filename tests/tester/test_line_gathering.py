"""Letting bytes come together: fewer looks at the line, the same times, the same patience (D14)."""

from __future__ import annotations

from itertools import islice
from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tester_rig import (
    ADAPTERS,
    DATA,
    ECHOING,
    SILENT_ADAPTER,
    VERSION,
    Fate,
    ScriptedLink,
    Watched,
    adapter_name,
    make,
)

from mikas import commands as c
from mikas.errors import DamagedResponse
from mikas.framing import encode
from mikas.link import Chunk, Link
from mikas.link.virtual import VirtualLink
from mikas.tester import Timing
from mikas.virtual.bus import AdapterKind
from mikas.virtual.fault_injector import LineFault

PLAIN = {code: data for code, data in DATA.items() if not {0x0D, 0x40} & set(data)}
LIST = tuple(c.Datum(code, len(data)) for code, data in DATA.items())
EVERYTHING = c.ReadParameters(LIST)
UNSTUFFED = tuple(c.Datum(code, len(data)) for code, data in PLAIN.items())
TIMING = Timing()


class Looked(VirtualLink):
    """Counts the looks at the line. `late`: how much too long each gathering takes; None: it has
    none, as a link through a network.
    """

    def __init__(self, unit: Watched, late: float | None = 0.0) -> None:
        super().__init__(unit.bus)
        self.late = late
        self.looks = 0

    def read(self, deadline):
        self.looks += 1
        return super().read(deadline)

    def gather(self, until):
        if self.late is not None and until > self.now():
            super().gather(until + self.late)


class ScriptedGathering(ScriptedLink):
    """A scripted link that lets bytes come together, and then gives them together."""

    def gather(self, until):
        self._now = max(self._now, until)

    def read(self, deadline):
        data, time = super().read(deadline)
        while data and self.coming and self.coming[0][0] <= self._now:
            data += super().read(self._now).data
        return Chunk(data, time)


def connected(late: float | None = 0.0, adapter: AdapterKind = ECHOING, **settings):
    unit = Watched(adapter=adapter, **settings)
    link = Looked(unit, late)
    return unit, link, unit.connected(link)


def looks_for(command: c.Command, late: float | None) -> int:
    _, link, tester = connected(late)
    before = link.looks
    tester.request(command)
    return link.looks - before


@pytest.mark.parametrize("command", [c.ReadParameters(UNSTUFFED), c.ReadXramBlock(0, 8)])
def test_a_response_takes_a_few_looks_and_not_one_a_byte(command):
    assert looks_for(command, 0.0) <= 10
    assert looks_for(command, None) > 16


def test_a_long_response_takes_a_look_every_ten_milliseconds():
    assert looks_for(c.ReadXramBlock(0, 250), 0.0) <= 250 / 9 + 12


def test_a_stream_takes_few_looks_a_response():
    _, link, tester = connected()
    with tester.stream(c.StreamCyclic(UNSTUFFED)) as stream:
        next(stream)
        before = link.looks
        for _ in range(10):
            next(stream)
        assert link.looks - before <= 10 * 4


def replies(link: Link, tester):
    observed = []
    for command in (EVERYTHING, c.ReadXramBlock(0, 100), c.Availability(), EVERYTHING):
        reply = tester.exchange(command)[1]
        observed.append((reply.wire, reply.began, reply.ended))
    for command in (c.StreamCyclic(LIST), c.StreamAtStroke(LIST, 0)):
        with tester.stream(command) as stream:
            observed += [(item.body, item.time, item.time) for item in islice(stream, 5)]
    return observed


@pytest.mark.parametrize("adapter", ADAPTERS, ids=adapter_name)
def test_times_are_the_same_with_gathering_and_without(adapter):
    with_it = replies(*connected(0.0, adapter)[1:])
    without = replies(*connected(None, adapter)[1:])
    half = Looked(Watched()).byte_time / 2
    for (wire, began, ended), (wire_too, began_too, ended_too) in zip(
        with_it, without, strict=True
    ):
        assert wire == wire_too
        assert began == pytest.approx(began_too, abs=half)
        assert ended == pytest.approx(ended_too, abs=half)


@pytest.mark.parametrize("adapter", ADAPTERS, ids=adapter_name)
@pytest.mark.parametrize("late", [0.001, 0.015, 0.1])
def test_a_busy_computer_that_wakes_late_costs_no_response(adapter, late):
    _, _, tester = connected(late, adapter)
    replies(tester.link, tester)
    assert tester.statistics.failed == 0


@pytest.mark.parametrize("adapter", [ECHOING, SILENT_ADAPTER], ids=adapter_name)
def test_a_response_that_breaks_off_is_given_up_in_time(adapter):
    given_up = []
    for late in (None, 0.0):
        unit, _, tester = connected(late, adapter, fault_injector=Fate([]))
        unit.fault_injector.next(LineFault.CUT)
        with pytest.raises(DamagedResponse) as caught:
            tester.exchange(EVERYTHING, retries=0)
        given_up.append(caught.value.time)
    without, with_it = given_up
    assert without <= with_it <= without + TIMING.inter_byte_timeout / 2 + 1e-9


@given(
    pauses=st.lists(st.floats(0, 0.99 * TIMING.inter_byte_timeout), min_size=26, max_size=26),
    echo=st.booleans(),
)
def test_pauses_that_are_allowed_are_allowed_wherever_they_are(pauses, echo):
    wire = encode(bytes(range(0x80, 0x80 + 25)))
    assert len(wire) == len(pauses) + 1
    request = encode(b"\x63")

    def answer(sent):
        if sent != request:
            return [(0.003, encode(bytes([VERSION])))]
        times = [0.003]
        for pause in pauses:
            times.append(times[-1] + pause + 10 / 9600)
        return list(zip(times, (bytes([value]) for value in wire), strict=True))

    link = ScriptedGathering(answer, echo=echo)
    tester = make(link)
    tester.connect()
    asked = link.now()
    _, reply = tester.exchange(c.ReadList(tuple(c.Datum(code, 1) for code in range(25))))
    assert reply.wire == wire
    assert reply.began == pytest.approx(asked + 0.003 + 2 * 10 / 9600, abs=10 / 9600)


def test_an_echo_that_the_adapter_makes_itself_is_timed_when_it_comes():
    """Its baud rate follows from that."""
    link = ScriptedGathering(lambda sent: [(0.003, encode(bytes([VERSION])))])
    link_write = link.write

    def write(data):  # the echo comes in the tenth of the wire's time
        link_write(data)
        link.coming.sort()
        at, count, echoed = link.coming[0]
        link.coming[0] = (at - 0.9 * len(data) * link.byte_time, count, echoed)

    link.write = write
    tester = make(link)
    tester.connect()
    assert tester.time_echo(b"\x01") == pytest.approx(0.1 * 3 * link.byte_time)


def test_gathering_never_waits_beyond_a_streams_deadline():
    _, link, tester = connected(rpm=0.0)
    with tester.stream(c.StreamAtStroke(LIST, 0)) as stream:
        deadline = link.now() + 0.001
        assert stream.read(deadline) is None
        assert link.now() == pytest.approx(deadline, abs=1e-9)
        assert stream.read(-inf) is None
        assert link.now() == pytest.approx(deadline, abs=1e-9)
