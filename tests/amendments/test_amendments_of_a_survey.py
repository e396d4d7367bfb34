"""From a real survey's ZIP, made of a virtual unit, to a patch that `git apply` takes."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.amendments import patch, propose
from mikas.amendments.proposing import _ports
from mikas.catalog import shipped
from mikas.catalog.evidence import Agreement
from mikas.errors import UsageError
from mikas.link.base import Direction
from mikas.survey.recording import SurveyCapture
from survey.survey_harness import Beside, drive, surveyed, url_of

ROOT = Path(__file__).parents[2]
INSTRUMENTS = {"voltmeter": 12.6, "tachometer": 870.0}


@pytest.fixture(scope="module")
def survey(tmp_path_factory):
    """A whole survey, with the engine and instruments, of a unit that counts its blocks (D7)."""
    folder = tmp_path_factory.mktemp("survey")
    out = folder / "unit.zip"
    surveyed(url_of(drive(folder), counted_blocks=1), out, Beside(INSTRUMENTS), memory=True)
    return out


def by_name(proposal):
    return {name: each for each in proposal.amendments for name in each.of}


def test_a_whole_survey_settles_what_it_has_found(survey):
    proposal = propose(survey, shipped())
    found = by_name(proposal)
    assert found["D7"].agreement is Agreement.DIFFERS
    assert found["D15"].agreement is Agreement.AGREES
    assert found["D11"].agreement is Agreement.SHOWS
    assert found["TWAT"].agreement is Agreement.AGREES
    assert found["E3"].agreement is Agreement.DIFFERS
    assert found["D14"].text.en.startswith("least pause before a request: ")
    assert found["E1"].text.ru.startswith("единица FREQ: b · 40 — это мин⁻¹")
    assert {each.id for each in proposal.open} == {
        "long_list", "list_bytes", "bad_write", "writes",
    }  # fmt: skip
    assert proposal.is_virtual
    assert proposal.unit.startswith("virtual 0A, survey ")
    assert propose(survey, shipped()) == proposal


def test_a_survey_without_the_engine_leaves_the_errata_open(tmp_path):
    out = tmp_path / "unit.zip"
    url = url_of(drive(tmp_path, starts=3000.0, raises=3100.0), model="5.4", missing="71")
    surveyed(url, out, engine=False)
    proposal = propose(out, shipped())
    found = by_name(proposal)
    assert found["71"].agreement is Agreement.DIFFERS
    assert not {"E1", "E3", "FREQ_", "D7", "D15"} & set(found)
    assert not any(each.changes for each in proposal.amendments)
    assert proposal.unit.startswith("virtual 09, survey ")
    assert {"freq", "fuel_factors", "counted_blocks"} <= {each.id for each in proposal.open}


def test_the_file_says_nothing_of_the_passports(survey, tmp_path):
    out = tmp_path / "unit.zip"
    surveyed(url_of(drive(tmp_path)), out, Beside(INSTRUMENTS), passports=True)
    with zipfile.ZipFile(out) as packed:
        texts = json.loads(packed.read("unit.json"))["passports"]
    proposal = propose(out, shipped())
    diff = patch(proposal.amendments, proposal.unit)
    assert any(texts)
    assert not any(text in diff for text in texts if text)


def run(*argv, cwd, **settings):
    own = {key: value for key, value in os.environ.items() if not key.startswith("GIT_")}
    return subprocess.run(
        argv, cwd=cwd, env=own | settings, check=True, capture_output=True, text=True,
        encoding="utf-8", timeout=120,
    ).stdout  # fmt: skip


@pytest.mark.skipif(shutil.which("git") is None, reason="needs git")
def test_the_patch_applies_to_a_copy_of_the_repository_which_then_has_it_all(survey, tmp_path):
    copy = tmp_path / "clone"
    shutil.copytree(
        ROOT / "src", copy / "src", ignore=shutil.ignore_patterns("__pycache__", "page")
    )
    run("git", "init", "-q", ".", cwd=copy)
    run("git", "add", "src", cwd=copy)
    proposal = propose(survey, shipped())
    (tmp_path / "unit.diff").write_text(patch(proposal.amendments, proposal.unit), "utf-8")
    run("git", "apply", str(tmp_path / "unit.diff"), cwd=copy)
    changed = run("git", "diff", "--name-only", cwd=copy).split()
    assert changed == [
        f"src/mikas/catalog/{name}.toml" for name in ("errata", "evidence", "parameters")
    ]
    code = (
        "from mikas.catalog import shipped; import mikas, sys;"
        "from mikas.catalog.evidence import evidence;"
        "print(mikas.__file__, shipped().parameter('RCOK').decode(b'\\x80'),"
        " shipped().parameter('UACC').confidence, len(evidence().sightings))"
    )
    inside = {"PYTHONPATH": str(copy / "src"), "PYTHONDONTWRITEBYTECODE": "1"}
    file, *values = run(sys.executable, "-c", code, cwd=tmp_path, **inside).split()
    assert Path(file).is_relative_to(copy)
    assert values == ["1.0", "confirmed", str(len(proposal.amendments))]
    again = run(
        sys.executable, "-m", "mikas", "evidence", str(survey), "--json", "--patch", "again.diff",
        cwd=tmp_path, **inside,
    )  # fmt: skip
    assert json.loads(again)["patch"] is None
    assert not (tmp_path / "again.diff").exists()
    shown = run(sys.executable, "-m", "mikas", "evidence", "D7", cwd=tmp_path, **inside)
    assert f"{proposal.unit}: form of 23 and 25: 23 and 25 repeat the count" in shown


def remade(zipped, out, **changed):
    """Writes the survey with changed members: what a function makes of their JSON."""
    with zipfile.ZipFile(zipped) as old, zipfile.ZipFile(out, "w") as new:
        for name in old.namelist():
            data = old.read(name)
            if change := changed.get(name.partition(".")[0]):
                data = json.dumps(change(json.loads(data))).encode()
            new.writestr(name, data)
    return out


def test_words_of_a_stranger_do_not_get_into_the_patch(survey, tmp_path):
    def forged(content):
        for answer in content["answers"]:
            answer["text"] = {"en": '"]\n[evil]', "ru": "зло"}
        return content

    proposal = propose(remade(survey, tmp_path / "forged.zip", survey=forged), shipped())
    assert proposal == propose(survey, shipped())


@pytest.mark.parametrize(
    "change",
    [
        {"survey": lambda content: content | {"measured": {}}},
        {"survey": lambda content: content | {"measured": content["measured"] | {"codes": [1]}}},
        {"survey": lambda content: content | {"measured": content["measured"] | {"memory": True,
                                              "blocks": {"23": 7}}}},
        {"unit": lambda content: content | {"version_code": "no"}},
    ],
)  # fmt: skip
def test_figures_that_no_survey_measures_are_refused_with_the_file(survey, tmp_path, change):
    damaged = remade(survey, tmp_path / "damaged.zip", **change)
    with pytest.raises(UsageError, match=r"damaged\.zip"):
        propose(damaged, shipped())


def places(value, path=()):
    """Yields the path of every value in JSON, of a long list of its first three."""
    inside = value.items() if isinstance(value, dict) else ()
    inside = enumerate(value[:3]) if isinstance(value, list) else inside
    for key, each in inside:
        yield (*path, key)
        yield from places(each, (*path, key))


VALUES = (
    None, True, -1, 0, 1e308, 10**40, "", "zz", "0A", "FFFFFF", "é" * 5000, [], {}, [1], ["FF"],
    ["FFFF"], {"a": 1},
)  # fmt: skip


@given(
    st.lists(st.tuples(st.integers(0, 1 << 20), st.sampled_from(VALUES)), min_size=1, max_size=3)
)
@settings(max_examples=30)  # each makes a patch of four files
def test_whatever_the_figures_are_they_are_judged_or_refused(survey, changes):
    def damage(content):
        for number, value in changes:
            known = list(places(content["measured"]))
            *path, last = known[number % len(known)]
            inside = content["measured"]
            for key in path:
                inside = inside[key]
            inside[last] = value
        return content

    damaged = remade(survey, survey.with_name("any.zip"), survey=damage)
    with suppress(UsageError):
        proposal = propose(damaged, shipped())
        patch(proposal.amendments, proposal.unit)


def test_a_voltmeter_without_a_byte_of_uacc_settles_nothing(survey, tmp_path):
    def without(content):
        content["measured"]["voltage"]["raw"] = ["FFFF"]
        return content

    proposal = propose(remade(survey, tmp_path / "other.zip", survey=without), shipped())
    assert "uacc_scale" in {each.id for each in proposal.open}


def test_what_is_no_survey_is_refused(tmp_path):
    (tmp_path / "not.zip").write_bytes(b"PK\x03\x04 no")
    with pytest.raises(UsageError, match="no ZIP archive"):
        propose(tmp_path / "not.zip", shipped())


@pytest.mark.parametrize(
    ("url", "kind"),
    [("/dev/pts/3", "pty"), ("/dev/ttyUSB0", "serial"), ("replay:a.pcapng", "replay")],
)
def test_a_virtual_unit_on_a_pty_is_no_evidence_either(tmp_path, url, kind):
    capture = SurveyCapture(tmp_path, url=url, baud=9600, began=0.0, before=0.0)
    capture.record(Direction.SENT, b"\x01\xff\x0d", 1.0)
    capture.close()
    data = (tmp_path / "capture-1.pcapng").read_bytes()
    assert kind.encode() in data
    assert b"pts" not in data
    assert _ports(data) == {kind}


def test_a_survey_that_went_on_at_a_virtual_unit_is_of_one(survey, tmp_path):
    capture = SurveyCapture(tmp_path, url="/dev/ttyUSB0", baud=9600, began=0.0, before=0.0)
    capture.record(Direction.SENT, b"\x01\xff\x0d", 1.0)
    capture.close()
    real = (tmp_path / "capture-1.pcapng").read_bytes()
    with zipfile.ZipFile(survey) as old:
        virtual = old.read("capture.pcapng")
    for data, is_virtual in ((real, False), (real + virtual, True)):
        out = with_capture(survey, tmp_path / "unit.zip", data)
        assert propose(out, shipped()).is_virtual is is_virtual


@pytest.mark.parametrize("data", [b"", bytes(1000)])
def test_figures_without_the_bytes_behind_them_are_no_evidence(survey, tmp_path, data):
    with pytest.raises(UsageError, match="no byte of the line"):
        propose(with_capture(survey, tmp_path / "bare.zip", data), shipped())


def with_capture(zipped, out, data):
    """Writes the survey with another capture."""
    with zipfile.ZipFile(zipped) as old, zipfile.ZipFile(out, "w") as new:
        for name in old.namelist():
            new.writestr(name, data if name == "capture.pcapng" else old.read(name))
    return out
