"""A unit's profile: to JSON and back without a loss, and an error that names the wrong key."""

from __future__ import annotations

import json
from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import UsageError
from mikas.virtual.quirks import ChecksumForm
from mikas.virtual.unit_profile import CodeProfile, Moves, UnitProfile

from .profile_strategies import any_json, profiles

KEYS = {"schema", "max_list"} | {
    each.name for each in fields(UnitProfile) if not each.name.startswith("max_list_")
}


@given(profiles())
def test_a_profile_is_read_back_from_its_json(profile):
    text = json.dumps(profile.to_json(), allow_nan=False)
    assert UnitProfile.from_json(json.loads(text)) == profile


def test_the_json_has_every_key_and_null_where_nothing_was_found():
    written = UnitProfile().to_json()
    assert written.keys() == KEYS
    assert written["max_list"] == {"61": None, "64": None, "71": None}
    assert {key for key, value in written.items() if value is None} == KEYS - {
        "schema", "max_list", "supported", "missing"
    }  # fmt: skip
    assert UnitProfile.from_json({"schema": 1}) == UnitProfile()


def test_the_form_of_the_file():
    profile = UnitProfile(
        version_code=0x0A,
        supported=frozenset({0x61, 0x01}),
        unknown="01",
        max_list_71=7,
        accepts=ChecksumForm.RAW,
        strokes={0x7F: 0.5},
        codes={0x1A: CodeProfile(1, (b"\x7d", b"\x80"), Moves.OTHER)},
        passports=("МИКАС 7.1", None, "", "", "", "", "", "␛[2J"),
        faults=(13, 53),
    )
    written = profile.to_json()
    found = {key: value for key, value in written.items() if value}
    assert found == {
        "schema": 1,
        "version_code": "0A",
        "supported": ["01", "61"],
        "unknown": "01",
        "max_list": {"61": None, "64": None, "71": 7},
        "accepts": "raw",
        "strokes": {"7F": 0.5},
        "codes": {"1A": {"size": 1, "samples": ["7D", "80"], "moves": "other"}},
        "passports": ["МИКАС 7.1", None, "", "", "", "", "", "␛[2J"],
        "faults": [13, 53],
    }


WRONG = [
    (None, "", "JSON object"),
    ([], "", "JSON object"),
    ({}, "schema", "must be 1"),
    ({"schema": 2}, "schema", "another version"),
    ({"schema": True}, "schema", "must be 1"),
    ({"schema": 1, "turnround": 1}, "turnround", "turn_round"),
    ({"schema": 1, "max_list_61": 1}, "max_list_61", "max_list"),
    ({"schema": 1, "version_code": 10}, "version_code", "in hex"),
    ({"schema": 1, "version_code": "0A\n"}, "version_code", "in hex"),
    ({"schema": 1, "echo": 1}, "echo", "true or false"),
    ({"schema": 1, "turn_round": "fast"}, "turn_round", "0 to 10"),
    ({"schema": 1, "turn_round": True}, "turn_round", "0 to 10"),
    ({"schema": 1, "turn_round": float("nan")}, "turn_round", "0 to 10"),
    ({"schema": 1, "turn_round": -0.1}, "turn_round", "0 to 10"),
    ({"schema": 1, "inter_byte": 10**400}, "inter_byte", "0 to 1"),
    ({"schema": 1, "supported": "61"}, "supported", "a list"),
    ({"schema": 1, "supported": ["61", 61]}, "supported.1", "in hex"),
    ({"schema": 1, "missing": ["01"]}, "missing", "can't have 01"),
    ({"schema": 1, "missing": ["71", "61"], "supported": ["61"]}, "missing", "61"),
    ({"schema": 1, "unknown": "loud"}, "unknown", '"silent"'),
    ({"schema": 1, "unknown": ""}, "unknown", '"silent"'),
    ({"schema": 1, "unknown": "00" * 256}, "unknown", "255 bytes"),
    ({"schema": 1, "bad_write": "02"}, "bad_write", '"01", "silent"'),
    ({"schema": 1, "max_block": 0}, "max_block", "1 to 255"),
    ({"schema": 1, "max_block": 16.0}, "max_block", "1 to 255"),
    ({"schema": 1, "max_list": 8}, "max_list", "JSON object"),
    ({"schema": 1, "max_list": {"7F": 8}}, "max_list.7F", '"61", "64", "71"'),
    ({"schema": 1, "max_list": {"61": 256}}, "max_list.61", "1 to 255"),
    ({"schema": 1, "sends": "both"}, "sends", '"stuffed", "raw"'),
    ({"schema": 1, "stream_end": "never"}, "stream_end", "break"),
    ({"schema": 1, "strokes": {"71": 1}}, "strokes.71", '"7F"'),
    ({"schema": 1, "strokes": {"7F": 5}}, "strokes.7F", "0 to 4"),
    ({"schema": 1, "codes": {"1a2": {"size": 1}}}, "codes.1a2", "in hex"),
    ({"schema": 1, "codes": {"1A": 1}}, "codes.1A", "JSON object"),
    ({"schema": 1, "codes": {"1A": {}}}, "codes.1A.size", "missing"),
    ({"schema": 1, "codes": {"1A": {"size": 0}}}, "codes.1A.size", "1 to 255"),
    ({"schema": 1, "codes": {"1A": {"size": 1, "sample": []}}}, "codes.1A.sample", "samples"),
    ({"schema": 1, "codes": {"1A": {"size": 1, "samples": ["7D", "0"]}}}, "codes.1A.samples.1",
     "in hex"),
    ({"schema": 1, "codes": {"1A": {"size": 2, "samples": ["7D"]}}}, "codes.1A.samples", "2"),
    ({"schema": 1, "codes": {"1A": {"size": 1, "samples": ["7D"] * 1001}}}, "codes.1A.samples",
     "1000"),
    ({"schema": 1, "codes": {"1A": {"size": 1, "moves": "sideways"}}}, "codes.1A.moves", "rpm"),
    ({"schema": 1, "passports": ["a"]}, "passports", "8 entries"),
    ({"schema": 1, "passports": [""] * 7 + ["x" * 17]}, "passports.7", "16 characters"),
    ({"schema": 1, "passports": [""] * 7 + ["€"]}, "passports.7", "page 866"),
    ({"schema": 1, "faults": [256]}, "faults.0", "0 to 255"),
    ({"schema": 1, "x" * 500: 1}, "x" * 80, "no key"),
]  # fmt: skip


@pytest.mark.parametrize(("value", "key", "expected"), WRONG)
def test_a_wrong_value_is_reported_with_its_key_and_what_belongs_there(value, key, expected):
    with pytest.raises(UsageError) as caught:
        UnitProfile.from_json(value, "a.zip: unit.json")
    en, ru = caught.value.text
    assert en.startswith(f"a.zip: unit.json: {key}".rstrip(" "))
    assert expected in en
    assert "survey the unit again" in en
    assert ".." not in en + ru
    assert f": {key}" in ru
    assert "обследуйте" in ru


@given(st.dictionaries(st.sampled_from(sorted(KEYS)) | st.text(max_size=3), any_json) | any_json)
def test_any_json_is_a_profile_or_a_named_error(value):
    if isinstance(value, dict):
        value = {**value, "schema": 1}
    try:
        profile = UnitProfile.from_json(value)
    except UsageError as error:
        assert "unit.json" in error.text.en
    else:
        assert UnitProfile.from_json(profile.to_json()) == profile
