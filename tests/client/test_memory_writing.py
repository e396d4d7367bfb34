"""Memory written in the form that the unit has, and what a failed write says of the unit."""

from __future__ import annotations

import re

import pytest
from client_harness import Bench, bench, ecu_on, lines
from hypothesis import example, given
from hypothesis import strategies as st

from mikas.commands import COMMANDS_BY_CODE, Space
from mikas.errors import (
    DamagedResponse,
    EcuRefused,
    LineError,
    LinkLost,
    MikasError,
    NoConnection,
    NotSupported,
    ReadBackDiffers,
)
from mikas.virtual.fault_injector import LineFault
from mikas.virtual.memory import pattern

BLOCKED = ["ram", "xram", "code"]
BYTE = {"ram": 0x12, "xram": 0x14, "code": 0x16, "sfr": 0x32}
BLOCK = {"ram": 0x22, "xram": 0x24, "code": 0x26}
NO_BYTES, NO_BLOCKS = "12,14,16", "22,24,26"


def yes(change):
    return True


def name(code: int) -> str:
    return COMMANDS_BY_CODE[code].SOURCE_NAME


def stored(it: Bench, space: str, address: int, count: int) -> bytes:
    """What the unit has, whatever was read of it."""
    return it.bus.ecu.responder.memory.read(Space(space), address, count)


def refuses(it: Bench, refused) -> None:
    """From here on the unit answers as `refused(body)` says: a body, None for silence, or ..."""
    responder = it.bus.ecu.responder

    class Picky:
        def __getattr__(self, attribute):
            return getattr(responder, attribute)

        def answer(self, body, now):
            answer = refused(body)
            return responder.answer(body, now) if answer is ... else answer

    it.bus.ecu.responder = Picky()


@pytest.mark.parametrize("unknown", ["silent", "01"])
@pytest.mark.parametrize("space", BLOCKED)
class TestTheForms:
    def test_a_unit_without_single_bytes_gets_blocks_of_one(self, unknown, space, tmp_path):
        it = bench(missing=NO_BYTES, unknown=unknown)
        memory = ecu_on(it, confirm=yes, journal=tmp_path / "j").memory[space]
        written = memory.write(0x40, 0x0D)
        assert (written.before, written.after) == (pattern(space)[0x40:0x41], b"\x0d")
        assert (
            stored(it, space, 0x3F, 3)
            == pattern(space)[0x3F:0x40] + b"\x0d" + pattern(space)[0x41:0x42]
        )
        assert [body[-2:] for body in it.requests(BLOCK[space])] == [b"\x01\x0d"]
        started, done = lines(tmp_path / "j")
        assert (started["command"], done["command"]) == (name(BYTE[space]), name(BLOCK[space]))
        it.forget()
        memory.write(0x41, 0x40)  # the session knows by now
        assert it.requests(BYTE[space]) == []

    def test_a_unit_without_single_bytes_gets_the_rest_of_a_block_too(
        self, unknown, space, tmp_path
    ):
        it = bench(missing=NO_BYTES, unknown=unknown)
        data = bytes(range(256))
        memory = ecu_on(it, confirm=yes, journal=tmp_path / "j").memory[space]
        assert memory.write_block(0, data).after == data == stored(it, space, 0, 256)
        assert it.requests(BYTE[space]) == []
        assert [e["command"] for e in lines(tmp_path / "j")] == [name(BLOCK[space])] * 2

    def test_a_unit_without_blocks_gets_single_bytes(self, unknown, space, tmp_path):
        it = bench(missing=NO_BLOCKS, unknown=unknown)
        memory = ecu_on(it, confirm=yes, journal=tmp_path / "j").memory[space]
        memory.write_block(0x10, b"abcdef")
        assert stored(it, space, 0x10, 6) == b"abcdef"
        started, done = lines(tmp_path / "j")
        assert (started["command"], done["command"]) == (name(BLOCK[space]), name(BYTE[space]))

    @pytest.mark.parametrize("missing", ["", NO_BYTES])
    @pytest.mark.parametrize("refusal", [None, b"\x01"])
    def test_a_unit_that_takes_shorter_blocks_than_it_sends(self, unknown, space, missing, refusal):
        it = bench(missing=missing, unknown=unknown)
        too_long = 20 + Space(space).address_bytes
        refuses(
            it, lambda body: refusal if body[0] == BLOCK[space] and len(body) > too_long else ...
        )
        data = bytes(range(256))
        memory = ecu_on(it, confirm=yes).memory[space]
        assert memory.write_block(0, data).after == data == stored(it, space, 0, 256)
        if missing:
            sent = it.requests(BLOCK[space])
            assert len(sent) < 40
            assert len(set(sent)) == len(sent)  # what is too long is not sent again

    def test_a_unit_with_neither_form_is_an_error_that_names_both(self, unknown, space, tmp_path):
        it = bench(missing=f"{NO_BYTES},{NO_BLOCKS}", unknown=unknown)
        memory = ecu_on(it, confirm=yes, journal=tmp_path / "j").memory[space]
        for call in (lambda: memory.write(0x40, 0x0D), lambda: memory.write_block(0x40, b"abc")):
            with pytest.raises(EcuRefused) as caught:
                call()
            for text in caught.value.text:
                for code in (BYTE[space], BLOCK[space]):
                    assert f"{name(code)} ({code:02X})" in text
            assert "Read back: nothing was changed." in caught.value.text.en
            assert "Проверено чтением: ничего не изменено." in caught.value.text.ru
        with pytest.raises(EcuRefused):  # the bytes that are there anyway prove nothing
            memory.write_block(0x40, pattern(space)[0x40:0x43])
        assert stored(it, space, 0, 256) == pattern(space)[:256]
        assert [e["state"] for e in lines(tmp_path / "j")] == ["started", "failed"] * 3
        for code in (BYTE[space], BLOCK[space]):
            assert name(code) in lines(tmp_path / "j")[1]["command"]


