"""What the frames of a capture mean, in words; never a wrong meaning, never a crash."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.recording.inspect import Describer

EXCHANGES = json.loads(
    (Path(__file__).parents[2] / "conformance" / "exchanges.json").read_text("utf-8")
)


def description(request: str, response: str | None = None, describe: Describer | None = None):
    describe = describe or Describer(shipped())
    body = None if response is None else bytes.fromhex(response)
    return describe(bytes.fromhex(request), body)


@pytest.mark.parametrize(
    ("request_body", "response", "en", "ru"),
    [
        ("01", None, "availability, model", "доступность, модель"),
        ("01", "0A", "Mikas 7.1", "Микас 7.1"),
        ("02", "020DE035E0", "faults 13 53", "ошибки 13 53"),
        ("02", "00", "faults 0", "ошибки 0"),
        ("611A", None, "read parameters: TWAT", "чтение параметров: TWAT"),
        ("611A", "7D", "TWAT=85°C", "TWAT=85°C"),
        ("613F", "5802", "INJ=4.80ms", "INJ=4.80мс"),
        ("6107", "24", "RXX=1 BITPOW=1 RDET=0", "RXX=1 BITPOW=1 RDET=0"),
        ("6107", None, "read parameters: RXX/BITPOW/RDET", "чтение параметров: RXX/BITPOW/RDET"),
        ("62261E", "00", "done", "выполнено"),
        ("51", "4D494B415320372E3100000000000000", "“MIKAS 7.1”", "«MIKAS 7.1»"),
        ("1140", "4045", "45", "45"),
        ("214002", "4002456A", "45 6A", "45 6A"),
    ],
)
def test_each_exchange_is_described_in_words(request_body, response, en, ru):
    text = description(request_body, response)
    assert text is not None
    assert text.en.startswith(en)
    assert text.ru.startswith(ru)


def test_a_refusal_says_so():
    assert (
        "refused" in description("62261E", "01").en.lower()
        or "did not" in description("62261E", "01").en
    )
    assert "CREADI" in description("1140", "01").en


@pytest.mark.parametrize("request_body", ["", "99", "6155", "11", "63"])
def test_what_is_not_known_has_no_meaning(request_body):
    assert description(request_body) is None
    assert description(request_body, "0102") is None


def test_a_response_of_the_wrong_length_is_said_to_be_one():
    assert "Bytes in the response" in description("611A", "0102").en


def test_a_list_is_remembered():
    describe = Describer(shipped())
    assert description("63", "7D", describe) is None
    assert description("641A29", "01", describe) is not None  # refused: the old list is in force
    assert description("63", "7D15", describe) is None
    assert description("641A29", "00", describe).en == "done"
    assert description("63", "7D15", describe).en == "TWAT=85°C FREQ=840rpm"
    assert description("63", None, describe).en == "read the list"


def test_a_list_with_an_unknown_code_leaves_none():
    describe = Describer(shipped())
    for setting in ("641A29", "6455"):
        description(setting, None, describe)
        description(setting, "00", describe)
    assert description("63", None, describe) is None
    assert description("63", "7D15", describe) is None


def test_while_a_list_is_being_set_the_units_list_is_unknown():
    describe = Describer(shipped())
    description("641A29", None, describe)
    description("641A29", "00", describe)
    assert description("63", "7D15", describe).en.startswith("TWAT")
    description("642920", None, describe)  # its 00 was lost: old or new list, both have two bytes
    assert description("63", "1520", describe) is None
    description("642920", "00", describe)
    assert description("63", "1520", describe).en == "FREQ=840rpm THR=32%"


def test_a_lone_01_may_be_a_refusal():
    describe = Describer(shipped())
    assert description("6120", "02", describe).en == "THR=2%"
    assert description("6120", "01", describe).en == "a value of 01, or a refusal"
    assert description("61201A", "0101", describe).en.startswith("THR=1%")


def test_the_first_response_of_a_stream_may_be_a_refusal():
    describe = Describer(shipped())
    for stream in ("7120", "8320"):
        description(stream, None, describe)
        assert description(stream, "01", describe).en == "a value of 01, or a refusal"
        assert description(stream, "01", describe).en == "THR=1%"
    description("7120", None, describe)
    assert description("7120", "02", describe).en == "THR=2%"
    assert description("7120", "01", describe).en == "THR=1%"


def test_a_value_is_described_in_the_requested_interpretation():
    literal = Describer(shipped(), "literal")
    assert description("611E", "8E").en == "UACC=14.2V"
    assert description("611E", "8E", literal).en.startswith("UACC=-11.4")


@pytest.mark.parametrize("vector", EXCHANGES, ids=lambda v: v["why"] + v["request"][:8])
def test_every_exchange_of_the_vectors(vector):
    describe = Describer(shipped())
    request = bytes.fromhex(vector["request"])
    answer = vector.get("answer")
    for response in (None, bytes.fromhex(answer) if answer is not None else None):
        text = describe(request, response)
        assert text is None or (text.en and text.ru)


@given(st.lists(st.tuples(st.binary(max_size=12), st.none() | st.binary(max_size=30))))
def test_any_exchange_has_a_description_or_none(exchanges):
    describe = Describer(shipped())
    for request, response in exchanges:
        text = describe(request, response)
        assert text is None or isinstance(text.en, str)
