"""Each way in which a response can be wrong, the error for it, and what is sent again."""

from __future__ import annotations

import pytest
from tester_rig import (
    ADAPTERS,
    DATA,
    READS,
    Fate,
    Watched,
    adapter_name,
    answering,
    case,
    make,
    read,
    right,
)

from mikas import commands as c
from mikas.errors import (
    DamagedResponse,
    EchoDiffers,
    EchoOnly,
    EcuRefused,
    LineError,
    NoEcho,
    NoResponse,
    NotSupported,
    WriteRefused,
    WrongAddress,
    WrongContent,
    WrongLength,
)
from mikas.framing import encode
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.quirks import GROUPS, Unknown

WRITES = [
    c.WriteRamByte(0x20, 1),
    c.WriteXramByte(0x1234, 2),
    c.WriteCodeByte(0x400D, 3),
    c.WriteSfr(0x81, 4),
    c.WriteRamBlock(3, b"abc"),
    c.WriteXramBlock(3, b"abc"),
    c.WriteCodeBlock(3, b"abc"),
    c.WriteParameter(18, b"\x56"),
    c.WriteList((c.Datum(16, 1),)),
    *c.ERASE_FAULTS,
]
ERROR_OF = {
    LineFault.LOST: (NoResponse, EchoOnly, NoEcho),
    LineFault.LATE: (NoResponse, EchoOnly, NoEcho),
    LineFault.DAMAGED: LineError,
    LineFault.CUT: (DamagedResponse, NoResponse),
    LineFault.MISSING_BYTE: (DamagedResponse, WrongLength, NoResponse),
    LineFault.FOREIGN: (WrongLength, WrongAddress, WrongContent, DamagedResponse),
}
SURVIVED = {LineFault.DOUBLED, LineFault.NOISE, LineFault.ECHO}  # often without an error
assert ERROR_OF.keys() | SURVIVED == set(LineFault), "what must the tester report?"
by_name = {"ids": lambda command: command.name.en}
each_adapter = pytest.mark.parametrize("adapter", ADAPTERS, ids=adapter_name)


@each_adapter
@pytest.mark.parametrize("line_fault", list(LineFault))
def test_a_read_is_repeated_after_a_line_fault(line_fault, adapter):
    for command in READS:
        with case(command):
            unit = Watched(adapter=adapter)
            tester = unit.connected()
            truth = tester.request(command)
            for seed in range(3):
                unit.bus.fault_injector = Fate([(line_fault, 0.7)], seed)
                assert tester.request(command) == truth
                right(tester)


@each_adapter
@pytest.mark.parametrize("line_fault", ERROR_OF)
def test_without_retries_a_line_fault_is_its_error(line_fault, adapter):
    for command in READS:
        with case(command):
            unit = Watched(adapter=adapter)
            tester = unit.connected(retries=0)
            tester.request(command)
            tester.request(c.Availability())
            unit.bus.fault_injector = Fate([(line_fault, 0.7)])
            with pytest.raises(ERROR_OF[line_fault]) as caught:
                tester.request(command)
            assert caught.value.request == encode(command.body())
            assert caught.value.received is not None
            assert caught.value.time == pytest.approx(unit.link.now(), abs=1.2)
            right(tester)


@each_adapter
@pytest.mark.parametrize("line_fault", ERROR_OF)
def test_a_write_is_never_sent_twice(line_fault, adapter):
    for command in WRITES:
        with case(command):
            unit = Watched(adapter=adapter)
            tester = unit.connected()
            unit.bus.fault_injector = Fate([(line_fault, 0.7)])
            with pytest.raises((LineError, EcuRefused)):
                tester.request(command)
            assert unit.heard(command.body()) == 1
            assert tester.statistics.repeated == 0
            right(tester)
            assert unit.heard(command.body()) == 1


