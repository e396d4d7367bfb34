"""Which codes a unit answers to 61, however it refuses, and whatever the line does (D10)."""

from __future__ import annotations

from contextlib import suppress

import pytest
from client_harness import bench, ecu_on
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.client import Answer, ScannedCode
from mikas.client.scanning import Scan
from mikas.errors import LineError, NoConnection
from mikas.virtual.fault_injector import FaultInjector, LineFault
from virtual_harness import DATA

ODD = {
    0x00: b"\x01",
    0x0D: b"\x0d",
    0x33: b"\xf3",  # its checksum is 0D (D3)
    0x40: b"\x40\x0d",
    0x77: b"\x01\x01",
    0x80: b"\x01",
    0x90: bytes(range(16)),
    0xFF: b"\xc0",  # its checksum is 40 (D3)
}


def scanned(it, **settings) -> dict[int, ScannedCode]:
    with ecu_on(it, **settings) as ecu:
        return {found.code: found for found in ecu.scan()}


def pairs(it) -> list[bytes]:
    return [body for body in it.requests(0x61) if len(body) > 2]


def data_of(found: dict[int, ScannedCode]) -> dict[int, bytes]:
    return {code: each.raw for code, each in found.items() if each.answer is Answer.DATUM}


@pytest.mark.parametrize("data", [DATA, ODD, DATA | ODD], ids=["known", "odd", "both"])
@pytest.mark.parametrize("raw_checksum", [0, 1])
@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_every_datum_with_its_size_and_nothing_else(data, raw_checksum, unknown):
    found = scanned(bench(data, unknown=unknown, raw_checksum=raw_checksum))
    assert sorted(found) == list(range(0x100))
    assert data_of(found) == data
    other = Answer.SILENT if unknown == "silent" else Answer.REFUSED
    assert {each.answer for code, each in found.items() if code not in data} == {other}
    assert all(each.size == len(data[code]) for code, each in found.items() if code in data)


@pytest.mark.parametrize("long_list", ["silent", "short"])
@pytest.mark.parametrize("data", [DATA, ODD, {0x55: b"\x01"}], ids=["known", "odd", "one"])
def test_a_unit_that_takes_one_code_a_request_is_scanned(data, long_list):
    assert data_of(scanned(bench(data, max_list=1, long_list=long_list))) == data


@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_a_second_scan_asks_once_for_what_is_01_again_and_finds_the_same(unknown):
    found, requests = [], []
    for once in (False, True):
        it = bench(ODD, max_list=1, unknown=unknown)
        with ecu_on(it) as ecu:
            scan = Scan(ecu.tester, once=once)
            found.append({each.code: (each.answer, each.raw) for each in scan.codes()})
        requests.append(len(it.requests(0x61)))
    assert found[0] == found[1]
    most = 0.6 if unknown == "01" else 1.0
    assert requests[1] <= most * requests[0]


def test_one_code_a_request_and_01_for_the_others_leaves_01_unclear():
    it = bench(ODD, max_list=1, unknown="01")
    found = scanned(it)
    assert len(pairs(it)) < 150  # none once that is known
    ones = {code for code, raw in ODD.items() if raw == b"\x01"}
    assert data_of(found) == {code: raw for code, raw in ODD.items() if code not in ones}
    assert {each.answer for code, each in found.items() if code not in data_of(found)} == {
        Answer.UNCLEAR
    }


class _Rewritten:
    """A responder whose answers to 61 pass through `rule(codes, answer)`."""

    def __init__(self, responder, rule):
        self._responder, self._rule = responder, rule

    def __getattr__(self, name):
        return getattr(self._responder, name)

    def answer(self, body, now):
        answer = self._responder.answer(body, now)
        return self._rule(body[1:], answer) if body[:1] == b"\x61" else answer


def rewritten(it, rule):
    it.bus.ecu.responder = _Rewritten(it.bus.ecu.responder, rule)
    return it


@pytest.mark.parametrize("alone", [None, b"\x01"])
def test_a_unit_that_answers_several_codes_only_is_scanned(alone):
    it = bench(DATA | ODD, unknown="silent" if alone is None else "01")
    rewritten(it, lambda codes, answer: alone if len(codes) == 1 else answer)
    assert data_of(scanned(it)) == DATA | ODD


def in_turn(asked: bytes, *answers):
    """A rule that gives these answers to the first requests for `asked`; then the unit's own."""
    left = list(answers)
    return lambda codes, answer: left.pop(0) if codes == asked and left else answer


