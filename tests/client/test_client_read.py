"""`read`: every code once, in order, as `Reading`s; what the unit refuses, and a true 01 (D10)."""

from __future__ import annotations

import dataclasses

import pytest
from client_harness import bench, ecu_on
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import (
    DamagedResponse,
    LineError,
    NoConnection,
    NotSupported,
    UnknownParameter,
    UsageError,
    WrongLength,
)
from mikas.virtual.fault_injector import LineFault
from protocol_codes import NAMES
from virtual_harness import DATA


def without(*codes):
    return {code: raw for code, raw in DATA.items() if code not in codes}


def test_all_of_the_catalog_in_one_request_and_in_its_order():
    it = bench()
    readings = ecu_on(it).read()
    assert tuple(readings) == NAMES
    assert [len(body) for body in it.requests()] == [1 + 21]  # 21 codes for 23 names, §5
    for name, reading in readings.items():
        assert reading.name == name
        assert reading.raw == DATA[reading.parameter.code]


def test_named_parameters_come_in_the_order_of_the_request():
    it = bench()
    assert list(ecu_on(it).read("FREQ", "twat", "INJ")) == ["FREQ", "TWAT", "INJ"]
    assert it.requests() == [bytes([0x61, 0x29, 0x1A, 0x3F])]


def test_flags_of_one_byte_are_requested_once():
    it = bench()
    readings = ecu_on(it).read("RXX", "BITPOW", "RDET")
    assert it.requests() == [b"\x61\x07"]
    assert [type(r.value) for r in readings.values()] == [bool] * 3
    assert len({(r.raw, r.time) for r in readings.values()}) == 1


def test_raw_codes_are_read_as_numbers():
    it = bench(DATA | {0x99: b"\x2a"})
    readings = ecu_on(it).read("0x1a", "0x3F", "0x3F:2", "0x99")
    assert {name: (r.value, r.unit) for name, r in readings.items()} == {
        "0x1A": (DATA[0x1A][0], ""),
        "0x3F": (int.from_bytes(DATA[0x3F], "little"), ""),
        "0x3F:2": (int.from_bytes(DATA[0x3F], "little"), ""),
        "0x99": (42, ""),
    }
    assert it.requests(0x61)[0] == bytes([0x61, 0x1A, 0x3F, 0x99])


def test_a_reading_says_all_of_itself():
    it = bench({0x1A: b"\x82"})
    ecu = ecu_on(it)
    before = ecu.tester.link.now()
    reading = ecu.read("TWAT")["TWAT"]
    assert (reading.value, reading.unit, reading.raw) == (90, "°C", b"\x82")
    assert reading.interpretation == "corrected"
    assert str(reading) == "TWAT 90 °C"
    assert repr(reading) == f"<Reading TWAT 90 °C: raw 82, {reading.time:.3f} s>"
    # 61 1A 85 0D takes 4 bytes, the unit turns round in 2 ms, then the response begins.
    assert reading.time == pytest.approx(before + 4 / 960 + 0.002, abs=1e-6)
    with pytest.raises(dataclasses.FrozenInstanceError):
        reading.value = 91


def test_a_flag_is_shown_as_yes_or_no():
    ecu = ecu_on(bench({0x08: b"\x40", 0x07: b"\x00"}))
    assert [str(r) for r in ecu.read("DET", "RXX").values()] == ["DET yes", "RXX no"]


@pytest.mark.parametrize(
    ("interpretation", "uacc", "rcok", "taken"),
    [
        ("corrected", 14.2, -0.5, ("corrected", "corrected")),
        ("literal", -11.4, -0.5, ("literal", "literal")),
        ("alternative", 14.2, 0.0, ("corrected", "alternative")),
        ("family", 14.2, 1.0, ("corrected", "family")),
    ],
)
def test_the_interpretation_decides_sense_and_unit(interpretation, uacc, rcok, taken):
    ecu = ecu_on(bench({0x1E: b"\x8e", 0x42: b"\x80"}), interpretation=interpretation)
    readings = ecu.read("UACC", "RCOK")
    assert readings["UACC"].value == pytest.approx(uacc)
    assert readings["RCOK"].value == rcok
    assert (
        tuple(r.interpretation for r in readings.values()) == taken
    )  # what was done, not what was asked


