"""Asking the catalog by name, code and number."""

from __future__ import annotations

from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import AlarmLimits, Confidence, Fault, Meaning, Model, shipped
from mikas.errors import UnknownParameter


@pytest.mark.parametrize("name", ["TWAT", "twat", "Twat", " twat "])
def test_a_name_is_found_in_any_case(name: str) -> None:
    assert shipped().parameter(name).name == "TWAT"


@pytest.mark.parametrize(
    ("asked", "name", "code", "size", "raw", "value"),
    [
        ("0x1A", "0x1A", 0x1A, 1, "7D", 125),
        ("0x1a", "0x1A", 0x1A, 1, "7D", 125),
        ("0X7", "0x07", 0x07, 1, "FF", 255),
        ("0x3F", "0x3F", 0x3F, 2, "5802", 600),
        ("0x3F:2", "0x3F:2", 0x3F, 2, "5802", 600),
        ("0x3F:1", "0x3F:1", 0x3F, 1, "58", 88),
        ("0xEE", "0xEE", 0xEE, 1, "FF", 255),
        ("0xee:3", "0xEE:3", 0xEE, 3, "010203", 0x030201),
        ("0xEE:4", "0xEE:4", 0xEE, 4, "FFFFFFFF", 0xFFFFFFFF),
    ],
)
def test_a_code_gives_the_raw_number(
    asked: str, name: str, code: int, size: int, raw: str, value: int
) -> None:
    parameter = shipped().parameter(asked)
    assert (parameter.name, parameter.code, parameter.size) == (name, code, size)
    assert (parameter.unit, parameter.errata, parameter.is_flag) == ("", (), False)
    assert (parameter.source, parameter.decimals) == ("", 0)
    assert parameter.confidence is Confidence.UNKNOWN
    assert parameter.decode(bytes.fromhex(raw)) == value
    assert parameter.encode(value) == bytes.fromhex(raw)


@pytest.mark.parametrize("asked", ["0x3F:0", "0x3F:5", "0x3F:255"])
def test_other_sizes_are_refused(asked: str) -> None:
    with pytest.raises(UnknownParameter) as caught:
        shipped().parameter(asked)
    assert caught.value.suggestions == ("0x3F:1", "0x3F:2", "0x3F:3", "0x3F:4")


@pytest.mark.parametrize(
    ("asked", "nearest"),
    [
        ("TWATT", "TWAT"),
        ("frq", "FREQ"),
        ("ТWАТ", "TWAT"),  # Cyrillic Т, А, Т
        ("уасс", "UACC"),
        ("ТНR", "THR"),
        ("0х1А", "0x1A"),  # Cyrillic х, А
    ],
)
def test_a_slip_is_answered_with_the_nearest_name(asked: str, nearest: str) -> None:
    with pytest.raises(UnknownParameter) as caught:
        shipped().parameter(asked)
    assert caught.value.name == asked
    assert caught.value.suggestions[0] == nearest
    assert nearest in caught.value.text.ru


@pytest.mark.parametrize(
    "asked", ["", "0x", "0x100", "0x1G", "0x1A:", "26", "№", "0x1A:9999", "{x}"]
)
def test_nonsense_has_no_nearest_name(asked: str) -> None:
    with pytest.raises(UnknownParameter) as caught:
        shipped().parameter(asked)
    assert caught.value.suggestions == ()


@given(st.text(max_size=12))
def test_any_text_is_a_parameter_or_an_unknown_one(asked: str) -> None:
    try:
        assert shipped().parameter(asked).size in {1, 2, 3, 4}
    except UnknownParameter as error:
        assert error.name == asked.strip()


def test_a_code_has_the_size_of_its_datum() -> None:
    assert shipped().size_of(0x1A) == 1
    assert shipped().size_of(0x3F) == 2
    assert shipped().size_of(0xEE) is None


def test_a_code_has_all_parameters_that_share_it() -> None:
    assert [each.name for each in shipped().by_code(0x07)] == ["RXX", "BITPOW", "RDET"]
    assert [each.name for each in shipped().by_code(0x1A)] == ["TWAT"]
    assert shipped().by_code(0xEE) == ()


def test_without_a_source_nothing_is_claimed() -> None:
    assert (Model.unknown(0x0B).source, AlarmLimits().source, Meaning().source) == ("", "", "")
    assert (Fault(99).sources, Fault(99).informational) == ((), False)
    assert {Model.unknown(0x0B).confidence, Fault(99).confidence} == {Confidence.UNKNOWN}
    assert str(Confidence.UNKNOWN) == "unknown"


def test_entries_are_unchangeable_values() -> None:
    catalog = shipped()
    entries = [catalog.parameter("RXX"), catalog.parameter("TWAT"), catalog.channel("DUTY")]
    entries += [catalog.fault(13), catalog.model(0x0A), catalog.errata["E1"]]
    parts = [getattr(each, part, None) for each in entries
             for part in ("conversion", "alarm_limits", "lamp", "meaning")]  # fmt: skip
    for value in (catalog, *entries, *filter(None, parts)):
        assert len({value, value}) == 1
        for name in (*(field.name for field in fields(value)), "another"):
            with pytest.raises((AttributeError, TypeError)):
                setattr(value, name, 0)
        assert hasattr(value, "__dict__") == (value is catalog)  # for its cached properties


def test_a_catalog_is_printed_in_a_line() -> None:
    assert len(repr(shipped())) < 100
