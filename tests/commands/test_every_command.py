"""§3: what holds for all commands alike, and the exchange vectors from the tester's end."""

from __future__ import annotations

import json
import re
from dataclasses import fields
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from command_strategies import SIZES, bytes_, exchanges
from mikas import commands as c
from mikas.errors import LineError, MikasError, NotSupported
from mikas.framing import encode

VECTORS = Path(__file__).parents[2] / "conformance"
EXCHANGES = json.loads((VECTORS / "exchanges.json").read_text("utf-8"))

ALL_CODES = bytes.fromhex(
    "01 02 11 12 13 14 15 16 21 22 23 24 25 26 31 32 41"
    "51 52 53 54 55 56 57 58 60 61 62 63 64 71 7F 80 81 82 83"
)
STREAMS = bytes.fromhex("71 7F 80 81 82 83")

ONE = (c.Datum(0x29, 1),)
# The vectors have all commands but the streams; 63 is not known from its bytes.
BODIES = [
    bytes.fromhex(each["request"]) for each in EXCHANGES if each["request"] not in ("63", "99")
]
BODIES += [bytes([code, 0x29]) for code in STREAMS]
ONE_OF_EACH = {0x63: c.ReadList(ONE)} | {body[0]: c.parse(body, lambda _: 1) for body in BODIES}


def test_names_are_those_of_the_table_of_the_document():
    document = (Path(__file__).parents[2] / "docs" / "protocol.md").read_text("utf-8")
    row = r'^\| <a id="cmd-([0-9a-f]{2})"></a>[^|]+\| ([^|]+) \|'
    rows = re.findall(row, document, re.MULTILINE)
    documented = {int(code, 16): name for code, name in rows}
    assert documented == {command.CODES[0]: command.SOURCE_NAME for command in c.ALL_COMMANDS}


def test_every_command_has_a_title_of_its_own_in_both_languages():
    titles = [command.TITLE for command in c.ALL_COMMANDS]
    assert len({title.en for title in titles}) == len({title.ru for title in titles}) == len(titles)
    assert all(re.search("[А-яЁё]", title.ru) for title in titles)


def test_a_command_is_an_unchangeable_value():
    """An existing command is a valid one: its arguments were checked when it was made."""
    assert sorted(ONE_OF_EACH) == sorted(ALL_CODES)
    for command in ONE_OF_EACH.values():
        assert len({command, command}) == 1
        assert not hasattr(command, "__dict__")
        for name in (*(field.name for field in fields(command)), "another"):
            with pytest.raises((AttributeError, TypeError)):
                setattr(command, name, 0)


def test_no_row_is_left_out():
    assert sorted(c.COMMANDS_BY_CODE) == sorted(ALL_CODES)
    assert sum(len(command.CODES) for command in c.ALL_COMMANDS) == len(ALL_CODES)


@given(exchanges)
def test_both_ends_agree(exchange):
    command, value = exchange
    body = command.body()
    assert body[0] == command.code
    if not isinstance(command, c.ReadList):
        assert c.parse(body, SIZES.get) == command
    response = command.respond(value)
    assert not command.ANSWERED or len(response) in command.response_lengths()
    try:
        assert command.read(response) == value
    except LineError:
        pytest.fail("a command must read its own response")


@given(exchanges, st.binary(max_size=40))
def test_a_foreign_response_is_refused_or_fits(exchange, foreign):
    command, _ = exchange
    try:
        value = command.read(foreign)
    except MikasError as error:
        assert error.request == command.body()
        assert error.received == foreign
    else:
        # What is accepted says exactly what came, or is the other form of D7.
        assert (
            foreign == command.respond(value)
            or (
                isinstance(command, c.ReadXramBlock | c.ReadCodeBlock)
                and foreign == command.respond(value, counted=True)
            )
            or isinstance(command, c.ReadProgramPassport | c.ReadDataPassport)
        )


@given(st.binary(max_size=40))
def test_parsing_any_body_gives_that_request_or_says_malformed(body):
    try:
        command = c.parse(body, SIZES.get)
    except c.MalformedRequest:
        return
    assert command.body() == body


@given(exchanges)
def test_01_is_never_taken_for_data_where_the_length_decides(exchange):
    """D10: a unit may answer 01 to a command that it does not know."""
    command, _ = exchange
    if command.ANSWERED and 1 not in command.response_lengths():
        with pytest.raises(NotSupported):
            command.read(b"\x01")


def test_only_71_and_the_strokes_stream_and_only_41_is_not_answered():
    assert {code for code, each in c.COMMANDS_BY_CODE.items() if each.STREAM} == set(STREAMS)
    assert {code for code, each in c.COMMANDS_BY_CODE.items() if not each.ANSWERED} == {0x41}


def test_safety_is_ordered_from_harmless_to_worst():
    """The gate compares safeties."""
    assert [each.name for each in sorted(c.Safety)] == [
        "READ", "REVERSIBLE", "LASTING", "DANGEROUS",
    ]  # fmt: skip


def test_each_command_has_the_safety_of_its_family():
    dangerous = {0x16, 0x26, 0x41}
    lasting = {0x62}
    reversible = {0x12, 0x14, 0x22, 0x24, 0x32, 0x64}
    for code, command in c.COMMANDS_BY_CODE.items():
        expected = (
            c.Safety.DANGEROUS
            if code in dangerous
            else c.Safety.LASTING
            if code in lasting
            else c.Safety.REVERSIBLE
            if code in reversible
            else c.Safety.READ
        )
        assert command.SAFETY is expected


@given(exchanges)
def test_only_reads_that_end_are_repeated(exchange):
    command, _ = exchange
    assert command.repeatable == (
        command.SAFETY is c.Safety.READ and command.code not in (0x71, *range(0x7F, 0x84))
    )
    assert f"({command.code:02X})" in command.name.en


def test_the_tester_sends_and_reads_the_exchange_vectors():
    """The tester builds the request and reads the response; the list of 63 is that of 64."""
    listed: tuple[c.Datum, ...] = ()
    sizes = {**dict.fromkeys(range(256), 1), 0x3F: 2, 0x21: 2, 0x40: 2, 0x59: 2}
    for vector in EXCHANGES:
        request = bytes.fromhex(vector["request"])
        if request == b"\x99":
            with pytest.raises(c.MalformedRequest):
                c.parse(request, sizes.get)
            continue
        command = c.ReadList(listed) if request[0] == 0x63 else c.parse(request, sizes.get)
        if isinstance(command, c.WriteList):
            listed = command.parameters
        assert encode(command.body()) == bytes.fromhex(vector["request_wire"]), vector["why"]
        if vector["answer"] is None:
            assert not command.ANSWERED
            continue
        answer = bytes.fromhex(vector["answer"])
        if "refused" in vector["why"]:
            with pytest.raises(MikasError):
                command.read(answer)
            continue
        assert command.respond(command.read(answer)) == answer, vector["why"]
        assert encode(answer) == bytes.fromhex(vector["answer_wire"])


@given(bytes_)
def test_an_unknown_parameter_is_no_request(code):
    with pytest.raises(c.MalformedRequest):
        c.parse(bytes([0x61, code]), lambda _: None)
