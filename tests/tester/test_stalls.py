"""A line that stalls like a Wi-Fi bridge: 30 to 180 ms, more than once a second (D14)."""

from __future__ import annotations

import pytest
from tester_rig import DATA, Watched, right

from mikas import commands as c
from mikas.link import LinkWrapper
from mikas.virtual.bus import AdapterKind, Stalls
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.quirks import StreamEnd

ADAPTERS = [AdapterKind(), AdapterKind(latency=0.016), AdapterKind(echo=False)]
EVERYTHING = tuple(c.Datum(code, len(raw)) for code, raw in DATA.items())


def stalling(seed: int, adapter: AdapterKind, **quirks: object) -> Watched:
    return Watched(adapter=adapter, stalls=Stalls(0.6, 0.18, seed=seed), **quirks)


each_adapter = pytest.mark.parametrize("adapter", ADAPTERS, ids=["at-once", "lumps", "no-echo"])


@each_adapter
@pytest.mark.parametrize("seed", range(20))
def test_the_handshake_finds_the_unit_at_the_first_attempt(seed, adapter):
    tester = stalling(seed, adapter).connected()
    assert tester.line.echo is adapter.echo
    assert tester.statistics.failed == 0


@each_adapter
@pytest.mark.parametrize("seed", range(5))
def test_no_request_fails_or_is_repeated(seed, adapter):
    unit = stalling(seed, adapter)
    tester = unit.connected()
    for _ in range(60):
        assert tester.request(c.ReadParameters(EVERYTHING)) == tuple(DATA.values())
        right(tester)
    assert unit.bus.adapter.stalls.total > 0.5
    assert (tester.statistics.failed, tester.statistics.repeated, tester.sync.found_again) == (
        0,
        0,
        0,
    )


@each_adapter
@pytest.mark.parametrize("end", list(StreamEnd))
@pytest.mark.parametrize("seed", range(3))
def test_a_stream_loses_nothing_and_ends(seed, adapter, end):
    unit = stalling(seed, adapter, stream_end=end)
    tester = unit.connected()
    for count in range(1, 13):
        with tester.stream(c.StreamCyclic(EVERYTHING)) as stream:
            for _ in range(count):
                assert next(stream).data == tuple(DATA.values())
        right(tester)
    assert tester.statistics.failed == 0


@each_adapter
@pytest.mark.parametrize("seed", range(5))
def test_a_cut_response_costs_a_second(seed, adapter):
    unit = stalling(seed, adapter)
    tester = unit.connected()
    for count in range(1, 11):
        began = unit.link.now()
        unit.fault_injector.next(LineFault.CUT)
        right(tester, 16)
        assert tester.statistics.failed == count
        assert unit.link.now() - began < 2.0


class BusyComputer(LinkWrapper):
    """Holds the program for `held` seconds between its look at the clock and the next write."""

    def __init__(self, link):
        super().__init__(link)
        self.held = 0.0

    def write(self, data):
        self.link.gather(self.now() + self.held)
        self.held = 0.0
        super().write(data)


@each_adapter
@pytest.mark.parametrize("seconds", [0.1, 0.49, 0.51, 0.8, 1.3, 5.0])
def test_a_write_that_a_busy_computer_holds_back_is_answered(seconds, adapter):
    unit = Watched(adapter=adapter)
    link = BusyComputer(unit.link)
    tester = unit.connected(link)
    for request in (c.ReadParameters(EVERYTHING), c.Availability(), c.ReadFaults()):
        link.held = seconds
        tester.request(request)
        right(tester)
    assert (tester.statistics.failed, tester.sync.found_again) == (0, 0)


@each_adapter
@pytest.mark.parametrize("seconds", [0.6, 1.2, 3.0])
def test_the_handshake_waits_for_what_a_busy_computer_sent_late(seconds, adapter):
    unit = Watched(adapter=adapter)
    link = BusyComputer(unit.link)
    link.held = seconds
    assert unit.connected(link).statistics.failed == 0