@pytest.mark.parametrize("command", WRITES, **by_name)
def test_a_write_whose_echo_differs_is_not_sent_twice(command):
    unit = Watched()
    tester = unit.connected()
    unit.bus.fault_injector.spoils_next_echo = True
    with pytest.raises(EchoDiffers):
        tester.request(command)
    right(tester)
    assert unit.heard(command.body()) == 1


@pytest.mark.parametrize("retries", [0, 1, 2, 5])
def test_a_read_is_repeated_as_often_as_set(retries):
    unit = Watched()
    tester = unit.connected(retries=retries, pause=0.0)  # every request is counted
    right(tester, 22)
    before, heard = tester.statistics.requests, unit.heard(b"\x61\x16")
    # Every second response: the confirmation in between is left alone.
    unit.bus.fault_injector = Fate([(LineFault.LOST, 0), (None, 0)] * 20)
    with pytest.raises(NoResponse):
        tester.request(read(22))
    assert unit.heard(b"\x61\x16") - heard == retries + 1
    assert tester.statistics.requests - before == retries + 1
    assert tester.statistics.repeated == retries
    assert tester.statistics.failed == retries + 1


def test_silence_to_what_a_unit_does_not_know_is_no_failure():
    unit = Watched(missing=GROUPS["count"])
    tester = unit.connected()
    with pytest.raises(NotSupported):
        tester.request(c.CountParameters())
    assert unit.heard(b"\x60") == 2
    assert tester.statistics.failed == 0
    assert not tester.statistics.failures


def test_a_response_that_was_lost_is_one_though_its_command_was_new():
    unit = Watched()
    tester = unit.connected()
    unit.bus.fault_injector = Fate([(LineFault.LOST, 0)])
    right(tester, 22)
    assert [failure.code for failure in tester.statistics.failures] == ["NoResponse"]


@pytest.mark.parametrize(("trial", "failed"), [(False, 2), (True, 0)])
def test_silence_to_a_list_that_may_be_too_long_is_no_failure(trial, failed):
    unit = Watched(max_list=1)
    tester = unit.connected()
    right(tester, 22)
    both = c.ReadParameters((c.Datum(22, len(DATA[22])), c.Datum(16, len(DATA[16]))))
    with pytest.raises(NoResponse):
        tester.exchange(both, retries=1, trial=trial)
    assert tester.statistics.failed == failed


def test_the_count_of_retries_can_be_given_for_one_exchange():
    unit = Watched()
    tester = unit.connected()
    right(tester, 22)
    unit.bus.fault_injector = Fate([(LineFault.LOST, 0)])
    with pytest.raises(NoResponse):
        tester.exchange(read(22), retries=0)
    value, reply = tester.exchange(read(22), retries=0)
    assert value == (DATA[22],)
    assert reply.body == DATA[22]
    assert reply.wire == encode(DATA[22])


@each_adapter
def test_a_replys_times_are_those_of_its_bytes(adapter):
    unit = Watched(adapter=adapter)
    tester = unit.connected()
    began = unit.link.now()
    _, reply = tester.exchange(read(22))
    out = began + 4 * unit.link.byte_time  # 61 16 checksum terminator
    assert reply.began == pytest.approx(out + 0.002, abs=adapter.latency + 1e-6)
    assert reply.ended == pytest.approx(
        reply.began + len(reply.wire) * unit.link.byte_time, abs=1e-6
    )
    assert reply.ended == pytest.approx(unit.link.now(), abs=1e-6)


# A far end that says just what a test wants


def error_of(request: bytes, answer: bytes, command: c.Command, **settings: object):
    tester = make(answering({request: answer}, **settings), retries=0)
    tester.connect()
    with pytest.raises(LineError) as caught:
        tester.request(command)
    assert caught.value.request == encode(request)
    assert tester.request(c.Availability()) == 0x0A
    assert tester.sync.found_again == 1
    return caught.value


@pytest.mark.parametrize("echo", [True, False])
@pytest.mark.parametrize("body", [b"", b"\x55\x55", b"\x0a\x0a", bytes(16)])
def test_another_length_is_never_accepted(body, echo):
    error = error_of(b"\x61\x16", encode(body), read(22), echo=echo)
    assert isinstance(error, WrongLength)
    assert error.received == encode(body)


