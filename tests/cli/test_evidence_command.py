"""`mikas evidence`: what everything rests on, and what a survey would change."""

from __future__ import annotations

from pathlib import Path

import pytest

from mikas.catalog import shipped
from mikas.catalog.grounds import grounds_of
from mikas.cli.failures import USAGE
from survey.survey_harness import Beside, drive, surveyed, url_of


def test_everything_is_listed_without_a_port(mikas):
    ran = mikas("evidence", "--json", sim="&supplied=0")
    listed = ran.object["evidence"]
    assert [each["name"] for each in listed] == [each.name for each in grounds_of(shipped())]
    by_name = {each["name"]: each for each in listed}
    assert set(by_name["E3"]) == {
        "name", "kind", "text", "source", "siblings", "sources", "confidence", "parts", "seen",
    }  # fmt: skip
    assert by_name["E3"]["source"] == {"en": "letter; odd", "ru": "буква; странная"}
    assert by_name["fault 13"]["sources"] == ["S1"]
    assert "apk76.ru" in ran.object["sources"]["S1"]["en"]
    assert by_name["UACC"]["parts"][1] == {
        "name": "limits", "confidence": "reported", "source": "S1, faults 25 and 26",
    }  # fmt: skip


def test_in_text_a_name_has_a_line_and_one_for_each_statement_of_its_own(mikas):
    ran = mikas("evidence", "uacc", "13")
    rows = [line.split("\t") for line in ran.lines]
    assert [row[0] for row in rows] == ["name", "13", "UACC", "", "", "", "fault 13", ""]
    assert rows[2][2:] == [
        "letter of the formula; the type is impossible",
        "5.2 + b/20, another formula. A voltmeter settles it: 12.0 V is 120 here, 136 there",
        "no",
        "one source",
    ]
    assert rows[3][1:] == ["warm idle", "", "", "", "unconfirmed"]
    assert rows[6][2] == "S1"
    assert "S1: apk76.ru" in ran.err
    assert "\tмолчит\t" in mikas("evidence", "D11", "--lang", "ru").out


def test_everything_in_text_has_one_line_each(mikas):
    assert len(mikas("evidence").lines) == len(grounds_of(shipped())) + 1


def test_a_name_that_there_is_not_is_wrong_usage(mikas):
    ran = mikas("evidence", "TWTA")
    assert ran.status == USAGE
    assert "the nearest is TWAT" in ran.err


@pytest.fixture(scope="module")
def survey(tmp_path_factory):
    """The ZIP of a survey with the engine standing and a voltmeter."""
    folder = tmp_path_factory.mktemp("survey")
    url = url_of(drive(folder, starts=3000.0, raises=3100.0), unknown="01", missing="71")
    surveyed(url, folder / "unit.zip", Beside({"voltmeter": 12.6}), engine=False)
    return str(folder / "unit.zip")


def test_a_survey_shows_what_it_would_change(mikas, survey):
    ran = mikas("evidence", survey, "--json").object
    assert set(ran) == {"schema", "unit", "amendments", "open", "patch"}
    assert ran["unit"].startswith("virtual 0A, survey ")
    assert ran["patch"] is None
    found = {name: each for each in ran["amendments"] for name in each["of"]}
    assert found["D10"]["text"]["en"] == "unknown commands: the unit answers 01"
    assert found["71"]["agreement"] == "differs"
    assert found["UACC"]["changes"] == [
        {"file": "parameters.toml", "family": "parameter", "name": "UACC",
         "keys": {"confidence": "confirmed"}},
    ]  # fmt: skip
    still = {each["id"]: each for each in ran["open"]}
    assert still["fuel_factors"]["clauses"] == ["E3"]
    assert set(still["fuel_factors"]["text"]) == {"en", "ru"}


def test_a_survey_in_text_has_a_line_an_answer_and_notes_on_what_is_open(mikas, survey):
    ran = mikas("evidence", survey)
    rows = {line.split("\t")[0]: line.split("\t")[1:] for line in ran.lines}
    assert rows["D10"] == ["settles what is open", "unknown commands: the unit answers 01", ""]
    assert rows["71"] == ["differs", "the unit has not answered it", ""]
    assert rows["E2 UACC"][2] == "UACC: confidence;"
    assert "E3, open: the survey was made without the engine" in ran.err
    assert "survey of a virtual unit: evidence of nothing" in ran.err
    assert "survey it through socket: or rfc2217:" in ran.err.replace("\n", " ")
    assert "--patch OUT.diff" in ran.err
    assert "E3, открыто: " in mikas("evidence", survey, "--lang", "ru").err


def test_the_patch_is_written_once(mikas, survey):
    ran = mikas("evidence", survey, "--patch", "unit.diff")
    text = Path("unit.diff").read_text("utf-8")
    assert text.startswith("--- a/src/mikas/catalog/evidence.toml\n+++ b/src/mikas/catalog/")
    assert '+confidence = "confirmed"\n' in text
    assert "git apply unit.diff" in ran.err
    Path("unit.diff").write_text("mine", "utf-8")
    refused = mikas("evidence", survey, "--patch", "unit.diff")
    assert refused.status == USAGE
    assert "--overwrite" in refused.err
    assert Path("unit.diff").read_text("utf-8") == "mine"
    ran = mikas("evidence", survey, "--patch", "unit.diff", "--overwrite", "--json")
    assert ran.object["patch"] == "unit.diff"
    assert Path("unit.diff").read_text("utf-8") == text


def test_a_survey_stands_alone_and_is_one(mikas, survey):
    Path("not.zip").write_text("no survey", "utf-8")
    for argv, reason in (
        ([survey, "D11"], "no other name with it"),
        ([survey, survey], "no other name with it"),
        (["D11", "--patch", "unit.diff"], "no other name with it"),
        (["--patch", "unit.diff"], "no other name with it"),
        (["absent.zip"], "absent.zip"),
        (["not.zip"], "no ZIP archive"),
    ):
        ran = mikas("evidence", *argv)
        assert (ran.status, reason in ran.err) == (USAGE, True), argv
    assert not Path("unit.diff").exists()