def test_an_unknown_interpretation_is_refused_with_those_there_are():
    with pytest.raises(UsageError, match="corrected, literal, alternative, family"):
        ecu_on(bench(), interpretation="both")


def test_a_misspelt_name_is_answered_with_the_nearest_and_nothing_is_sent():
    it = bench()
    ecu = ecu_on(it)
    with pytest.raises(UnknownParameter) as caught:
        ecu.read("FREQ", "TWATT")
    assert "TWAT" in caught.value.suggestions
    assert it.requests() == []


def test_a_list_of_names_in_place_of_names_is_explained():
    it = bench()
    with pytest.raises(UsageError, match="one by one"):
        ecu_on(it).read(["TWAT", "FREQ"])
    assert it.requests() == []


def test_one_code_with_two_sizes_is_refused():
    it = bench()
    with pytest.raises(UsageError, match="0x3F"):
        ecu_on(it).read("0x3F:1", "0x3F:3")  # together as long as twice the datum
    assert it.requests() == []


@pytest.mark.parametrize("unknown", ["silent", "01"])
class TestAParameterThatTheUnitRefuses:
    def test_reading_all_leaves_it_out_and_remembers(self, unknown):
        it = bench(without(0x42, 0x72), unknown=unknown)
        ecu = ecu_on(it)
        expected = [n for n in NAMES if n not in ("RCOK", "MINERR")]
        assert list(ecu.read()) == expected
        assert sorted(ecu.info().limits.refused) == [0x42, 0x72]
        assert ecu.info().limits.max_list == 64  # no length was to blame
        it.forget()
        assert list(ecu.read()) == expected
        assert len(it.requests(0x61)) == 1

    def test_reading_it_by_name_is_an_error_that_names_it(self, unknown):
        it = bench(without(0x42), unknown=unknown)
        ecu = ecu_on(it)
        with pytest.raises(NotSupported, match="RCOK") as caught:
            ecu.read("TWAT", "RCOK")
        assert "RCOK" in caught.value.text.ru

    def test_as_the_first_question_of_all_it_is_the_one_to_blame(self, unknown):
        it = bench(without(0x42), unknown=unknown)
        ecu = ecu_on(it)
        with pytest.raises(NotSupported, match="RCOK"):
            ecu.read("RCOK")
        assert ecu.info().limits.refused == [0x42]

    def test_a_named_parameter_is_requested_again_and_found(self, unknown, tmp_path):
        it = bench(without(0x42), unknown=unknown)
        ecu = ecu_on(it, state=tmp_path)
        assert "RCOK" not in ecu.read()
        it.car.__init__(DATA)  # it was no refusal for ever
        assert ecu.read("RCOK")["RCOK"].raw == DATA[0x42]
        assert "RCOK" in ecu.read()
        assert "RCOK" in ecu_on(it, state=tmp_path).read()

    def test_a_parameter_of_two_bytes_is_refused_as_well(self, unknown):
        it = bench(without(0x3F), unknown=unknown)
        ecu = ecu_on(it)
        with pytest.raises(NotSupported):
            ecu.read("INJ")

    def test_a_unit_without_61_says_so_and_learns_nothing(self, unknown):
        it = bench(missing="61", unknown=unknown)
        ecu = ecu_on(it)
        with pytest.raises(NotSupported):
            ecu.read()
        with pytest.raises(NotSupported):
            ecu.read("TWAT")
        assert not ecu.info().limits.learnt
        assert len(it.requests(0x61)) < 24  # it does not try all codes one by one

    def test_a_true_01_is_a_value(self, unknown):
        it = bench(DATA | {0x20: b"\x01"}, unknown=unknown)
        ecu = ecu_on(it)
        for _ in range(2):
            assert ecu.read("THR")["THR"].value == 1
        assert not ecu.info().limits.learnt

    @pytest.mark.parametrize("long_list", ["silent", "short"])
    def test_a_true_01_is_a_value_also_of_a_unit_that_takes_one_at_a_time(self, unknown, long_list):
        it = bench(DATA | {0x20: b"\x02"}, unknown=unknown, max_list=1, long_list=long_list)
        ecu = ecu_on(it)
        assert ecu.read("THR", "FREQ")["THR"].value == 2
        it.car.data[0x20] = b"\x01"
        if (long_list, unknown) == ("silent", "silent"):  # then 01 is no refusal
            assert ecu.read("THR")["THR"].value == 1
        else:  # it has answered before, but may refuse now: there is no telling
            with pytest.raises(NotSupported):
                ecu.read("THR")
        assert ecu.info().limits.refused == []
        it.car.data[0x20] = b"\x03"
        assert ecu.read("THR")["THR"].value == 3

    def test_an_ambiguous_01_is_neither_a_value_nor_a_refusal(self, unknown):
        it = bench(DATA | {0x20: b"\x01"}, unknown=unknown, max_list=1, long_list="silent")
        ecu = ecu_on(it)
        if unknown == "silent":  # then 01 is no refusal
            assert ecu.read("THR")["THR"].value == 1
        else:
            with pytest.raises(NotSupported):
                ecu.read("THR")
        assert ecu.info().limits.refused == []  # and it is not held against it


