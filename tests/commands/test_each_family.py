"""§3, row by row where a row has a rule of its own."""

from __future__ import annotations

import pytest

from mikas import commands as c
from mikas.cleaning import clean_line
from mikas.commands.base import check_bytes, lengths_in_words
from mikas.commands.unit import version_of, version_text
from mikas.errors import (
    AddressOutOfRange,
    NotSupported,
    UsageError,
    ValueDoesNotFit,
    WriteRefused,
    WrongAddress,
    WrongContent,
    WrongLength,
)
from mikas.i18n import Text


def hexed(text: str) -> bytes:
    return bytes.fromhex(text)


def test_a_response_to_02_has_its_count_of_faults_or_is_wrong():
    assert c.ReadFaults().read(hexed("00")) == ()
    assert c.ReadFaults().read(hexed("02 0D E0 E0 E0")) == (0x0D, 0xE0)
    with pytest.raises(WrongContent, match="announces 3"):
        c.ReadFaults().read(hexed("03 0D E0 35 E0"))
    with pytest.raises(WrongContent, match="E0"):
        c.ReadFaults().read(hexed("01 0D E1"))
    with pytest.raises(WrongLength):
        c.ReadFaults().read(hexed("01 0D"))
    most = c.ReadFaults().respond((1,) * 300)
    assert (len(most), c.ReadFaults().read(most)) == (511, (1,) * 255)
    with pytest.raises(WrongLength):
        c.ReadFaults().read(most + hexed("01 E0"))


def test_d10_01_is_no_list_of_faults():
    """One fault would have its number and E0 behind it."""
    with pytest.raises(NotSupported, match="02"):
        c.ReadFaults().read(b"\x01")


def test_the_echoed_address_must_match():
    with pytest.raises(WrongAddress, match="has address 8AFF, the request 8AFE"):
        c.ReadCodeByte(0x8AFE).read(hexed("FF 8A 4F"))
    with pytest.raises(WrongAddress):
        c.ReadXramBlock(0x1000, 2).read(hexed("01 10 AA BB"))


@pytest.mark.parametrize("command", [c.ReadXramBlock, c.ReadCodeBlock])
def test_d7_the_count_may_or_may_not_be_repeated(command):
    block = command(0x1000, 3)
    assert block.read(hexed("00 10 AA BB 64")) == hexed("AA BB 64")
    assert block.read(hexed("00 10 03 AA BB 64")) == hexed("AA BB 64")
    with pytest.raises(WrongContent, match="announces 4 bytes instead of 3") as caught:
        block.read(hexed("00 10 04 AA BB 64"))
    assert "объявлено байтов 4 вместо 3" in caught.value.text.ru
    assert block.respond(hexed("AA BB 64"), counted=True) == hexed("00 10 03 AA BB 64")
    assert block.respond(hexed("AA BB 64")) == hexed("00 10 AA BB 64")
    with pytest.raises(WrongLength, match="5 / 6"):
        block.read(hexed("00 10 AA BB"))
    # 21 repeats it always
    with pytest.raises(WrongLength):
        c.ReadRamBlock(0x0C, 3).read(hexed("0C AA BB 64"))


def test_00_completes_a_write_01_refuses_it_and_another_code_is_wrong():
    write = c.WriteParameter(0x26, b"\x10")
    assert write.read(b"\x00") is None
    with pytest.raises(WriteRefused):
        write.read(b"\x01")
    with pytest.raises(WrongContent, match="7D is no completion code") as caught:
        write.read(b"\x7d")
    assert "7D — не код завершения" in caught.value.text.ru


def test_d10_01_to_a_longer_read_means_unknown():
    with pytest.raises(NotSupported, match="CREADC"):
        c.ReadCodeByte(0).read(b"\x01")


@pytest.mark.parametrize(
    "make",
    [
        lambda: c.ReadRamByte(0x100),
        lambda: c.ReadRamByte(-1),
        lambda: c.ReadXramByte(0x10000),
        lambda: c.ReadRamBlock(0xFF, 2),
        lambda: c.ReadCodeBlock(0xFFFF, 2),
        lambda: c.ReadCodeBlock(0, 0),
        lambda: c.WriteRamBlock(0, b""),
        lambda: c.GoTo(0x10000),
        lambda: c.WriteSfr(0x100, 0),
    ],
)
def test_an_address_out_of_range_makes_no_command(make):
    with pytest.raises(AddressOutOfRange):
        make()