def test_a_stray_00_before_a_refusal_is_no_datum():
    it = rewritten(bench(DATA, unknown="01"), in_turn(b"\x87\x87", b"\x00\x01"))
    assert scanned(it)[0x87].answer is Answer.REFUSED


def test_a_lost_pair_is_no_unit_that_takes_one_code():
    it = rewritten(bench(DATA | ODD, unknown="01"), in_turn(b"\x29\x29", None, None))
    assert data_of(scanned(it)) == DATA | ODD


def test_a_lost_lone_code_is_no_unit_that_needs_several():
    """Its answer to three codes is not three times as long."""
    it = bench({0x3F: b"\x12\x34"}, max_list=1, long_list="short")
    assert data_of(scanned(rewritten(it, in_turn(b"\x3f", None, None)))) == {0x3F: b"\x12\x34"}


def test_a_second_reading_of_01_leaves_the_first():
    it = rewritten(bench(ODD, unknown="01", max_list=1), in_turn(b"\x33", b"\x05", b"\x01"))
    assert scanned(it)[0x33].raw == b"\x05"


def test_two_lost_confirmations_do_not_end_it():
    it = bench({})
    with ecu_on(it) as ecu:
        it.next_faults(LineFault.LOST, LineFault.LOST)  # of D13's 01, behind the first silence
        assert {each.answer for each in ecu.scan()} == {Answer.SILENT}


def test_an_empty_response_is_no_datum():
    it = rewritten(bench(ODD), lambda codes, answer: b"" if answer is None else answer)
    assert data_of(scanned(it)) == ODD


def test_a_unit_without_61_has_no_code():
    for unknown in ("silent", "01"):
        it = bench(missing="61", unknown=unknown)
        found = scanned(it)
        assert {each.answer for each in found.values()} <= {Answer.SILENT, Answer.REFUSED}
    it = bench(missing="61")
    scanned(it)
    assert len(pairs(it)) <= 2 * 8


def test_values_that_change_are_data_also_on_their_way_through_01():
    it = bench(ODD, max_list=1, unknown="01")
    counter = iter(range(10**6))

    def counting(codes, answer):
        return bytes([1 + next(counter) % 2]) if codes == b"\x80" else answer

    assert 0x80 in data_of(scanned(rewritten(it, counting)))


def test_only_61_is_sent_and_each_silent_code_twice():
    it = bench(DATA)
    found = scanned(it)
    silent = [code for code, each in found.items() if each.answer is Answer.SILENT]
    asked = it.requests(0x61)
    assert all(asked.count(bytes([0x61, code])) == 2 for code in silent)
    assert all(asked.count(bytes([0x61, code])) == 1 for code in DATA)
    assert {body[0] for body in it.requests()} == {0x61, 0x01}
    it.forget()
    scanned(it, retries=0)
    assert all(it.requests(0x61).count(bytes([0x61, code])) == 1 for code in silent)


def test_an_error_of_the_line_is_no_answer_and_is_cured_at_the_end():
    it = bench(DATA, unknown="01")
    with ecu_on(it, retries=0) as ecu:
        it.next_faults(LineFault.DAMAGED)
        found = list(ecu.scan())
    assert [each.answer for each in found if each.code == 0x29] == [Answer.UNCLEAR, Answer.DATUM]
    assert len(found) == 0x101


@settings(max_examples=5)
@given(st.integers(0, 10**6), st.sampled_from(["silent", "01"]), st.sampled_from([1, 255]))
def test_no_line_fault_makes_a_datum(seed, unknown, max_list):
    it = bench(DATA | ODD, unknown=unknown, max_list=max_list)
    with ecu_on(it) as ecu, suppress(LineError, NoConnection):
        rates = dict.fromkeys((f for f in LineFault if f is not LineFault.FOREIGN), 0.03)
        it.bus.fault_injector = FaultInjector(rates, seed=seed)
        for each in ecu.scan():
            if each.answer is Answer.DATUM:
                # A lost 00 behind an escape keeps the sum (§2.1): the value may differ.
                assert each.size == len((DATA | ODD).get(each.code, b"")), each


def test_ignition_off_ends_the_scan():
    it = bench(DATA)
    with ecu_on(it) as ecu:
        codes = ecu.scan()
        assert next(codes).answer is Answer.DATUM
        it.car.on = False
        with pytest.raises(NoConnection):
            list(codes)