@pytest.mark.parametrize(
    ("command", "body"),
    [
        (c.ReadRamByte(0x20), b"\x21\x00"),
        (c.ReadSfr(0x81), b"\x80\x00"),
        (c.ReadXramByte(0x1234), b"\x12\x34\x00"),  # high byte first
        (c.ReadCodeByte(0x1234), b"\x35\x12\x00"),
        (c.WriteRamByte(0x20, 7), b"\x21\x07"),
        (c.ReadRamBlock(0x20, 2), b"\x21\x02\x00\x00"),
        (c.ReadXramBlock(0x1234, 2), b"\x34\x13\x00\x00"),
        (c.ReadCodeBlock(0x1234, 2), b"\x12\x34\x02\x00\x00"),
    ],
)
def test_another_address_is_never_accepted(command, body):
    error = error_of(command.body(), encode(body), command)
    assert isinstance(error, WrongAddress)
    assert error.received == encode(body)


@pytest.mark.parametrize(
    ("command", "body"),
    [
        (c.ReadRamBlock(0x20, 2), b"\x20\x03\x00\x00"),
        (c.ReadFaults(), b"\x02\x0d\xe0\x0e\xe1"),
        (c.ReadFaults(), b"\x03\x0d\xe0\x0e\xe0"),
        (c.WriteParameter(22, b"\x01"), b"\x02"),
        (c.WriteRamBlock(3, b"ab"), b"\xff"),
    ],
)
def test_content_that_makes_no_sense_is_never_accepted(command, body):
    assert isinstance(error_of(command.body(), encode(body), command), (WrongContent, WrongLength))


@pytest.mark.parametrize("command", WRITES[4:], **by_name)
def test_a_refused_write_is_an_error_and_leaves_the_tester_in_sync(command):
    tester = make(answering({command.body(): encode(b"\x01")}))
    tester.connect()
    with pytest.raises(WriteRefused):
        tester.request(command)
    assert tester.request(c.Availability()) == 0x0A
    assert tester.sync.found_again == 0


@pytest.mark.parametrize(
    "answer",
    [
        b"\x55\xab\x0c",  # the terminator itself is damaged
        b"\x55\xab\x8d",
        b"\x55\xab",
        b"\x55",
        b"\x55\xaa\x0d",
        b"\x55\xab\x0d\x55\xab\x0d",  # twice
        b"\x55\xab\x0d\x00",
        bytes([0x55] * 5000),  # over 4096 and no end
        bytes([0x55] * 5000) + b"\x0d",
    ],
    ids=lambda a: f"{a[:8].hex()}-{len(a)}",
)
@pytest.mark.parametrize("echo", [True, False])
def test_a_damaged_frame_is_never_accepted(answer, echo):
    assert isinstance(error_of(b"\x61\x16", answer, read(22), echo=echo), DamagedResponse)


def test_an_irregular_escape_is_damage_to_a_strict_tester_only():
    wire = b"\x40\x15\xab\x0d"  # 40 + 15 = 55 by the sum rule, D4
    for strict in (False, True):
        tester = make(answering({b"\x61\x16": wire}), retries=0, strict=strict)
        tester.connect()
        if strict:
            with pytest.raises(DamagedResponse) as caught:
                tester.request(read(22))
            assert "escape" in str(caught.value)
        else:
            assert tester.request(read(22)) == (b"\x55",)


@pytest.mark.parametrize("datum", [b"\xc0", b"\xf3"])  # checksums 40 and 0D
def test_a_checksum_may_come_raw_or_stuffed(datum):
    for raw in (False, True):
        tester = make(answering({b"\x61\x16": encode(datum, raw_checksum=raw)}), retries=0)
        tester.connect()
        assert tester.request(read(22)) == (datum,)
        assert tester.sync.found_again == 0


# D10 and D9


