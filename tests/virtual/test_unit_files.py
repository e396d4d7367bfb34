"""A unit from a file (`sim:?unit=FILE`), and what is said of a wrong or a hostile one."""

from __future__ import annotations

import io
import json
import sys
import zipfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import mikas
from mikas.errors import BadPortUrl, UnfitFile, UsageError
from mikas.virtual.build import build_bus
from mikas.virtual.quirks import ChecksumForm
from mikas.virtual.unit_files import MOST_BYTES, load, read
from mikas.virtual.unit_profile import CodeProfile, UnitProfile

from .profile_strategies import profiles

PROFILE = UnitProfile(
    version_code=0x09,
    echo=False,
    missing=frozenset({0x71}),
    max_list_61=2,
    sends=ChecksumForm.RAW,
    codes={0x1A: CodeProfile(1, (b"\x7d",)), 0x33: CodeProfile(2, (b"\x01\x02",))},
    passports=("209.3763", *[""] * 7),
    faults=(53, 13),
)


def survey(profile: UnitProfile, **more: bytes) -> bytes:
    """A survey's archive."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("README.txt", "ru, en")
        archive.writestr("unit.json", json.dumps(profile.to_json()))
        for name, data in more.items():
            archive.writestr(name, data)
    return out.getvalue()


@pytest.fixture(params=["a survey.zip", "unit.json"])
def file(request, tmp_path) -> Path:
    path = tmp_path / request.param
    data = survey(PROFILE) if path.suffix == ".zip" else json.dumps(PROFILE.to_json()).encode()
    path.write_bytes(data)
    return path


@given(profiles())
def test_the_profile_of_a_survey_is_read(profile):
    assert read(io.BytesIO(survey(profile)), "a.zip") == profile
    assert read(io.BytesIO(json.dumps(profile.to_json()).encode()), "unit.json") == profile


def test_a_port_is_the_unit_of_a_file(file):
    assert load(file) == PROFILE
    with mikas.connect(f"sim:?clock=simulated&unit={file}") as ecu:
        info = ecu.info()
        assert info.version_code == 0x09
        assert info.passport.program[0] == "209.3763"
        assert not info.echo
        assert [fault.code for fault in ecu.faults()] == [53, 13]
        assert next(iter(ecu.read("0x33:2").values())).raw == b"\x01\x02"


def test_settings_change_the_unit_of_a_file(file):
    bus = build_bus({"unit": str(file), "scenario": "city", "echo": "1", "max_list_61": "5"})
    responder = bus.ecu.responder
    assert bus.adapter.kind.echo
    assert responder.quirks.max_list_61 == 5
    assert responder.quirks.raw_checksum
    assert build_bus({"unit": str(file), "faults": "13,17"}).ecu.responder.car.faults == [
        53,
        13,
        17,
    ]


def test_the_model_is_that_of_the_file(file):
    with pytest.raises(UsageError, match="model can't be set"):
        build_bus({"unit": str(file), "model": "7.1"})


def in_zip(unit: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("unit.json", unit)
    return out.getvalue()


HOSTILE = {
    "empty": (b"", "is no JSON"),
    "text": (b"hello", "mikas survey -o"),
    "no member": (
        survey(PROFILE).replace(b"unit.json", b"unit.jsox"),
        "has no unit.json: it must be the ZIP that “mikas survey -o FILE.zip” has saved",
    ),
    "cut": (survey(PROFILE)[:-10], "no ZIP archive"),
    "bomb": (in_zip(b" " * (MOST_BYTES + 1)), "more than 4096 KB"),
    "long": (b" " * (MOST_BYTES + 1), "larger than 4096 KB"),
    "deep": (in_zip(b"[" * 100_000), "is no JSON"),
    "huge number": (in_zip(b'{"schema": 1, "max_block": ' + b"9" * 5000 + b"}"), "is no JSON"),
    "infinite": (in_zip(b'{"schema": 1, "turn_round": 1e999}'), "is no JSON"),
    "no text": (in_zip(b"\xff\xfe"), "is no JSON"),
    "another kind": (in_zip(b"[1]"), "must be a JSON object"),
    "newer": (in_zip(b'{"schema": 2}'), "schema must be 1"),
    "wrong type": (in_zip(b'{"schema": 1, "codes": {"1A": {"size": "2"}}}'), "codes.1A.size must"),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_a_wrong_or_hostile_file_is_named_with_what_is_wrong(kind, tmp_path):
    data, expected = HOSTILE[kind]
    path = tmp_path / "a.zip"
    path.write_bytes(data)
    with pytest.raises(UsageError) as caught:
        build_bus({"unit": str(path)})
    en, ru = caught.value.text
    assert en.startswith(f"{path}: ")
    assert expected in en
    assert str(path) in ru
    assert ru != en
    with pytest.raises(BadPortUrl, match=r"a\.zip"):
        mikas.connect(f"sim:?unit={path}")


def test_a_missing_file_and_a_folder_are_named(tmp_path):
    for name in ("nosuch.zip", "."):
        with pytest.raises(UsageError) as caught:
            load(tmp_path / name)
        assert isinstance(caught.value, OSError)


def test_the_page_without_files_says_so(monkeypatch):
    """It has not the modules that read them."""
    monkeypatch.setitem(sys.modules, "mikas.virtual.unit_files", None)
    with pytest.raises(BadPortUrl, match="needs mikas on a computer") as caught:
        mikas.connect("sim:?clock=simulated&unit=survey.zip")
    assert "на компьютере" in caught.value.text.ru


SURVEY = survey(PROFILE)


@given(st.lists(st.tuples(st.integers(0, len(SURVEY) - 1), st.integers(0, 255)), max_size=4))
def test_a_damaged_survey_is_a_profile_or_an_error(changes):
    data = bytearray(SURVEY)
    for at, value in changes:
        data[at] = value
    try:
        read(io.BytesIO(data), "a.zip")
    except (UsageError, UnfitFile) as error:
        assert error.text.ru
