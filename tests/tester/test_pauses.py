"""The pause that a unit needs between its response and the next request, found by trying (D14)."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas import commands as c
from mikas.errors import NoResponse, NotSupported
from mikas.tester.pauses import PAUSES
from mikas.virtual.bus import AdapterKind
from mikas.virtual.fault_injector import FaultInjector, LineFault
from mikas.virtual.quirks import EcuQuirks, Unknown
from virtual_harness import connected, make_bus, make_tester

READ = c.ReadParameters((c.Datum(0x1A, 1),))


def a_bus(least: float, *, adapter: AdapterKind | None = None, **quirks: object):
    return make_bus(quirks=EcuQuirks(least_pause=least, **quirks), adapter=adapter)


def ask(tester, times: int = 5) -> None:
    """Read in a row, as fast as the tester goes."""
    for _ in range(times):
        assert tester.request(READ)


@settings(max_examples=40, deadline=None)
@given(
    least=st.integers(1, 150),
    echo=st.booleans(),
    latency=st.sampled_from([0.0, 0.001]),
)
def test_the_shortest_pause_that_works_is_found(least, echo, latency):
    adapter = AdapterKind(echo=echo, latency=latency)
    tester = connected(a_bus(least / 1000, adapter=adapter))
    ask(tester)
    found = tester.line.pause
    # An adapter hands over the response later than its end, and so the pause may be shorter.
    assert found in (0.0, *PAUSES)
    assert found + latency + 0.0011 >= least / 1000
    shorter = [each for each in (0.0, *PAUSES) if each < found]
    assert not shorter or shorter[-1] <= least / 1000
    assert tester.pauses.found == (found or None)
    before = tester.statistics.failed
    ask(tester, 20)
    assert tester.statistics.failed == before


@pytest.mark.parametrize("least", [0.08, 0.15])
def test_a_unit_that_is_silent_already_in_the_handshake(least):
    """The second `01` follows after 60 ms of silence."""
    tester = make_tester(a_bus(least), retries=0)
    assert tester.connect() == 0x0A
    assert tester.line.pause == next(each for each in PAUSES if each >= least)
    ask(tester)


def test_a_unit_that_needs_no_pause_is_not_tried():
    bus = a_bus(0.0)
    tester = connected(bus)
    carried = bus.bytes_carried
    ask(tester, 10)
    assert bus.bytes_carried - carried == 10 * (4 + 3)
    assert (tester.line.pause, tester.pauses.found) == (0.0, None)


@pytest.mark.parametrize("unknown", Unknown)
def test_an_unknown_command_does_not_make_a_pause(unknown):
    tester = connected(make_bus(quirks=EcuQuirks(unknown=unknown, missing=frozenset({0x51}))))
    for _ in range(6):
        ask(tester, 1)
        with pytest.raises(NotSupported):
            tester.request(c.ReadProgramPassport(1))
    assert (tester.line.pause, tester.pauses.found) == (0.0, None)


def test_lost_responses_do_not_make_a_pause():
    bus = make_bus(fault_injector=FaultInjector({LineFault.LOST: 0.05}, seed=3))
    tester = connected(bus)
    for _ in range(300):
        tester.request(READ)
    assert tester.statistics.failed > 5
    assert tester.line.pause == 0.0


def test_a_pause_that_is_set_is_kept_and_nothing_is_tried():
    bus = a_bus(0.1)
    tester = connected(bus, pause=0.3)
    ask(tester)
    began = tester.link.now()
    ask(tester, 10)
    assert 10 * 0.3 <= tester.link.now() - began <= 10 * 0.32
    assert tester.pauses.found is None
    assert tester.statistics.failed == 0
    short = connected(a_bus(0.05), pause=0.01, retries=0)
    with pytest.raises(NoResponse):
        short.in_a_row(c.Availability(), c.Availability())
    assert short.line.pause == 0.01


def test_a_change_is_not_repeated_but_the_pause_is_found():
    tester = connected(a_bus(0.05))
    tester.request(c.Availability())
    write = c.WriteParameter(0x0E, b"\x08")
    assert not write.repeatable
    with pytest.raises(NoResponse):
        tester.request(write)
    assert tester.line.pause == 0.05
    assert tester.request(write) is None


def test_a_longer_pause_is_found_if_the_assumed_one_is_too_short():
    tester = connected(a_bus(0.1), pause=None)
    tester.pauses.restart()
    tester.pauses.assume(0.025)
    ask(tester)
    assert tester.line.pause == 0.1


def test_a_pause_longer_than_all_leaves_things_as_they_are():
    """It can be set."""
    tester = connected(a_bus(0.5), pause=0.5)
    ask(tester)
    tester.pauses.setting = None
    tester.pauses.restart()
    with pytest.raises(NoResponse):
        ask(tester)
    assert (tester.line.pause, tester.pauses.found) == (0.0, None)


def test_nothing_is_sent_ahead_where_a_pause_is_kept():
    bus = a_bus(0.1)
    tester = connected(bus)
    ask(tester)
    for _ in range(5):
        tester.announce(READ)
        tester.request(READ)
    tester.settle()
    assert tester.statistics.failed == 0


@pytest.mark.parametrize("stream_end", ["byte", "request", "break"])
def test_a_stream_runs_and_ends_as_without_a_pause(stream_end):
    quirks = EcuQuirks(least_pause=0.1).with_options({"stream_end": stream_end})
    tester = connected(make_bus(quirks=quirks))
    ask(tester)
    began = tester.link.now()
    with tester.stream(c.StreamCyclic((c.Datum(0x1A, 1), c.Datum(0x29, 1)))) as stream:
        times = [next(stream).time for _ in range(50)]
    assert times[-1] - times[0] < 50 * 0.01
    assert times[0] - began >= 0.1
    ask(tester)
    assert tester.line.pause == 0.1