@each_adapter
@pytest.mark.parametrize("unknown", list(Unknown))
@pytest.mark.parametrize(
    "command", [command for command in READS if command.code not in (1, 2, 0x60, 0x61)], **by_name
)
def test_an_unknown_command_is_not_supported_and_leaves_the_line_in_sync(command, unknown, adapter):
    missing = GROUPS["bytes"] | GROUPS["blocks"] | GROUPS["sfr"] | GROUPS["passports"]
    unit = Watched(adapter=adapter, missing=missing, unknown=unknown)
    tester = unit.connected()
    for _ in range(2):
        began = unit.link.now()
        with pytest.raises(NotSupported) as caught:
            tester.request(command)
        assert command.name.en in str(caught.value)
        assert caught.value.request == encode(command.body())
        assert caught.value.received == (encode(b"\x01") if unknown is Unknown.ERROR else b"")
        assert began < caught.value.time <= unit.link.now() < began + 2.5
        right(tester)
    assert unit.heard(command.body()) == (2 if unknown is Unknown.ERROR else 4)
    assert not tester.has_answered(command.code)


@pytest.mark.parametrize("unknown", list(Unknown))
def test_a_write_that_the_unit_does_not_know_is_sent_once(unknown):
    unit = Watched(missing=GROUPS["write"], unknown=unknown)
    tester = unit.connected()
    with pytest.raises(EcuRefused):
        tester.request(c.WriteParameter(22, b"\x01"))
    assert unit.heard(b"\x62\x16\x01") == 1
    right(tester)


@each_adapter
def test_silence_because_the_unit_is_gone_is_not_an_unknown_command(adapter):
    unit = Watched(adapter=adapter)
    tester = unit.connected()
    unit.car.on = False
    began = unit.link.now()
    with pytest.raises(EchoOnly if adapter.echo else NoEcho):
        tester.request(c.ReadProgramPassport(1))
    assert unit.link.now() - began < 5
    unit.car.on = True
    assert isinstance(tester.request(c.ReadProgramPassport(1)), str)


def test_once_a_command_was_answered_silence_is_no_refusal():
    unit = Watched()
    tester = unit.connected(pause=0.0)
    right(tester, 22)
    unit.bus.fault_injector = Fate([(LineFault.LOST, 0), (None, 0)] * 9)
    with pytest.raises(NoResponse):
        tester.request(read(22))
    assert tester.has_answered(0x61)


@each_adapter
def test_a_jump_has_no_answer_and_one_that_comes_is_shown(adapter):
    unit = Watched(adapter=adapter)
    tester = unit.connected()
    jump = c.GoTo(0x8000).body()
    assert tester.raw(jump) is None
    assert unit.heard(jump) == 1
    right(tester)
    answering_unit = make(answering({jump: encode(b"\x12\x34")}))
    answering_unit.connect()
    assert answering_unit.raw(jump) == b"\x12\x34"


@pytest.mark.parametrize("body", [b"", b"\x01", b"\x99", b"\x61\x16", b"\x71\x16", b"\x7f\x16"])
@each_adapter
def test_anything_may_be_sent_raw_and_the_next_value_is_right(body, adapter):
    unit = Watched(adapter=adapter)
    tester = unit.connected()
    answer = tester.raw(body)
    assert answer == {
        b"\x01": b"\x0a", b"\x61\x16": b"\x55", b"\x71\x16": b"\x55", b"\x7f\x16": b"\x55"
    }.get(body)  # fmt: skip
    right(tester)
    right(tester)


@pytest.mark.parametrize("line_fault", [LineFault.DAMAGED, LineFault.CUT, LineFault.MISSING_BYTE])
def test_a_damaged_raw_exchange_is_an_error_and_not_repeated(line_fault):
    unit = Watched()
    tester = unit.connected()
    unit.bus.fault_injector = Fate([(line_fault, 0)], seed=1)
    with pytest.raises(LineError):
        tester.raw(b"\x61\x16")
    assert unit.heard(b"\x61\x16") == 1
    right(tester)
