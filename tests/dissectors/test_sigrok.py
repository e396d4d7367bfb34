"""The sigrok decoder over bytes: requests, responses and values as those of `mikas decode`."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from command_strategies import exchanges
from dissectors.sigrok_rig import BYTE, SimulatedSigrok, loaded
from mikas import commands as c
from mikas.catalog import shipped
from mikas.dissectors.sigrok.generator import source
from mikas.framing import encode
from mikas.recording.inspect import Describer

ROOT = Path(__file__).parents[2]
MODULE = loaded()
CATALOG = shipped()
TURN = 0.002  # s


def conversed(parts, **options):
    """Return the decoder behind (request, response, pause before the request), one wire."""
    sigrok = SimulatedSigrok(MODULE, **options)
    for request, response, pause in parts:
        sigrok.wait(pause)
        sigrok.feed(encode(request))
        if response is not None:
            sigrok.wait(TURN)
            sigrok.feed(encode(response))
    return sigrok


def described(parts, language="en", interpretation="corrected"):
    """Return what `mikas decode` says of each frame."""
    describe, said = Describer(CATALOG, interpretation), []
    for request, response, _ in parts:
        said.append(("request", describe(request, None)))
        if response is not None:
            said.append(("response", describe(request, response)))
    return [(kind, text and text.to(language)) for kind, text in said]


def compared(sigrok, said):
    """Assert that the decoder says the same; without a meaning it may say what it knows."""
    roles = sorted(sigrok.of("request", "response"), key=lambda each: each.ss)
    assert [each.kind for each in roles] == [kind for kind, _ in said]
    for role, (_, meaning) in zip(roles, said, strict=True):
        assert meaning is None or role.text == meaning


START = (b"\x01", b"\x0a", 0.0)
ANSWERED = st.lists(
    exchanges.filter(lambda each: not each[0].STREAM and each[0].ANSWERED)
    .map(lambda each: (each[0].body(), each[0].respond(each[1]), TURN))
    .filter(lambda each: each[0] != each[1]),  # that may be an echo
    max_size=6,
)  # fmt: skip


@given(ANSWERED, st.sampled_from(["en", "ru"]), st.sampled_from(["corrected", "literal"]))
def test_requests_and_responses_are_those_of_mikas_decode(parts, language, interpretation):
    parts = [START, *parts]
    sigrok = conversed(parts, language=language, interpretation=interpretation)
    compared(sigrok, described(parts, language, interpretation))
    assert not sigrok.of("unclear", "damage")


@given(st.lists(st.sampled_from(CATALOG.codes), min_size=1, max_size=8), st.data())
def test_a_stream_has_the_values_of_each_response(codes, data):
    size = sum(size for _, size in codes)
    asked = bytes([0x71, *(code for code, _ in codes)])
    responses = data.draw(st.lists(st.binary(min_size=size, max_size=size), min_size=2, max_size=5))
    if size == 1:
        responses = [each for each in responses if each != b"\x01"] or [b"\x02"]
    sigrok = conversed([START, (asked, responses[0], TURN)])
    for response in responses[1:]:
        sigrok.wait(0.0005)
        sigrok.feed(encode(response))
    describe = Describer(CATALOG)
    describe(asked, None)
    expected = [describe(asked, response).en for response in responses]
    assert sigrok.texts("response")[1:] == expected


def test_the_end_of_a_stream_is_its_01_and_the_version():
    sigrok = conversed([START, (bytes.fromhex("711A29"), bytes.fromhex("7D15"), TURN)])
    for body in ("7E15", "01", "7F15", "0A", "01", "0A"):
        sigrok.wait(TURN)
        sigrok.feed(encode(bytes.fromhex(body)))
    assert sigrok.texts("response")[1:] == [
        "TWAT=85°C FREQ=840rpm", "TWAT=86°C FREQ=840rpm",
        "Bytes in the response: 2; there should be 1 for this request", "Mikas 7.1", "Mikas 7.1",
    ]  # fmt: skip


def test_in_a_stream_of_one_byte_01_may_be_its_value_or_its_end():
    sigrok = conversed([START, (b"\x71\x29", b"\x15", TURN)])
    ending, reading = (b"\x16", b"\x01", b"\x0a", b"\x01", b"\x0a"), (b"\x61\x1a", b"\x7d")
    for body in (*ending, *reading, *reading):
        sigrok.wait(TURN)
        sigrok.feed(encode(body))
    assert sigrok.texts("response")[1:] == [
        "FREQ=840rpm", "FREQ=880rpm", "Mikas 7.1", "TWAT=85°C", "TWAT=85°C",
    ]  # fmt: skip
    assert len(sigrok.of("unclear")) == 3


def test_the_list_of_63_is_that_of_the_last_answered_64():
    listed = bytes.fromhex("641A29")
    data = (b"\x63", b"\x7d\x15", TURN)
    sigrok = conversed([START, data, (listed, b"\0", TURN), data, (listed, b"\x01", TURN), data])
    unknown = "response, its list (64) is not known"
    assert sigrok.texts("response") == [
        "Mikas 7.1", unknown, "done", "TWAT=85°C FREQ=840rpm", "The ECU refused the write", unknown,
    ]  # fmt: skip
    assert len(sigrok.of("value")) == 2


def test_a_damaged_64_leaves_no_list():
    set_list, data = (bytes.fromhex("641A29"), b"\0", TURN), (b"\x63", b"\x7d\x15", TURN)
    for hit in range(3):
        sigrok = conversed([START, set_list, data])
        sigrok.wait(TURN)
        wire = bytearray(encode(bytes.fromhex("642029")))
        wire[hit] ^= 0x10
        sigrok.feed(bytes(wire))
        for body in (b"\0", b"\x63", b"\x7d\x15", b"\x63", b"\x7d\x15", b"\x61\x1a", b"\x7d"):
            sigrok.wait(TURN)
            sigrok.feed(encode(body))
        assert sigrok.texts("value") == [
            "Coolant temperature: TWAT=85°C", "Crankshaft speed: FREQ=840rpm",
            "Coolant temperature: TWAT=85°C",
        ]  # fmt: skip


def test_what_repeats_its_request_gives_no_value_on_one_wire():
    """It may be an echo, behind a 01 whose echo was damaged (D1): `61 3F` is no INJ of 129.8 ms."""
    sigrok = conversed([START])
    ask = encode(b"\x61\x3f")
    for wire in (b"\x01\xfe\x0d", encode(b"\x0a"), ask, ask, encode(b"\x10\x02"), ask, ask):
        sigrok.wait(TURN)
        sigrok.feed(wire)
    assert not any("129.8" in text for text in sigrok.texts("value"))


SILENCE = 0.5


@given(
    st.lists(
        st.tuples(
            exchanges.filter(lambda each: not each[0].STREAM and each[0].ANSWERED),
            st.sampled_from(["answered", "silent", "damaged request", "damaged response"]),
            st.integers(0, 2**16),
        ),
        max_size=10,
    )
)
def test_silence_and_damage_invent_nothing(conversation):
    """A damaged byte may lose a frame; each role that is shown is right, and each value."""
    sigrok, truth, describe = SimulatedSigrok(MODULE), {}, Describer(CATALOG)
    conversation = [((c.Availability(), 0x0A), "answered", 0), *conversation]
    for (command, value), happening, seed in conversation:
        request, response = command.body(), command.respond(value)
        sigrok.wait(TURN)
        truth[sigrok.at] = ("request", request, describe(request, None))
        wires = [encode(request), encode(response)]
        if happening.startswith("damaged"):
            which = happening.endswith("response")
            wires[which] = damaged(wires[which], seed)
        sigrok.feed(wires[0])
        if happening == "silent":
            sigrok.wait(SILENCE)
            continue
        sigrok.wait(TURN)
        truth[sigrok.at] = ("response", response, describe(request, response))
        sigrok.feed(wires[1])
    for role in sigrok.of("request", "response"):
        if role.ss in truth:
            kind, _, meaning = truth[role.ss]
            assert role.kind == kind
            if kind == "request" or "not known" not in role.text:
                assert meaning is None or role.text == meaning.en
    valued = {each.ss for each in sigrok.of("response")}
    frames = {each.ss: each for each in sigrok.of("frame")}
    for value in sigrok.of("value", "flag", "fault", "text"):
        begin = max(ss for ss in frames if ss <= value.ss)
        assert begin in valued
        said = value.text.rsplit(": ", 1)[-1]
        if value.kind in ("value", "flag"):
            assert said in truth[begin][2].en


def damaged(wire, seed):
    """Return a wire with one byte changed that is neither a terminator nor becomes one."""
    place, change = seed % max(1, len(wire) - 1), 1 + (seed >> 8) % 255
    changed = bytearray(wire)
    changed[place] ^= change
    if changed[place] == 0x0D:
        changed[place] ^= 0x80
    return bytes(changed)


# The whole decoder


def test_it_is_python_that_old_sigroks_read():
    text = source(CATALOG)
    ast.parse(text, feature_version=(3, 4))
    called = {
        node.func.attr
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    }
    assert not called & {"hex", "removeprefix", "removesuffix", "isascii", "fromhex"}
    imported = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import)]
    assert [name.name for node in imported for name in node.names] == ["sigrokdecode"]


def test_each_annotation_has_its_row():
    decoder = MODULE.Decoder
    rows = [number for _, _, numbers in decoder.annotation_rows for number in numbers]
    assert sorted(rows) == list(range(len(decoder.annotations)))
    assert decoder.inputs == ["uart"]


@pytest.mark.parametrize("page", ["docs/how-to/sigrok.md", "docs/ru/how-to/sigrok.md"])
def test_the_page_has_the_names_of_all_rows_and_kinds(page):
    text, decoder = (ROOT / page).read_text("utf-8"), MODULE.Decoder
    for row, _, numbers in decoder.annotation_rows:
        kinds = ", ".join(f"`{decoder.annotations[number][0]}`" for number in numbers)
        assert f", `{row}` | {kinds} |" in text
    for name, _ in decoder.binary:
        assert f"`{name}`" in text


def test_its_own_names_are_in_the_language_in_which_it_was_made():
    russian = loaded(source(CATALOG, language="ru")).Decoder
    assert "Запросы и ответы" in [row[1] for row in russian.annotation_rows]
    assert [each["default"] for each in russian.options] == ["corrected", "stuffed", "ru"]


def test_stacked_decoders_and_dumps_get_frames_and_values():
    sigrok = conversed([START, (bytes.fromhex("613F07"), bytes.fromhex("580224"), TURN)])
    said = [data for _, _, data in sigrok.python]
    assert said[2:] == [
        ["REQUEST", b"\x61\x3f\x07", "CREADP (61)"],
        ["RESPONSE", b"\x58\x02\x24", b"\x61\x3f\x07"],
        ["VALUE", "INJ", 4.8, "ms"],
        ["VALUE", "RXX", True, ""],
        ["VALUE", "BITPOW", True, ""],
        ["VALUE", "RDET", False, ""],
    ]
    assert sigrok.binary[-2:] == [
        ("frames", encode(b"\x58\x02\x24")), ("responses", encode(b"\x58\x02\x24")),
    ]  # fmt: skip


def test_a_datum_is_shown_over_its_own_bytes():
    sigrok = conversed([START, (bytes.fromhex("611A3F29"), bytes.fromhex("0D40024C"), TURN)])
    at = sigrok.of("response")[-1].ss
    places = [((each.ss - at) // BYTE, (each.es - at) // BYTE) for each in sigrok.of("value")]
    assert places == [(0, 2), (2, 5), (5, 6)]  # 0D and 40 are stuffed: two bytes each


def test_the_other_form_of_a_checksum_and_an_odd_escape_are_named():
    for raw in (False, True):
        for expected in ("stuffed", "raw"):
            sigrok = SimulatedSigrok(MODULE, checksum=expected)
            sigrok.feed(encode(b"\xf3", raw_checksum=raw))
            wrong = {(True, "stuffed"): ["raw checksum"], (False, "raw"): ["stuffed checksum"]}
            found = [each for each in sigrok.texts("warning") if "checksum" in each]
            assert found == wrong.get((raw, expected), [])
            assert sigrok.texts("frame")
    sigrok = SimulatedSigrok(MODULE)
    sigrok.feed(bytes.fromhex("40057B40050D").replace(b"\x7b\x40\x05", b"\xbb"))
    assert sigrok.texts("warning")[0] == "irregular escape"


def test_the_languages_and_interpretations_are_options():
    exchange = (bytes.fromhex("611E"), b"\x8e", TURN)
    sigrok = conversed([START, exchange], interpretation="literal", language="ru")
    assert sigrok.texts("response") == ["Микас 7.1", "UACC=-11.4В"]
    assert sigrok.texts("request")[1] == "чтение параметров: UACC"
    assert conversed([START, exchange]).texts("response")[1] == "UACC=14.2V"


def test_a_request_without_a_response_is_named():
    sigrok = conversed([START, (b"\x61\x1a", None, TURN)])
    sigrok.wait(SILENCE)
    sigrok.feed(encode(b"\x01"))
    sigrok.wait(TURN)
    sigrok.feed(encode(b"\x0a"))
    assert sigrok.texts("warning") == ["no response"]
    assert not sigrok.of("unclear")


@pytest.mark.parametrize("sending", [0, 1])
def test_a_damaged_response_is_no_silence_but_a_glitch_is(sending):
    """On one wire, and on two."""
    for heard, silent in ((b"\x6d\x83\x0d", False), (b"\x6d\x83", False), (b"\xff", True)):
        sigrok = SimulatedSigrok(MODULE)
        for data, channel, pause in (
            (encode(b"\x01"), sending, TURN), (encode(b"\x0a"), 0, TURN),
            (encode(b"\x61\x1a"), sending, TURN), (heard, 0, TURN),
            (encode(b"\x01"), sending, SILENCE), (encode(b"\x0a"), 0, TURN),
            (encode(b"\x01"), sending, SILENCE), (encode(b"\x0a"), 0, TURN),
        ):  # fmt: skip
            sigrok.wait(pause)
            sigrok.feed(data, channel=channel)
        assert ("no response" in sigrok.texts("warning")) == silent
        assert sigrok.of("damage")


def test_a_false_start_bit_is_no_byte():
    sigrok = SimulatedSigrok(MODULE)
    wire = encode(b"\x01")
    sigrok.feed(wire[:1])
    for kind in ("INVALID STARTBIT", "FRAME"):
        sigrok.decoder.decode(sigrok.at, sigrok.at + 50, [kind, 0, (0, False)])
    sigrok.feed(wire[1:])
    assert sigrok.texts("frame") == ["01 FF 0D"]
    assert sigrok.texts("warning") == ["noise"]


def test_a_byte_without_a_stop_bit_damages_its_message_and_ends_none():
    for place in range(3):
        sigrok = conversed([START])
        wire = encode(b"\x61\x1a")
        for number, value in enumerate(wire):
            sigrok.feed(bytes([value]), sound=number != place)
        sigrok.wait(TURN)
        sigrok.feed(encode(b"\x7d"))
        assert "a byte without its stop bit" in sigrok.texts("warning")
        assert not sigrok.of("value")


def test_a_long_silence_ends_an_unfinished_message():
    sigrok = conversed([START])
    sigrok.feed(b"\x61\x1a")
    sigrok.wait(0.3)
    sigrok.feed(encode(b"\x01"))
    assert sigrok.texts("damage") == ["unfinished: 61 1A"]
    assert sigrok.texts("frame")[-1] == "01 FF 0D"


def test_bytes_of_another_bit_rate_are_named_by_what_they_lack():
    """They have no stop bits, so no terminator either: the whole recording may be one message."""
    sigrok = SimulatedSigrok(MODULE)
    for data in (b"\x61\x1a", b"\x55" * (MODULE.LONGEST + 1)):
        sigrok.feed(data, sound=False)
        sigrok.wait(SILENCE)
    sigrok.feed(encode(b"\x01"))
    assert sigrok.texts("warning") == ["a byte without its stop bit"] * 2
    assert sigrok.texts("frame") == ["01 FF 0D"]


@given(st.lists(st.tuples(st.sampled_from([0, 1]), st.binary(max_size=6), st.booleans())))
def test_arbitrary_bytes_break_nothing(parts):
    """On one channel or two; the last message may wait for the next."""
    sigrok = SimulatedSigrok(MODULE)
    for channel, data, sound in parts:
        sigrok.feed(data + b"\x0d", channel=channel, sound=sound)
