"""`mikas sim --unit`, and `--port sim:?unit=…` of other commands: the unit of a survey's file."""

from __future__ import annotations

import json
import zipfile

import pytest
from cli_harness import is_one_short_paragraph, is_russian

from mikas.virtual.unit_profile import CodeProfile, UnitProfile

PROFILE = UnitProfile(
    version_code=0x2C,
    missing=frozenset({0x60}),
    codes={0x1A: CodeProfile(1, (b"\x7d",)), 0x90: CodeProfile(2, (b"\x01\x02",))},
    faults=(53, 13),
)


@pytest.fixture
def survey(tmp_path):
    with zipfile.ZipFile(tmp_path / "survey.zip", "w") as archive:
        archive.writestr("unit.json", json.dumps(PROFILE.to_json()))
    return "sim:?clock=simulated&unit=survey.zip"


def test_commands_see_the_unit_of_the_file(mikas, survey):
    info = mikas("info", "--json", "--port", survey).object
    assert info["version_code"] == "2C"
    assert info["parameter_count"] is None
    faults = mikas("faults", "--json", "--port", survey).object["faults"]
    assert [fault["code"] for fault in faults] == [53, 13]
    readings = mikas("read", "0x90:2", "--json", "--port", survey).object["readings"]
    assert [reading["raw"] for reading in readings.values()] == ["0102"]


def test_a_scan_finds_the_codes_of_the_file(mikas, survey):
    found = mikas("scan", "--json", "--port", f"{survey}&unknown=01").object["codes"]
    assert {each["code"]: each["size"] for each in found} == {"1A": 1, "90": 2}


WRONG = {
    "nosuch.zip": None,
    "empty.zip": b"",
    "text.zip": b"hello",
    "other.zip": b'{"schema": 1, "turn_round": "soon"}',
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("lang", ["en", "ru"])
def test_a_wrong_file_is_status_2_and_named(mikas, tmp_path, name, lang):
    if WRONG[name] is not None:
        (tmp_path / name).write_bytes(WRONG[name])
    for argv in (("sim", "--unit", name), ("read", "--port", f"sim:?unit={name}")):
        ran = mikas(*argv, "--lang", lang)
        assert ran.status == 2
        assert name in ran.err
        is_one_short_paragraph(ran.err)
        assert ".." not in ran.err
        if lang == "ru":
            is_russian(ran.err, names=("turn", "round"))
    if name == "other.zip":
        assert "turn_round" in mikas("sim", "--unit", name).err


@pytest.mark.parametrize("more", [("--replay", "a.pcapng"), ("--model", "7.1")])
def test_what_the_file_says_can_not_be_given_as_well(mikas, survey, more):
    ran = mikas("sim", "--unit", "survey.zip", *more)
    assert ran.status == 2
    assert "unit" in ran.err
