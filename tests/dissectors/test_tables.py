"""The tables for decoders say what `mikas.commands` and `mikas.catalog` say, byte for byte."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from command_strategies import exchanges
from dissectors.walking_harness import Walker
from mikas import commands as c
from mikas.catalog import INTERPRETATIONS, load, shipped
from mikas.dissectors.tables import tables_of
from mikas.i18n import Text
from mikas.recording.inspect import Describer

CATALOG = shipped()
TABLES = tables_of(CATALOG, "en")
WALKERS = {language: Walker(tables_of(CATALOG, language)) for language in ("en", "ru")}
CODES = st.sampled_from([code for code, _ in CATALOG.codes])
KNOWN = st.sampled_from(list(TABLES["commands"]))
BYTES = st.binary(max_size=12)
ANY_REQUEST = st.one_of(
    BYTES,
    st.builds(lambda code, rest: bytes([code]) + rest, KNOWN, BYTES),
    st.builds(
        lambda code, codes: bytes([code, *codes]),
        st.sampled_from([0x61, 0x64, 0x71, 0x7F, 0x83]),
        st.lists(CODES, min_size=1, max_size=5),
    ),
    exchanges.map(lambda exchange: exchange[0].body()),
)  # fmt: skip


def size_of(code):
    return CATALOG.size_of(code)


def said(walked):
    return None if walked["en"] is None else Text(walked["en"], walked["ru"])


def test_every_command_has_its_row():
    assert set(TABLES["commands"]) == set(c.COMMANDS_BY_CODE)
    for code, command in c.COMMANDS_BY_CODE.items():
        row = TABLES["commands"][code]
        assert (row["code"], row["name"], row["title"], row["stream"]) == (
            code, command.SOURCE_NAME, command.TITLE.en, command.STREAM,
        )  # fmt: skip


@given(exchanges)
def test_a_request_and_its_response_have_the_fields_of_the_command(exchange):
    command, value = exchange
    data = getattr(command, "parameters", ())
    if any(size_of(datum.code) != datum.size for datum in data):
        return  # the strategy's own sizes; the next tests have the catalog's
    walker = WALKERS["en"]
    asked = walker.request(command.body())
    assert asked["row"]["code"] == command.code
    for name in ("address", "count", "value"):
        if hasattr(command, name):
            assert asked[name] == getattr(command, name)
    if isinstance(command, c.WriteParameter):
        assert (asked["code"], asked["datum"]) == (command.parameter, command.data)
    codes = bytes(datum.code for datum in data)
    found = walker.response(asked, command.respond(value), codes)
    if value is None:
        assert found == {"result": 0}
    else:
        assert value in (
            found.get("values") and tuple(raw for _, raw in found["values"]),
            *(found.get(part) for part in ("model", "value", "bytes", "faults", "text", "any")),
        )


@given(ANY_REQUEST)
def test_any_request_is_one_for_both(body):
    walked = WALKERS["en"].request(body)
    if body[:1] == b"\x63":
        assert (walked is not None) == (body == b"\x63")
        return
    try:
        command = c.parse(body, size_of)
    except c.MalformedRequest:
        assert walked is None
    else:
        assert command.body() == body
        assert walked["row"]["code"] == command.code


@given(ANY_REQUEST, st.none() | BYTES | st.binary(min_size=16, max_size=16))
def test_any_frame_has_the_same_meaning_in_both_languages(request, response):
    describe = Describer(CATALOG)
    walked = {language: each.meaning(request, response) for language, each in WALKERS.items()}
    if response is not None:
        describe(request, None)
    assert said(walked) == describe(request, response)


@given(exchanges)
def test_an_exchange_has_the_same_meaning(exchange):
    command, value = exchange
    request, response = command.body(), command.respond(value)
    if request == b"\x63" or any(
        size_of(each.code) != each.size for each in getattr(command, "parameters", ())
    ):
        return
    describe = Describer(CATALOG)
    for body in (None, response):
        walked = {language: each.meaning(request, body) for language, each in WALKERS.items()}
        assert said(walked) == describe(request, body)


@given(st.lists(CODES, min_size=1, max_size=6), st.data())
def test_a_list_and_a_stream_have_the_same_meaning(codes, data):
    size = sum(size_of(code) for code in codes)
    response = data.draw(st.binary(min_size=size, max_size=size))
    listed = bytes(codes)
    describe = Describer(CATALOG)
    describe(b"\x64" + listed, None)
    describe(b"\x64" + listed, b"\0")
    for request in (b"\x63", b"\x71" + listed, b"\x80" + listed, b"\x61" + listed):
        describe(request, None)
        for first in (True, False):
            walked = {
                language: each.meaning(request, response, listed, first=first)
                for language, each in WALKERS.items()
            }
            assert said(walked) == describe(request, response)


@pytest.mark.parametrize("interpretation", INTERPRETATIONS)
def test_every_raw_number_has_the_catalogs_value(interpretation):
    for parameter, row in zip(CATALOG.parameters, TABLES["parameters"], strict=True):
        size = parameter.size
        assert (row["code"], row["name"], row["size"]) == (parameter.code, parameter.name, size)
        conversion = row["interpretations"][interpretation]
        for number in range(0, 256**size, 1 if size == 1 else 17):
            raw = number.to_bytes(size, "little")
            assert Walker.value(conversion, raw) == parameter.decode(raw, interpretation)


def test_faults_models_and_errata_are_the_catalogs():
    for number in range(256):
        row, fault = TABLES["faults"].get(number), CATALOG.fault(number)
        assert row is None or row == {"text": fault.text.en, "confidence": fault.confidence}
        assert (row is None) == (not fault.known)
    assert TABLES["models"] == {code: model.text.en for code, model in CATALOG.models.items()}
    assert {name for row in TABLES["parameters"] for name in row["errata"]} <= set(TABLES["errata"])
    erratum = CATALOG.errata["E1"]
    assert TABLES["errata"]["E1"] == {
        "corrected": erratum.default.en, "literal": erratum.alternative.en,
        "alternative": erratum.default.en, "family": erratum.default.en,
    }  # fmt: skip
    erratum = CATALOG.errata["E3"]
    assert TABLES["errata"]["E3"]["family"] == erratum.family.en != erratum.default.en


def test_the_users_own_catalog_is_in_them(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(
        '[parameter.MAP]\ncode = 0x30\nsize = 2\ntext = { en = "Pressure", ru = "Давление" }\n'
        'unit = "kPa"\nscale = "1/100"\n[fault.250]\ntext = { en = "Mine", ru = "Моя" }\n',
        "utf-8",
    )
    tables = tables_of(load(own), None)
    row = next(each for each in tables["parameters"] if each["name"] == "MAP")
    unit = row["interpretations"]["corrected"]["unit"]
    assert (row["code"], row["size"], unit) == (0x30, 2, ["kPa", "kPa"])
    literal = row["interpretations"]["literal"]
    assert (literal["numerator"], literal["denominator"]) == (1, 100)
    assert tables["faults"][250]["text"] == ["Mine", "Моя"]


def test_the_plain_form_is_plain():
    for language in ("en", "ru"):
        text = json.dumps(tables_of(CATALOG, language), ensure_ascii=False)
        assert ("чтение параметров" in text) == (language == "ru")
