"""Memory: every space, byte and block, the largest blocks that the unit takes, writes read back."""

from __future__ import annotations

import pytest
from client_harness import bench, ecu_on, lines

from mikas.errors import (
    AddressOutOfRange,
    EcuRefused,
    NoResponse,
    NotConfirmed,
    NotSupported,
    ReadBackDiffers,
    UsageError,
    ValueDoesNotFit,
    WriteRefused,
)
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.memory import pattern

SPACES = {"ram": 0xFF, "xram": 0xFFFF, "code": 0xFFFF, "sfr": 0xFF}
BLOCKED = ["ram", "xram", "code"]
READS = {"ram": (0x11, 0x21), "xram": (0x13, 0x23), "code": (0x15, 0x25), "sfr": (0x31, None)}
WRITES = {"ram": (0x12, 0x22), "xram": (0x14, 0x24), "code": (0x16, 0x26), "sfr": (0x32, None)}


def yes(change):
    return True


@pytest.mark.parametrize("space", SPACES)
class TestEverySpace:
    def test_single_bytes_are_read(self, space):
        it = bench()
        memory = ecu_on(it).memory[space]
        assert (memory.name, memory.last) == (space, SPACES[space])
        for address in (0, 0x0D, 0x40, memory.last):
            assert memory.read(address) == pattern(space)[address]
        assert {body[0] for body in it.requests()} == {READS[space][0]}

    def test_a_whole_space_is_read_in_blocks(self, space):
        it = bench()
        memory = ecu_on(it).memory[space]
        count = min(memory.last + 1, 4000)
        assert memory.read_block(0, count) == pattern(space)[:count]
        if space != "sfr":
            assert len(it.requests(READS[space][1])) == (1 if space == "ram" else 16)
        end = memory.last + 1 - 100
        assert memory.read_block(end, 100) == pattern(space)[end:]

    def test_out_of_range_is_refused_before_anything_is_sent(self, space):
        it = bench()
        memory = ecu_on(it, confirm=yes).memory[space]
        past = memory.last + 1
        for call in (
            lambda: memory.read(-1),
            lambda: memory.read(past),
            lambda: memory.read_block(past, 1),
            lambda: memory.read_block(0, past + 1),
            lambda: memory.read_block(past - 1, 2),
            lambda: memory.read_block(0, 0),
            lambda: memory.read_block(0, -1),
            lambda: memory.blocks(past, 1),
            lambda: memory.write(-1, 0),
            lambda: memory.write(past, 0),
            lambda: memory.write_block(past - 1, b"ab"),
            lambda: memory.write_block(0, b""),
        ):
            with pytest.raises(AddressOutOfRange, match=space):
                call()
        assert it.requests() == []

    @pytest.mark.parametrize("value", [-1, 256])
    def test_a_value_that_is_no_byte_is_refused_before_anything_is_sent(self, space, value):
        it = bench()
        with pytest.raises(ValueDoesNotFit):
            ecu_on(it, confirm=yes).memory[space].write(0, value)
        assert it.requests() == []

    def test_a_byte_is_written_and_read_back(self, space, tmp_path):
        changes = []
        it = bench()
        ecu = ecu_on(it, confirm=lambda c: changes.append(c) or True, journal=tmp_path / "j")
        written = ecu.memory[space].write(0x40, 0x0D)
        before = pattern(space)[0x40]
        assert (written.space, written.address) == (space, 0x40)
        assert (written.before, written.after) == (bytes([before]), b"\x0d")
        assert [body[0] for body in it.requests()] == [
            READS[space][0],
            WRITES[space][0],
            READS[space][0],
        ]
        assert ecu.memory[space].read(0x40) == 0x0D
        (change,) = changes
        assert (change.before, change.after) == (f"{before:02X}", "0D")
        assert [e["state"] for e in lines(tmp_path / "j")] == ["started", "done"]

    def test_a_block_is_written_in_blocks_with_one_question(self, space):
        changes = []
        it = bench()
        ecu = ecu_on(it, confirm=lambda c: changes.append(c) or True)
        memory = ecu.memory[space]
        data = bytes(range(256)) * (1 if memory.last == 0xFF else 3)
        written = memory.write_block(0, data)
        assert written.after == data
        assert written.before == pattern(space)[: len(data)]
        assert memory.read_block(0, len(data)) == data
        assert len(changes) == 1
        sent = [body for body in it.requests() if body[0] in WRITES[space]]
        assert len(sent) == (256 if space == "sfr" else len(data) // 255 + 1)

    def test_a_space_that_the_unit_lacks_is_an_error(self, space):
        for unknown in ("silent", "01"):
            memory = ecu_on(bench(missing="bytes,blocks,sfr", unknown=unknown)).memory[space]
            for call in (
                lambda memory=memory: memory.read(0),
                lambda memory=memory: memory.read_block(0, 20),
            ):
                with pytest.raises(NotSupported):
                    call()

    def test_a_cell_that_keeps_another_value_is_an_error(self, space, tmp_path):
        it = bench()
        ecu = ecu_on(it, confirm=yes, journal=tmp_path / "j")
        it.bus.ecu.responder.memory.write = lambda *_: None
        with pytest.raises(ReadBackDiffers, match=space):
            ecu.memory[space].write(0x10, 0xEE)
        assert lines(tmp_path / "j")[1]["state"] == "failed"


def test_there_is_no_other_space():
    with pytest.raises(UsageError, match="ram, xram, code, sfr"):
        ecu_on(bench()).memory["flash"]


@pytest.mark.parametrize("unknown", ["silent", "01"])
@pytest.mark.parametrize("space", BLOCKED)
class TestBlocks:
    @pytest.mark.parametrize(
        ("most", "learnt"), [(254, 127), (100, 63), (16, 15), (3, 3), (2, 1), (1, 1)]
    )
    def test_the_largest_that_it_takes_is_found_by_halving_and_kept(
        self, unknown, space, most, learnt, tmp_path
    ):
        it = bench(max_block=most, unknown=unknown)
        ecu = ecu_on(it, state=tmp_path)
        assert ecu.memory[space].read_block(0, 256) == pattern(space)[:256]
        assert ecu.info().limits.max_block == {space: learnt}
        ecu = ecu_on(it, state=tmp_path)
        assert ecu.memory[space].read_block(0, 200) == pattern(space)[:200]
        sizes = {body[-1] for body in it.requests(READS[space][1])}
        assert max(sizes, default=1) <= learnt

    def test_a_unit_without_blocks_is_read_byte_by_byte(self, unknown, space, tmp_path):
        it = bench(missing="blocks", unknown=unknown)
        ecu = ecu_on(it, state=tmp_path)
        assert ecu.memory[space].read_block(5, 40) == pattern(space)[5:45]
        assert ecu.info().limits.max_block == {space: 1}
        assert len(it.requests(READS[space][1])) <= 4
        ecu = ecu_on(it, state=tmp_path)
        ecu.memory[space].read_block(0, 3)
        assert it.requests(READS[space][1]) == []

    def test_a_unit_with_blocks_only_reads_single_bytes_too(self, unknown, space):
        memory = ecu_on(bench(missing="bytes", unknown=unknown)).memory[space]
        assert memory.read_block(0, 256) == pattern(space)[:256]
        assert memory.read(0x40) == pattern(space)[0x40]

    def test_without_blocks_single_bytes_are_written(self, unknown, space):
        it = bench(missing="22,24,26", unknown=unknown)
        ecu = ecu_on(it, confirm=yes)
        assert ecu.memory[space].write_block(0, b"abcdef").after == b"abcdef"
        assert len(it.requests(WRITES[space][1])) == 1
        assert len(it.requests(WRITES[space][0])) == 6

    def test_blocks_are_written_no_longer_than_the_unit_takes(self, unknown, space):
        it = bench(max_block=16, unknown=unknown)
        ecu = ecu_on(it, confirm=yes)
        data = bytes(range(100))
        assert ecu.memory[space].write_block(0, data).after == data
        assert {body[-16] for body in it.requests(WRITES[space][1]) if len(body) > 17} <= {15}
        assert it.requests(WRITES[space][0]) == []

    def test_a_unit_that_can_not_write_is_an_error(self, unknown, space):
        it = bench(missing="12,14,16,22,24,26", unknown=unknown)
        with pytest.raises(EcuRefused):
            ecu_on(it, confirm=yes).memory[space].write_block(0, b"abc")

    def test_blocks_have_the_upper_bound_of_the_caller(self, unknown, space):
        it = bench(unknown=unknown)
        ecu = ecu_on(it)
        came = list(ecu.memory[space].blocks(0, 100, largest=32))
        assert [len(part) for part in came] == [32, 32, 32, 4]
        assert b"".join(came) == pattern(space)[:100]
        assert not ecu.info().limits.learnt


@pytest.mark.parametrize("largest", [0, -1, 256])
def test_an_impossible_upper_bound_is_refused_before_anything_is_sent(largest):
    it = bench()
    with pytest.raises(UsageError, match="255"):
        ecu_on(it).memory.code.blocks(0, 10, largest=largest)
    assert it.requests() == []


@pytest.mark.parametrize("losses", [1, 2])
@pytest.mark.parametrize("space", BLOCKED)
def test_lost_responses_are_no_limit(space, losses):
    it = bench()
    ecu = ecu_on(it)
    it.next_faults(*[LineFault.LOST, None] * losses)
    assert ecu.memory[space].read_block(0, 256) == pattern(space)[:256]
    assert ecu.info().limits.max_block == {}


def test_a_place_that_cannot_be_read_is_no_limit():
    it = bench()
    responder = it.bus.ecu.responder

    class Gap:
        def __getattr__(self, name):
            return getattr(responder, name)

        def answer(self, body, now):
            hole = body[0] in (0x13, 0x23) and body[2] >= 0x80
            return None if hole else responder.answer(body, now)

    it.bus.ecu.responder = Gap()
    for first in (300, 0):  # in a session that has read elsewhere, and in one that has not
        ecu = ecu_on(it)
        if first:
            ecu.memory.xram.read_block(0, first)
        for count in (1, 20, 300):
            with pytest.raises((NoResponse, NotSupported)):
                ecu.memory.xram.read_block(0x8000, count)
        assert ecu.memory.xram.read_block(0, 300) == pattern("xram")[:300]
        assert ecu.info().limits.max_block == {}


@pytest.mark.parametrize("space", ["xram", "code"])
def test_a_count_in_the_response_is_no_datum(space):
    ecu = ecu_on(bench(counted_blocks=1))  # D7
    for count in (1, 2, 3, 255, 300):
        assert ecu.memory[space].read_block(7, count) == pattern(space)[7 : 7 + count]
    assert not ecu.info().limits.learnt


def test_a_damaged_block_is_read_again():
    it = bench()
    ecu = ecu_on(it)
    ecu.memory.code.read_block(0, 255)
    it.next_faults(LineFault.DAMAGED, None, LineFault.CUT, None, None, LineFault.MISSING_BYTE)
    assert ecu.memory.code.read_block(0, 600) == pattern("code")[:600]
    assert not ecu.info().limits.learnt


def test_code_is_not_written_unasked_and_not_read_for_nothing():
    it = bench()
    ecu = ecu_on(it)
    with pytest.raises(NotConfirmed, match="unable to run"):
        ecu.memory.code.write_block(0, bytes(60000))
    assert it.requests() == []


def test_a_refusal_half_way_does_not_say_that_nothing_was_changed():
    it = bench()
    ecu = ecu_on(it)
    responder = it.bus.ecu.responder

    class Half:
        def __getattr__(self, name):
            return getattr(responder, name)

        def answer(self, body, now):
            if body[0] == 0x24 and body[1:3] != b"\0\0":
                return b"\x01"
            return None if body[0] == 0x14 else responder.answer(body, now)

    it.bus.ecu.responder = Half()
    with pytest.raises(EcuRefused) as caught:
        ecu.memory.xram.write_block(0, bytes(300))
    assert "Some of the bytes were written" in str(caught.value)

    class Never(Half):
        def answer(self, body, now):
            return b"\x01" if body[0] in (0x22, 0x12) else responder.answer(body, now)

    it.bus.ecu.responder = Never()
    with pytest.raises((WriteRefused, NotSupported)) as caught:
        ecu.memory.ram.write_block(0, b"abc")
    assert "Some of the bytes" not in str(caught.value)


def test_info_and_supported_name_what_a_bare_unit_lacks():
    for unknown in ("silent", "01"):
        it = bench(missing="passports,bytes,blocks,sfr,count,stream,stroke,02", unknown=unknown)
        ecu = ecu_on(it)
        info = ecu.info()
        assert info.passport.program == (None,) * 3
        assert info.passport.data == (None,) * 5
        assert info.passport.pieces == ("",) * 8
        assert info.parameter_count is None
        known = {support.name: support.known for support in ecu.supported()}
        assert known["availability (01)"] is True
        assert known["CREADP (61)"] is True
        missing = (0x02, 0x11, 0x25, 0x31, 0x51, 0x60, 0x71)
        for name, knows in known.items():
            if name.endswith(tuple(f"({code:02X})" for code in missing)):
                assert knows is False, (name, unknown)
        assert known["CWRITP (62)"] is None  # not tried: it changes something


def test_info_and_supported_name_all_that_a_whole_unit_has():
    it = bench()
    ecu = ecu_on(it)
    info = ecu.info()
    assert info.version_code == 0x0A
    assert info.model.known
    assert len(info.passport.pieces) == 8
    assert any(info.passport.pieces)
    assert info.parameter_count == 21
    assert info.echo is True
    assert len(it.requests()) == 9
    assert ecu.passport() == info.passport
    assert len(it.requests()) == 9  # asked once a session
    it.forget()
    assert {s.known for s in ecu.supported()} == {True, None}
    changing = {0x12, 0x14, 0x16, 0x22, 0x24, 0x26, 0x32, 0x41, 0x62}  # 64: only the list
    assert not changing.intersection(body[0] for body in it.requests())
    assert ecu.read("TWAT")
