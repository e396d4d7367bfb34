"""What the tester counts: requests, failures, resynchronizations; what silence counts as (D10)."""

from __future__ import annotations

import pytest
from tester_rig import DATA, Fate, Watched, read, right

from mikas import commands as c
from mikas.errors import NoResponse, NotSupported
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.quirks import GROUPS, Unknown


def test_only_the_latest_failures_are_kept_and_all_are_counted():
    unit = Watched()
    tester = unit.connected(retries=0, pause=0.0)  # every request is counted
    right(tester, 22)
    for code in (17, 22):
        unit.bus.fault_injector = Fate([(LineFault.LOST, 0), (None, 0)] * 30)
        for _ in range(15):
            with pytest.raises(NoResponse):
                tester.request(read(code))
    assert (tester.statistics.requests, tester.statistics.failed) == (31, 30)
    kept = [failure.request[1] for failure in tester.statistics.failures]
    assert kept == [17] * 5 + [22] * 15


def test_what_is_sent_raw_and_a_stream_are_requests_too():
    tester = Watched().connected()
    assert tester.raw(b"\x61\x16") == DATA[22]
    assert tester.statistics.requests == 1
    with tester.stream(c.StreamCyclic((c.Datum(22, 1), c.Datum(67, 2)))) as stream:
        next(stream)
    assert tester.statistics.requests == 2
    right(tester, 22)
    assert tester.statistics.requests == 3


def test_an_answer_to_what_was_sent_raw_needs_no_confirmation():
    unit = Watched()
    tester = unit.connected()
    heard = unit.heard(b"\x01")
    assert tester.raw(b"\x61\x16") == DATA[22]
    right(tester, 22)
    assert (unit.heard(b"\x01"), tester.sync.found_again) == (heard, 0)


def test_a_failed_handshake_is_a_failure():
    unit = Watched(fault_injector=Fate([(LineFault.ECHO, 0)]))
    tester = unit.connected()
    assert [failure.code for failure in tester.statistics.failures] == ["EchoDiffers"]


def test_a_lost_response_before_a_refusal_is_a_failure():
    """The unit knows how to refuse, so silence was no refusal."""
    unit = Watched(missing=GROUPS["passports"], unknown=Unknown.ERROR)
    tester = unit.connected()
    unit.bus.fault_injector = Fate([(LineFault.LOST, 0)])
    with pytest.raises(NotSupported):
        tester.request(c.ReadProgramPassport(1))
    assert [failure.code for failure in tester.statistics.failures] == ["NoResponse"]


def test_a_unit_that_is_silent_to_01_is_not_one_that_does_not_know_it():
    unit = Watched()
    tester = unit.connected(retries=0)
    assert tester.has_answered(0x01)
    unit.bus.fault_injector = Fate([(LineFault.LOST, 0)])
    with pytest.raises(NoResponse):
        tester.request(c.Availability())


def test_values_asked_for_in_a_row_come_in_their_order():
    tester = Watched().connected()
    assert tester.in_a_row(read(17), read(67), read(16)) == [(DATA[17],), (DATA[67],), (DATA[16],)]