@pytest.mark.parametrize(
    "make",
    [
        lambda: c.WriteRamByte(0, 256),
        lambda: c.WriteCodeByte(0, -1),
        lambda: c.WriteParameter(0x100, b"\0"),
        lambda: c.ReadParameters((c.Datum(256, 1),)),
    ],
)
def test_a_value_that_does_not_fit_makes_no_command(make):
    with pytest.raises(ValueDoesNotFit):
        make()


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: c.WriteSfr(0, 256), "sfr"),
        (lambda: c.WriteParameter(-1, b"\0"), "code"),
        (lambda: c.WriteList((c.Datum(-1, 1),)), "code"),
    ],
)
def test_the_value_that_does_not_fit_is_named(make, name):
    with pytest.raises(ValueDoesNotFit, match=rf"\b{name}: a byte is 0 to 255"):
        make()


def test_a_block_has_up_to_255_bytes():
    assert c.ReadRamBlock(0, 255).body() == hexed("21 00 FF")
    assert c.WriteXramBlock(0xFF01, bytes(255)).body() == hexed("24 01 FF FF") + bytes(255)


def test_the_erase_is_two_writes():
    assert [each.body() for each in c.ERASE_FAULTS] == [hexed("62 0E 08"), hexed("62 0E 00")]


@pytest.mark.parametrize(
    "make",
    [
        lambda: c.ReadCodeBlock(0, 256),
        lambda: c.ReadParameters(()),
        lambda: c.ReadParameters((c.Datum(0x1A, 0),)),
        lambda: c.WriteList(()),
        lambda: c.WriteParameter(0x26, b""),
        lambda: c.StreamAtStroke((c.Datum(0x1A, 1),), 5),
        lambda: c.StreamAtStroke((c.Datum(0x1A, 1),), -1),
        lambda: c.StreamAtStroke((), 0),
        lambda: c.ReadProgramPassport(4),
        lambda: c.ReadDataPassport(0),
    ],
)
def test_wrong_arguments_are_misuse(make):
    with pytest.raises(ValueError):  # noqa: PT011  (each says its own words)
        make()


def test_passports_are_code_page_866():
    body = hexed("8C 88 8A 80 91 20 37 2E 31 00 00 00 00 00 00 00")
    assert c.ReadProgramPassport(1).read(body) == "МИКАС 7.1"
    assert c.ReadProgramPassport(1).respond("МИКАС 7.1") == body
    assert c.ReadDataPassport(5).body() == b"\x58"


def test_a_passport_loses_its_padding_and_nothing_else():
    passport = c.ReadDataPassport(1)
    for code in range(1, 0x100):
        body = bytes([0x41, code]).ljust(16, b"\0")
        text = passport.read(body)
        assert passport.respond(text) == body
        assert clean_line(text) == text  # ESC is ␛, which steers no terminal
        if 0x20 <= code != 0x7F:
            assert text == bytes([0x41, code]).decode("cp866")
    assert passport.respond("€ " + 16 * "x") == b"? " + 14 * b"x"


def test_goto_expects_no_response_and_shows_one_that_comes():
    assert c.GoTo(0x8000).body() == hexed("41 00 80")
    assert c.GoTo(0x8000).read(b"\x55") == b"\x55"
    assert c.GoTo(0x8000).response_lengths() == ()


def test_strokes_have_codes_of_their_own():
    one = (c.Datum(0x29, 1),)
    assert [c.StreamAtStroke(one, s).body()[0] for s in range(5)] == [0x7F, 0x80, 0x81, 0x82, 0x83]
    assert c.StreamAtStroke(one).body()[0] == 0x7F


@pytest.mark.parametrize(
    "body",
    [
        "",
        "99",
        "01 00",
        "02 00",
        "11",
        "12 40",
        "21 0C",
        "21 0C 00",
        "21 F0 20",
        "22 0C 02 01",
        "22 0C",
        "41 00",
        "51 00",
        "60 00",
        "61",
        "62 26",
        "63",
        "64",
    ],
)
def test_a_malformed_request_is_not_parsed(body):
    with pytest.raises(c.MalformedRequest):
        c.parse(hexed(body), lambda _: 1)