@pytest.mark.parametrize("unknown", ["silent", "01"])
class TestAFailureHalfWay:
    @pytest.mark.parametrize("missing", ["", NO_BYTES, NO_BLOCKS])
    def test_a_failure_half_way_says_what_stands_now(self, unknown, missing, tmp_path):
        it = bench(missing=missing, unknown=unknown)
        ecu = ecu_on(it, confirm=yes, journal=tmp_path / "j")
        refusal = b"\x01" if unknown == "01" else None
        ends = {
            0x24: lambda body: body[1] + 256 * body[2] + body[3],
            0x14: lambda b: b[1] + 256 * b[2] + 1,
        }
        refuses(it, lambda b: refusal if b[0] in ends and ends[b[0]](b) > 0x1105 else ...)
        data = bytes(300)
        with pytest.raises(MikasError) as caught:
            ecu.memory.xram.write_block(0x1000, data)
        # A known command that stays silent is line trouble, and its block is not divided.
        done = 255 if unknown == "silent" and missing != NO_BLOCKS else 0x1105 - 0x1000
        last = 0x1000 + done - 1
        assert (
            stored(it, "xram", 0x1000, 300) == data[:done] + pattern("xram")[0x1000 + done : 0x112C]
        )
        assert f"the first {done} of 300 bytes (1000–{last:04X}) are new" in caught.value.text.en
        assert f"первые {done} из 300 (1000–{last:04X})" in caught.value.text.ru
        assert "nothing was changed" not in caught.value.text.en
        started, failed = lines(tmp_path / "j")
        assert failed["outcome"] == caught.value.text.en
        assert bytes.fromhex(started["before"]) == pattern("xram")[0x1000:0x112C]

    def test_a_cable_pulled_meanwhile_leaves_the_bytes_unknown(self, unknown, tmp_path):
        it = bench(unknown=unknown)
        ecu = ecu_on(it, confirm=yes, journal=tmp_path / "j")
        write = it.link.write

        def pull(data):
            if len(it.requests(0x24)) == 2:
                it.link.unplug()
            write(data)

        it.link.write = pull
        with pytest.raises(LinkLost) as caught:
            ecu.memory.xram.write_block(0, bytes(1000))
        assert "USB" in caught.value.text.en
        assert "could not be read back" in caught.value.text.en
        assert "прочитать байты после этого не удалось" in caught.value.text.ru.lower()
        failed = lines(tmp_path / "j")[1]
        assert (failed["state"], failed["command"]) == ("failed", "CWRITDX")

    def test_a_cell_that_keeps_its_value_ends_the_write_with_what_stands(self, unknown):
        it = bench(unknown=unknown)
        memory = it.bus.ecu.responder.memory
        keep = memory.write
        memory.write = lambda space, address, data: keep(
            space, address, data[:10] + b"\xee" + data[11:]
        )
        with pytest.raises(
            ReadBackDiffers, match="ram 004A: 00 was written, EE was read back"
        ) as caught:
            ecu_on(it, confirm=yes).memory.ram.write_block(0x40, bytes(20))
        wrong = f"{'00 ' * 10}EE{' 00' * 9}"
        assert f"Some of the bytes were written. Read back: {wrong}." in caught.value.text.en


@pytest.mark.parametrize("unknown", ["silent", "01"])
def test_an_sfr_has_no_block_form(unknown, tmp_path):
    it = bench(missing="32", unknown=unknown)
    sfr = ecu_on(it, confirm=yes, journal=tmp_path / "j").memory.sfr
    for call in (lambda: sfr.write(0x90, 1), lambda: sfr.write_block(0x90, b"ab")):
        with pytest.raises(NotSupported, match=r"SWRITSFR \(32\).*no block form") as caught:
            call()
        assert "блочной формы" in caught.value.text.ru
        assert "nothing was changed" in caught.value.text.en
    assert {body[0] for body in it.requests()} - {0x01} == {0x31, 0x32}
    assert {e["command"] for e in lines(tmp_path / "j")} == {"SWRITSFR"}


