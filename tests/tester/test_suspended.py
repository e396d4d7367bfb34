"""A program that did not run trusts nothing that came meanwhile, and says so (D13)."""

from __future__ import annotations

import contextlib

import pytest
from tester_rig import ADAPTERS, DATA, READS, Watched, adapter_name, right

from mikas import commands as c
from mikas.errors import ReadingSuspended
from mikas.link.suspension import SuspensionGuard
from suspended import PLACES, ClockCar, StoppingLink, age

OLDEST = 0.6  # s; half a second, and the tenth in which the car gives the time
CODES = (0x1001, 0x1002)


def stopping(unit: Watched, *stops: tuple[float, float], where: str = "waiting"):
    link = StoppingLink(unit.bus, [], where)
    tester = unit.connected(SuspensionGuard(link))
    link.stops = [(link.now() + after, seconds) for after, seconds in stops]
    return tester, link


each_adapter = pytest.mark.parametrize("adapter", ADAPTERS, ids=adapter_name)


@each_adapter
@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("after", [0.0, 0.004, 0.02])
def test_an_exchange_that_was_suspended_gives_no_value_and_the_next_one_does(adapter, where, after):
    unit = Watched(adapter=adapter)
    tester, link = stopping(unit, (after, 30.0), where=where)
    seen = 0
    for _ in range(20):
        try:
            right(tester, 16)
        except ReadingSuspended as error:
            assert error.fields["seconds"] == pytest.approx(30, abs=0.2)
            assert not tester.sync.streaming
            seen += 1
    stood = not link.stops  # where nothing is gathered, it can't stop in that
    assert stood or where == "gathering"
    assert seen <= stood
    assert (tester.line.suspension is not None) is stood
    right(tester)


@pytest.mark.parametrize("command", READS, ids=lambda command: command.name.en)
def test_no_command_is_repeated_after_it(command):
    """Another unit may answer by then: whoever asked decides."""
    unit = Watched()
    tester, link = stopping(unit)
    tester.request(command)
    link.stops = [(link.now() + 0.004, 30.0)]
    heard = unit.heard(command.body())
    with pytest.raises(ReadingSuspended):
        tester.request(command)
    assert unit.heard(command.body()) == heard + 1
    assert tester.statistics.repeated == 0
    right(tester)


@pytest.mark.parametrize("command", READS[1:], ids=lambda command: command.name.en)
@pytest.mark.parametrize("seconds", [0.6, 0.9])
def test_a_busy_computer_costs_one_repetition(command, seconds):
    """No plug is moved in so short a time: a dump of half an hour does not end for it."""
    unit = Watched()
    tester, link = stopping(unit)
    expected = tester.request(command)
    link.stops = [(link.now() + 0.004, seconds)]
    heard = unit.heard(command.body())
    assert tester.request(command) == expected
    assert unit.heard(command.body()) == heard + 2
    assert tester.statistics.repeated == 1
    assert tester.line.suspension is None


def test_a_pause_of_the_caller_alone_costs_nothing():
    unit = Watched()
    tester, link = stopping(unit)
    for _ in range(5):
        link.pass_time(60.0)  # it sleeps between two requests, and the line is quiet
        before = link.now()
        right(tester, 16)
        assert link.now() - before < 0.05
    assert tester.sync.found_again == 0


@each_adapter
def test_a_stream_leaves_out_what_came_meanwhile(adapter):
    unit = Watched(adapter=adapter)
    clock = ClockCar(dict.fromkeys(range(64, 70), b"\x00\x00") | DATA)
    unit.ecu.responder.car = clock
    tester, link = stopping(unit, (0.5, 30.0), (40.0, 1.0))
    data = tuple(c.Datum(code, 2) for code in range(64, 69))
    ages, until = [], link.now() + 45
    with tester.stream(c.StreamCyclic(data)) as stream:
        while link.now() < until:
            item = next(stream)
            ages += [age(raw, item.time) for raw in item.data]
    assert len(ages) > 300
    assert -0.2 < min(ages) < max(ages) < OLDEST
    assert [each.code for each in tester.statistics.failures].count("ReadingSuspended") == 2
    unit.ecu.responder.car = unit.car
    right(tester)


@each_adapter
@pytest.mark.parametrize("after", [0.0, 0.1, 0.3, 0.55, 0.8])
def test_a_handshake_that_was_suspended_finds_the_unit(adapter, after):
    unit = Watched(adapter=adapter)
    link = StoppingLink(unit.bus, [(after, 30.0)])
    tester = unit.tester(SuspensionGuard(link))
    assert tester.connect() == 0x0A
    assert tester.line.echo is adapter.echo
    right(tester)


@each_adapter
def test_a_running_stream_ends_though_the_program_stops_while_ending_it(adapter):
    for after in (0.0, 0.02, 0.06, 0.2):
        unit = Watched(adapter=adapter)
        tester, link = stopping(unit)
        stream = tester.stream(c.StreamCyclic((c.Datum(16, 1), c.Datum(17, 1))))
        next(stream)
        link.stops = [(link.now() + after, 30.0)]
        with contextlib.suppress(ReadingSuspended):
            stream.close()
        right(tester)


def test_a_write_is_not_sent_when_the_program_stood_before_it():
    unit = Watched()
    tester, link = stopping(unit)
    right(tester)
    link.pass_time(30.0)
    with pytest.raises(ReadingSuspended):
        tester.line.send(b"\x62\x0e\x08")
    assert unit.heard(b"\x62\x0e\x08") == 0