def test_the_list_of_63_is_not_known_from_its_bytes():
    with pytest.raises(c.MalformedRequest):
        c.ReadList.parse(b"\x63", lambda _: 1)


def test_lengths_are_written_as_a_list_or_a_series():
    assert lengths_in_words((4,)) == "4"
    assert lengths_in_words((1, 3, 5)) == "1 / 3 / 5"
    assert lengths_in_words(range(1, 8, 2)) == "1, 3, 5 …"


def test_a_command_is_shown_by_the_mnemonic_or_in_russian_by_its_title():
    assert c.ReadParameters((c.Datum(0x1A, 1),)).name == Text("CREADP (61)", "CREADP (61)")
    assert c.ReadFaults().name == Text("read faults (02)", "«запомненные ошибки» (02)")


def test_spaces_by_name_with_their_last_address():
    lasts = {"ram": 0xFF, "xram": 0xFFFF, "code": 0xFFFF, "sfr": 0xFF}
    assert {str(space): space.last for space in c.Space} == lasts


def test_what_the_ecu_does_not_know_is_no_request():
    with pytest.raises(c.MalformedRequest):
        c.parse(hexed("61 1A"), lambda _: None)


def test_a_stream_is_parsed_with_its_stroke():
    stream = c.parse(hexed("82 29"), lambda _: 1)
    assert stream == c.StreamAtStroke((c.Datum(0x29, 1),), 3)
    assert not stream.repeatable


def test_goto_responds_with_the_given_bytes_and_is_not_repeatable():
    assert c.GoTo(0x8000).respond(b"\x55") == b"\x55"
    assert not c.GoTo(0x8000).repeatable


def test_d10_a_code_of_unknown_size_is_a_datum_or_a_refusal():
    once, twice = c.ReadUnknownSize.of(0x33, 1), c.ReadUnknownSize.of(0x33, 2)
    assert (once.body(), twice.body()) == (hexed("61 33"), hexed("61 33 33"))
    assert once.read(hexed("AA BB")) == (hexed("AA BB"),)
    assert once.read(b"\x01") == (b"\x01",)  # a datum or a refusal
    assert once.read(b"") == twice.read(b"") == ()
    assert twice.read(hexed("AA BB AA BC")) == (hexed("AA BB"), hexed("AA BC"))
    assert twice.read(hexed("AA BB CC")) == (hexed("AA BB CC"),)
    with pytest.raises(NotSupported, match="61"):
        twice.read(b"\x01")
    assert twice.read(hexed("01 01")) == (b"\x01", b"\x01")
    longest = bytes(range(255))
    assert once.read(longest) == (longest,)
    assert twice.read(2 * longest) == (longest, longest)
    for request, too_long in ((once, 256), (twice, 511)):
        with pytest.raises(WrongLength):
            request.read(bytes(too_long))


@pytest.mark.parametrize("code", [0x00, 0x09, 0x0A, 0xFF])
def test_a_version_code_has_one_form_in_every_json(code):
    assert version_of(version_text(code)) == version_of(code) == code
    assert version_text(0x0A) == "0A"


@pytest.mark.parametrize("other", [None, True, 1.0, "", "0a", "A", "10 ", "100", [10]])
def test_another_length_is_no_version_code(other):
    assert version_of(other) is None
    assert version_text(None) is None


@pytest.mark.parametrize("other", ["80", b"\x80", None, 1.0, [128]])
def test_an_address_and_a_byte_are_whole_numbers(other):
    for make in (
        lambda: c.ReadRamByte(other), lambda: c.ReadCodeBlock(0x8000, other),
        lambda: c.WriteRamByte(0x40, other),
    ):  # fmt: skip
        with pytest.raises(UsageError, match="a whole number is needed, such as 128 or 0x80, not"):
            make()


@pytest.mark.parametrize("data", [b"\x01", bytearray(b"\x01"), memoryview(b"\x01")])
def test_bytes_have_three_kinds(data):
    check_bytes(data)


@pytest.mark.parametrize("other", ["61 1A", [0x61], 0x61, None])
def test_a_text_or_a_list_is_not_bytes(other):
    with pytest.raises(UsageError, match="bytes are needed, as "):
        check_bytes(other)