@pytest.mark.parametrize("missing", ["bytes,blocks", "sfr"])
def test_what_cannot_be_read_is_not_written(missing):
    it = bench(missing=missing)
    memory = ecu_on(it, confirm=yes).memory["sfr" if missing == "sfr" else "ram"]
    with pytest.raises(NotSupported, match="Nothing was written"):
        memory.write(0x40, 1)
    assert not {body[0] for body in it.requests()} & {*BYTE.values(), *BLOCK.values()}


@pytest.mark.parametrize(
    "fault", [LineFault.LOST, LineFault.DAMAGED, LineFault.ECHO, LineFault.CUT]
)
def test_a_lost_or_damaged_answer_is_settled_by_reading_back(fault):
    it = bench()
    ecu = ecu_on(it, confirm=yes)
    it.next_faults(*[None] * 4, fault, fault)  # four blocks before, and the answers to two of four
    data = bytes(range(250)) * 4
    assert ecu.memory.xram.write_block(0, data).after == data == stored(it, "xram", 0, 1000)
    assert len(it.requests(0x24)) == 4  # none was sent twice
    assert it.requests(0x14) == []


def test_a_request_that_the_unit_did_not_get_is_sent_again():
    it = bench()
    ecu = ecu_on(it, confirm=yes)
    ecu.memory.xram.write_block(0, bytes(100))
    lost = [True, True]
    refuses(it, lambda body: None if body[0] == 0x24 and lost and lost.pop() else ...)
    ecu.memory.xram.write_block(0x40, bytes(100))
    assert stored(it, "xram", 0x40, 100) == bytes(100)
    assert it.requests(0x14) == []
    refuses(it, lambda body: None if body[0] == 0x24 else ...)
    with pytest.raises(LineError, match="nothing was changed"):
        ecu.memory.xram.write_block(0x40, b"xy")


def test_bytes_that_are_there_already_are_sent_once():
    it = bench()
    ecu = ecu_on(it, confirm=yes)
    data = pattern("xram")[:30]
    ecu.memory.xram.write_block(0, data)
    it.next_faults(None, LineFault.LOST)
    ecu.memory.xram.write_block(0, data)
    assert len(it.requests(0x24)) == 2


def test_one_lost_block_does_not_make_a_session_write_single_bytes():
    it = bench()
    ecu = ecu_on(it, confirm=yes)
    lost = [True]
    refuses(it, lambda body: None if body[0] == 0x24 and lost and lost.pop() else ...)
    ecu.memory.xram.write_block(0, bytes(20))
    it.forget()
    ecu.memory.xram.write_block(0x40, bytes(20))
    assert it.requests(0x14) == []


def test_an_sfr_is_never_written_twice():
    it = bench()
    ecu = ecu_on(it, confirm=yes)
    ecu.memory.sfr.write(0x90, 1)
    it.forget()
    refuses(it, lambda body: None if body[0] == 0x32 else ...)
    with pytest.raises(LineError):
        ecu.memory.sfr.write(0x90, 2)
    it.next_faults(None, LineFault.DAMAGED)
    refuses(it, lambda body: b"\x77\x77" if body[0] == 0x32 else ...)
    with pytest.raises((LineError, DamagedResponse)):
        ecu.memory.sfr.write(0x90, 3)
    assert len(it.requests(0x32)) == 2


FAULTS = st.lists(st.sampled_from([None, None, None, *LineFault]), max_size=40)


@given(
    FAULTS,
    st.sampled_from(["", NO_BYTES, NO_BLOCKS, f"{NO_BYTES},{NO_BLOCKS}"]),
    st.sampled_from(["silent", "01"]),
    st.sampled_from([1, 3, 20, 255]),
    st.sampled_from(["xram", "sfr"]),
    st.sampled_from([1, 2, 30]),
)
@example([None] * 2 + [LineFault.LOST] * 12, NO_BYTES, "silent", 20, "xram", 30)
def test_whatever_happens_on_the_line_what_is_said_is_true(
    line_faults, missing, unknown, longest, space, count
):
    it = bench(missing=missing, unknown=unknown, max_block=longest)
    ecu = ecu_on(it, confirm=yes)
    before = pattern(space)
    data = bytes(value ^ 0xFF for value in before[0x40 : 0x40 + count])
    it.next_faults(*line_faults)
    try:
        ecu.memory[space].write_block(0x40, data)
        said = "all bytes are as wanted"
    except (LineError, EcuRefused, NoConnection) as error:
        said = error.text.en
    now = stored(it, space, 0x40, count)
    if "all bytes are as wanted" in said:
        assert now == data
    elif "othing was" in said:  # changed, written
        assert now == before[0x40 : 0x40 + count]
    elif found := re.search(r"the first (\d+) of", said):
        done = int(found[1])
        assert now == data[:done] + before[0x40 + done : 0x40 + count]
    else:  # no claim, or reading failed before the first write
        assert "could not be read back" in said or now == before[0x40 : 0x40 + count]
    assert stored(it, space, 0, 0x40) == before[:0x40]
    assert stored(it, space, 0x40 + count, 0x40) == before[0x40 + count : 0x80 + count]
