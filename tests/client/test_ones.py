"""01 is how some units refuse (D10), and what a datum may be as well: which of them it was."""

from __future__ import annotations

from contextlib import suppress

import pytest
from client_harness import bench, ecu_on
from hypothesis import example, given
from hypothesis import strategies as st

from mikas.client import Limits
from mikas.client.parameters.data import COMMON
from mikas.client.parameters.polling import Turn, create_poller
from mikas.errors import LineError, NoConnection, NotSupported
from mikas.virtual.fault_injector import LineFault
from virtual_harness import DATA

TWAT, TWICE = b"\x61\x1a", b"\x61\x1a\x1a"
GOOD = {code: raw for code, raw in DATA.items() if code not in {d.code for d in COMMON}}


def parameters(ecu, *names):
    return [ecu.catalog.parameter(name) for name in names]


def fetch(ecu, *names, method="single"):
    """One cycle, without a second request for what was refused."""
    poller = create_poller(ecu.parameters, method)
    return poller.cycle([Turn(ecu.parameters.wanted(parameters(ecu, *names)))])


def is_refused(ecu, *names):
    return ecu.parameters.refuses(parameters(ecu, *names))


@pytest.mark.parametrize("before", [b"\x7d", b"\x01"])
@pytest.mark.parametrize("method", ["single", "batch"])
def test_a_lone_code_that_is_refused_midway_is_no_value(before, method):
    it = bench(DATA | {0x1A: before}, unknown="01")
    ecu = ecu_on(it)
    ecu.read()
    assert ecu.read("TWAT")["TWAT"].raw == before
    del it.car.data[0x1A]
    for _ in range(3):
        with pytest.raises(NotSupported):
            fetch(ecu, "TWAT", method=method)


def test_a_datum_that_becomes_01_costs_one_request_more():
    it = bench(unknown="01")
    ecu = ecu_on(it)
    for raw, asked in (
        (b"\x7d", [TWAT]),
        (b"\x01", [TWAT, TWICE]),
        (b"\x01", [TWICE]),  # it may be refused any time
        (b"\x02", [TWICE]),
        (b"\x03", [TWAT]),
    ):
        it.car.data[0x1A] = raw
        it.forget()
        assert fetch(ecu, "TWAT")["TWAT"].raw == raw
        assert it.requests(0x61) == asked


def test_a_unit_that_takes_one_at_a_time_is_not_sent_two_again_and_again():
    """It answers 01 to a parameter that it lacks, which may as well be a datum."""
    without = {code: raw for code, raw in DATA.items() if code != 0x1A}
    for long_list in ("silent", "short"):
        it = bench(without, unknown="01", max_list=1, long_list=long_list)
        ecu = ecu_on(it)
        assert list(fetch(ecu, "FREQ", "TWAT")) == ["FREQ"]
        assert ecu.limits().max_list == 1
        assert ecu.limits().refused == []
        it.forget()
        for _ in range(9):
            assert not is_refused(ecu, "TWAT")
            assert list(fetch(ecu, "FREQ", "TWAT")) == ["FREQ"]
        assert it.requests(0x61) == [b"\x61\x29", TWAT] * 9
        assert is_refused(ecu, "TWAT")
        it.car.__init__(DATA)  # so it was no refusal for ever
        assert fetch(ecu, "TWAT")["TWAT"].raw == DATA[0x1A]
        assert not is_refused(ecu, "TWAT")


def test_a_bad_line_at_that_moment_is_no_limit():
    it = bench(unknown="01")
    ecu = ecu_on(it, retries=0)
    fetch(ecu, "THR")
    del it.car.data[0x1A]
    it.next_faults(None, None, LineFault.DAMAGED)  # 01, 01 again, and now: does it take two at all?
    with pytest.raises(LineError):
        fetch(ecu, "TWAT")
    assert not ecu.limits().learnt
    with pytest.raises(NotSupported):
        ecu.read("TWAT")
    assert ecu.limits() == Limits(refused=[0x1A])


@pytest.mark.parametrize("long_list", ["silent", "short"])
@pytest.mark.parametrize("unknown", ["silent", "01"])
class TestAUnitWithoutWhatIsCommon:
    """No parameter is promised to anybody, neither FREQ nor another."""

    def test_a_unit_without_the_common_parameters_knows_61_all_the_same(self, unknown, long_list):
        for lacking in (GOOD, {c: r for c, r in DATA.items() if c != 0x29}):
            it = bench(lacking, unknown=unknown, long_list=long_list, max_list=3)
            ecu = ecu_on(it)
            assert {r.parameter.code: r.raw for r in ecu.read().values()} == lacking
            assert sorted(ecu.limits().refused) == sorted(DATA.keys() - lacking.keys())
            assert ecu.limits().max_list == 3

    def test_named_ones_come_in_one_list_that_is_too_long(self, unknown, long_list):
        it = bench(GOOD, unknown=unknown, long_list=long_list, max_list=2)
        names = ("INJ", "THR", "UOZ", "JAIR", "UGB")
        assert list(ecu_on(it).read(*names)) == list(names)

    def test_a_true_01_is_distinguished_from_a_refusal(self, unknown, long_list):
        it = bench(GOOD | {0x20: b"\x01"}, unknown=unknown, long_list=long_list, max_list=2)
        ecu = ecu_on(it)
        assert ecu.read("THR")["THR"].value == 1
        with pytest.raises(NotSupported, match="TWAT"):
            ecu.read("TWAT")
        assert ecu.limits().refused == [0x1A]


@given(
    st.lists(st.sampled_from([None, None, *LineFault]), max_size=30),
    st.sampled_from([1, 2, 64]),
    st.sampled_from(["silent", "short"]),
    st.sampled_from([b"\x7d", b"\x01"]),
)
@example([LineFault.DOUBLED, None, LineFault.LOST, None, LineFault.LOST], 1, "silent", b"}")
@example([None, LineFault.LOST] * 3, 1, "silent", b"}")
@example([None, LineFault.LOST, LineFault.ECHO, None, None, LineFault.FOREIGN], 1, "silent", b"}")
def test_whatever_happens_on_the_line_a_refusal_is_no_value(line_faults, takes, long_list, before):
    it = bench(DATA | {0x1A: before}, unknown="01", max_list=takes, long_list=long_list)
    ecu = ecu_on(it)
    ecu.read()
    del it.car.data[0x1A]
    it.next_faults(*line_faults)
    for names in (("TWAT",), ("FREQ", "TWAT", "INJ"), ("TWAT", "THR")):
        for method in ("single", "batch"):
            with suppress(LineError, NoConnection, NotSupported):
                assert "TWAT" not in fetch(ecu, *names, method=method)
