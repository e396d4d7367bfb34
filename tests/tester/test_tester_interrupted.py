"""Several threads, Ctrl-C, and an adapter that goes away: at any point."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import pytest
from tester_rig import DATA, Fate, StrikingLink, Watched, read, right

from mikas import commands as c
from mikas.errors import LinkLost, MikasError
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.quirks import StreamEnd

STREAMS = [
    c.StreamCyclic((c.Datum(22, 1), c.Datum(67, 2))),
    c.StreamAtStroke((c.Datum(16, 1),), 0),
]


def test_eight_threads_each_get_their_own_values():
    tester = Watched().connected()

    def ask(code: int) -> set[tuple[bytes, ...]]:
        return {tester.request(read(code)) for _ in range(40)}

    with ThreadPoolExecutor(8) as pool:
        codes = sorted(DATA)[:8]
        assert list(pool.map(ask, codes)) == [{(DATA[code],)} for code in codes]
    assert tester.statistics.requests == 320


def test_eight_threads_in_bad_weather_get_no_wrong_value():
    unit = Watched()
    tester = unit.connected()
    line_faults = [*LineFault, None, None, None] * 30
    unit.bus.fault_injector = Fate((line_fault, 0.6) for line_fault in line_faults)

    def ask(code: int) -> set[tuple[bytes, ...]]:
        got = set()
        for _ in range(20):
            with suppress(MikasError):
                got.add(tester.request(read(code)))
        return got

    with ThreadPoolExecutor(8) as pool:
        codes = sorted(DATA)[:8]
        for code, got in zip(codes, pool.map(ask, codes), strict=True):
            assert got <= {(DATA[code],)}


@pytest.mark.parametrize("command", STREAMS)
def test_other_threads_wait_until_a_stream_has_ended(command):
    unit = Watched()
    tester = unit.connected()
    got = []
    about_to = threading.Event()

    def ask() -> None:
        about_to.set()
        got.append(tester.request(read(17)))

    with tester.stream(command) as stream:
        other = threading.Thread(target=ask)
        other.start()
        about_to.wait()
        for _ in range(20):
            next(stream)
        assert other.is_alive()
        assert unit.heard(b"\x61\x11") == 0
    other.join()
    assert got == [(DATA[17],)]


def session(unit, link, command):
    """Connecting, reading through a lost response, a stream: all that touches the link."""
    play(unit, unit.tester(link), command)


def play(unit, tester, command):
    tester.connect()
    right(tester, 16)
    unit.fault_injector.next(LineFault.LOST)
    right(tester, 17)
    with tester.stream(command) as stream:
        for _ in range(3):
            next(stream)
    right(tester, 22)


def operations_of(end, command):
    unit = Watched(stream_end=end)
    link = StrikingLink(unit.bus, 0, lambda _: None)
    session(unit, link, command)
    return link.operations


def some_of(count):
    """Every point of a short session, about a hundred of a long one."""
    return range(1, count + 1, 1 + count // 100)


CASES = [(end, command) for end in StreamEnd for command in STREAMS]
each_case = pytest.mark.parametrize(
    ("end", "command"), CASES, ids=[f"{end.value}-{s.code:02X}" for end, s in CASES]
)


@each_case
def test_an_adapter_that_goes_away_at_any_point_is_reported(end, command):
    for at in some_of(operations_of(end, command)):
        unit = Watched(stream_end=end)
        link = StrikingLink(unit.bus, at, StrikingLink.unplug)
        with pytest.raises(LinkLost):
            session(unit, link, command)
        assert link.operations < at + 20  # no thread goes on trying


@each_case
def test_ctrl_c_at_any_point_leaves_it_usable(end, command):
    def strike(_link):
        raise KeyboardInterrupt

    for at in some_of(operations_of(end, command)):
        unit = Watched(stream_end=end)
        link = StrikingLink(unit.bus, at, strike)
        tester = unit.tester(link)
        try:
            play(unit, tester, command)
        except KeyboardInterrupt:
            pass
        else:
            raise AssertionError("no request was interrupted")
        if tester.version_code is None:
            tester.connect()
        unit.bus.fault_injector = Fate([(LineFault.LOST, 0)])
        right(tester)
        with tester.stream(STREAMS[0]) as stream:
            next(stream)
        right(tester)


def test_ctrl_c_while_a_late_answer_is_under_way_leaves_no_wrong_value():
    """Interrupted while waiting; the answer then comes just when another might be missed."""
    for late in (0.05, 0.2, 0.4, 0.6, 0.9):
        unit = Watched()
        link = StrikingLink(unit.bus, 0, lambda _: None)
        tester = unit.connected(link)
        unit.bus.fault_injector = Fate([(LineFault.LATE, late), (None, 0), (LineFault.LOST, 0)])

        def strike(_link):
            raise KeyboardInterrupt

        link.at, link.strike = link.operations + 6, strike
        with pytest.raises(KeyboardInterrupt):
            tester.request(read(16))
        right(tester, 22, 17)