def test_when_every_code_is_refused_it_is_an_error_and_not_an_empty_result():
    it = bench({0x29: b"\x10"})
    ecu = ecu_on(it)
    assert list(ecu.read()) == ["FREQ"]
    it.car.__init__({0x99: b"\x01"})
    ecu.limits_cache.limits().refused.append(0x29)
    with pytest.raises(NotSupported):
        ecu.read()


def test_another_size_than_requested_is_no_refusal():
    it = bench()
    ecu = ecu_on(it)
    ecu.read("TWAT")
    with pytest.raises(WrongLength):
        ecu.read("0x1A:2")
    assert not ecu.info().limits.learnt


@pytest.mark.parametrize(
    "line_fault", [LineFault.LOST, LineFault.DAMAGED, LineFault.CUT, LineFault.LATE]
)
def test_a_damaged_response_is_requested_again(line_fault):
    it = bench()
    ecu = ecu_on(it)
    it.next_faults(line_fault)
    assert len(ecu.read()) == 23
    assert len(it.requests(0x61)) == 2
    assert not ecu.info().limits.learnt


def test_damage_that_goes_on_is_an_error():
    it = bench()
    ecu = ecu_on(it, retries=1)
    it.next_faults(
        LineFault.DAMAGED, None, LineFault.DAMAGED
    )  # between them the step is found again
    with pytest.raises(DamagedResponse) as caught:
        ecu.read("TWAT")
    assert caught.value.request == bytes.fromhex("611a850d")
    assert caught.value.received


@given(
    st.lists(st.sampled_from([None, *LineFault]), min_size=1, max_size=30),
    st.sampled_from(["silent", "01"]),
)
def test_whatever_happens_on_the_line_no_wrong_value_comes_out(line_faults, unknown):
    data = without(0x42) | {0x20: b"\x01"}
    it = bench(data, unknown=unknown)
    ecu = ecu_on(it)
    it.next_faults(*line_faults)
    for names in ((), ("THR",), ("TWAT", "INJ"), ("RCOK",)):
        try:
            readings = ecu.read(*names)
        except (LineError, NoConnection, NotSupported):
            continue
        assert {r.parameter.code: r.raw for r in readings.values()}.items() <= data.items()
