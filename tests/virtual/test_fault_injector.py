"""Each line fault on the wire: by request, by chance, and repeatable by its seed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import UsageError
from mikas.framing import Damage, Decoder, Frame, encode
from mikas.virtual.fault_injector import LATE_BY, FaultInjector, LineFault, parse_rates
from virtual_harness import DATA, make_bus

from .raw_tester import BYTE, TURN, RawTester

GOOD = encode(DATA[0x3F])
ASK = b"\x61\x3f"


def struck(line_fault: LineFault, seed: int = 0) -> RawTester:
    fault_injector = FaultInjector(seed=seed)
    fault_injector.next(line_fault, None)
    return RawTester(make_bus(fault_injector=fault_injector))


@pytest.mark.parametrize("line_fault", LineFault)
def test_one_response_is_struck_and_the_next_one_is_not(line_fault):
    tester = struck(line_fault)
    first = tester.ask(ASK)
    assert first != GOOD or line_fault is LineFault.ECHO
    tester.listen(2.0)
    if line_fault is LineFault.ECHO:
        tester.say(encode(ASK))
        spoilt = bytes([0x61 ^ 0x10]) + encode(ASK)[1:]
        assert tester.listen(tester.now + 0.5) == spoilt + GOOD
    assert tester.ask(ASK) == GOOD
    assert tester.bus.fault_injector.count == 1


def test_a_lost_response_is_silence():
    assert struck(LineFault.LOST).ask(ASK) == b""


def test_a_late_response_comes_whole():
    tester = struck(LineFault.LATE)
    tester.say(encode(ASK))
    tester.listen(3.0)
    assert tester.data == encode(ASK) + GOOD
    assert tester.times[4] == pytest.approx(4 * BYTE + TURN + LATE_BY + BYTE)
    assert LATE_BY > 0.5  # D14


@given(seed=st.integers(0, 10_000))
def test_damaged_is_one_bit(seed):
    came = struck(LineFault.DAMAGED, seed).ask(ASK)
    assert len(came) == len(GOOD)
    assert sum((a ^ b).bit_count() for a, b in zip(came, GOOD, strict=True)) == 1
    assert not any(isinstance(event, Frame) for event in Decoder().feed(came))


@given(seed=st.integers(0, 10_000))
def test_cut_has_a_begin_and_no_end(seed):
    came = struck(LineFault.CUT, seed).ask(ASK)
    assert came
    assert GOOD.startswith(came)
    assert came != GOOD


@given(seed=st.integers(0, 10_000))
def test_a_missing_byte_is_one_of_the_response(seed):
    came = struck(LineFault.MISSING_BYTE, seed).ask(ASK)
    assert came in [GOOD[:n] + GOOD[n + 1 :] for n in range(len(GOOD))]


def test_a_doubled_response_comes_twice():
    assert struck(LineFault.DOUBLED).ask(ASK) == GOOD * 2


def test_foreign_is_a_valid_frame_of_another_length():
    (event,) = Decoder().feed(struck(LineFault.FOREIGN).ask(ASK))
    assert isinstance(event, Frame)
    assert len(event.body) > len(DATA[0x3F])


@given(seed=st.integers(0, 10_000))
def test_noise_precedes_the_response(seed):
    came = struck(LineFault.NOISE, seed).ask(ASK)
    assert came.endswith(GOOD)
    assert 1 <= len(came) - len(GOOD) <= 4


def test_queued_faults_are_applied_in_order_before_any_chance():
    fault_injector = FaultInjector({LineFault.LOST: 1.0})
    fault_injector.next(None, LineFault.DOUBLED)
    tester = RawTester(make_bus(fault_injector=fault_injector))
    assert [tester.ask(ASK) for _ in range(3)] == [GOOD, GOOD * 2, b""]


def outcome(rates: dict[LineFault, float], seed: int, asks: int = 200) -> bytes:
    tester = RawTester(make_bus(fault_injector=FaultInjector(rates, seed=seed)))
    for number in range(asks):
        tester.say(encode(ASK), at=number * 1.5)
    tester.listen(asks * 1.5)
    return tester.data


def test_the_same_seed_strikes_the_same():
    rates = dict.fromkeys(LineFault, 0.05)
    assert outcome(rates, 1) == outcome(rates, 1)
    assert outcome(rates, 1) != outcome(rates, 2)


@pytest.mark.parametrize("rate", [0.0, 0.1, 0.5, 1.0])
def test_a_rate_is_the_share_that_is_struck(rate):
    fault_injector = FaultInjector({LineFault.LOST: rate}, seed=3)
    for _ in range(2000):
        fault_injector.respond(GOOD)
    assert fault_injector.count == pytest.approx(2000 * rate, abs=100 if 0 < rate < 1 else 0)


@pytest.mark.parametrize("line_fault", [LineFault.DOUBLED, LineFault.LATE])
def test_a_stream_with_line_faults_leaves_no_backlog_on_the_wire(line_fault):
    """What is made late or doubled holds the next response back; it does not pile up."""
    tester = RawTester(make_bus(fault_injector=FaultInjector({line_fault: 1.0})))
    tester.say(encode(b"\x71\x1a\x29"))
    tester.listen(20.0)
    assert len(tester.heard) > 20
    tester.say(b"\xff")
    tester.listen(20.0 + LATE_BY + 0.1)
    assert tester.listen(60.0) == b""


def test_a_late_response_and_the_next_one_do_not_mix():
    fault_injector = FaultInjector()
    fault_injector.next(LineFault.LATE)
    tester = RawTester(make_bus(fault_injector=fault_injector))
    tester.say(encode(ASK))
    tester.say(b"\x01\xff\x0d", at=LATE_BY)  # its response is due while the late one comes
    tester.listen(3.0)
    events = Decoder().feed(tester.data[7:])
    assert [e.body for e in events if isinstance(e, Frame)] == [DATA[0x3F], b"\x0a"]
    assert not [e for e in events if isinstance(e, Damage)]


# Rates as text


def test_rates_are_read_from_text():
    assert parse_rates({"damaged": "0.01", "missing-byte": "1", "lost": "0"}) == {
        LineFault.DAMAGED: 0.01,
        LineFault.MISSING_BYTE: 1.0,
        LineFault.LOST: 0.0,
    }


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("damaged", "1.1"),
        ("damaged", "-0.1"),
        ("damaged", "nan"),
        ("lost", "often"),
        ("rain", "0.1"),
    ],
)
def test_a_rate_that_makes_no_sense_is_refused(name, value):
    with pytest.raises(UsageError) as caught:
        parse_rates({name: value})
    for language in (caught.value.text.en, caught.value.text.ru):
        assert f"{name}={value}" in language
        assert "missing-byte" in language
