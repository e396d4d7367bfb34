"""Each open clause is found out of a virtual unit that has it one way or the other."""

from __future__ import annotations

import pytest
from survey_harness import Beside, by_name, drive, surveyed, url_of

from mikas.survey import SurveyVerdict, conclude, read_survey
from mikas.virtual.unit_profile import UnitProfile

FOUND, OPEN, NOT_ASKED = SurveyVerdict.FOUND, SurveyVerdict.OPEN, SurveyVerdict.NOT_ASKED


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({}, {"echo": True, "unknown": "silent", "checksum_accepted": "both",
              "checksum_sent": "stuffed", "stream_end": "byte", "least_pause": 0.0,
              "inter_byte": 0.0, "max_list_61": 255, "max_list_64": 255, "max_list_71": 255,
              "tair": 1, "count": 21}),
        ({"echo": 0}, {"echo": False}),
        ({"unknown": "01"}, {"unknown": "01"}),
        ({"unknown": "01", "unknown_body": "7F05"}, {"unknown": "7F05"}),
        ({"accepts": "raw"}, {"checksum_accepted": "raw"}),
        ({"accepts": "stuffed"}, {"checksum_accepted": "stuffed"}),
        ({"raw_checksum": 1}, {"checksum_sent": "raw"}),
        ({"stream_end": "request"}, {"stream_end": "request"}),
        ({"stream_end": "break"}, {"stream_end": "break"}),
        ({"max_list_61": 7, "max_list_64": 19, "max_list_71": 3},
         {"max_list_61": 7, "max_list_64": 19, "max_list_71": 3, "long_list": "silent",
          "bad_write": "01", "list_bytes": "codes"}),
        ({"max_list": 1, "long_list": "short"},
         {"max_list_61": 1, "max_list_64": 1, "max_list_71": 1}),
        ({"max_list": 40, "long_list": "short", "bad_write": "silent"},
         {"max_list_61": 40, "long_list": "short", "bad_write": "silent"}),
        ({"counted_blocks": 1, "max_block": 33},
         {"counted_blocks": True, "max_block": {"21": 33, "23": 33, "25": 33}}),
        ({"max_list": 1, "unknown": "01", "accepts": "raw", "raw_checksum": 1},
         {"max_list_61": 1, "checksum_accepted": "raw", "checksum_sent": "raw"}),
        ({"max_block": 1, "counted_blocks": 1},
         {"counted_blocks": True, "max_block": {"21": 1, "23": 1, "25": 1}}),
        ({"missing": "21+25"}, {"counted_blocks": False, "max_block": {"23": 255}}),
        ({"faults": "13+53"}, {"faults": [13, 53]}),
        ({"model": "5.4"}, {"version": "09"}),
    ],
)  # fmt: skip
def test_what_a_standing_engine_shows(tmp_path, settings, expected):
    url = url_of(drive(tmp_path, starts=3000.0, raises=3100.0), **settings)
    found = surveyed(url, tmp_path / "unit.zip", memory=True, engine=False)
    answers = by_name(found)
    values = {name: answers[name].value for name in expected}
    assert values == expected
    assert {answers[name].verdict for name in expected} == {FOUND}
    for name in ("strokes", "stream_load", "freq", "fuel_factors", "turn_round_running"):
        assert answers[name].verdict is NOT_ASKED
        assert "without the engine" in answers[name].text.en
    assert answers["moves"].verdict is OPEN
    assert UnitProfile.from_json(found.unit).to_json() == found.unit


@pytest.mark.parametrize(
    ("settings", "name", "value", "tolerance"),
    [
        ({"least_pause": 0.083}, "least_pause", 0.083, 0.003),
        ({"least_pause": 0.012, "echo": 0}, "least_pause", 0.012, 0.003),
        ({"turn_round": 0.03}, "turn_round", 0.03, 1e-4),
        ({"inter_byte": 0.0021}, "inter_byte", 0.0021, 1e-4),
        ({"stream_gap": 0.004, "inter_byte": 0.001}, "stream_gap", 0.004, 1e-4),
    ],
)
def test_times_of_a_standing_engine(tmp_path, settings, name, value, tolerance):
    url = url_of(drive(tmp_path, starts=3000.0, raises=3100.0), **settings)
    found = surveyed(url, tmp_path / "unit.zip", engine=False)
    assert by_name(found)[name].verdict is FOUND
    assert found.unit[name] == pytest.approx(value, abs=tolerance)


def test_a_whole_survey_with_engine_and_instruments(tmp_path):
    person = Beside({"voltmeter": 12.6, "tachometer": 870.0, "starter": 9.0})
    url = url_of(drive(tmp_path), stream_load=0.4, turn_round_spread=0.001)
    found = surveyed(url, tmp_path / "unit.zip", person, passports=True)
    answers = by_name(found)
    assert [name for name, each in answers.items() if each.verdict is OPEN] == [
        "long_list", "list_bytes",
    ]  # fmt: skip
    assert answers["stream_load"].value["load"] == pytest.approx(0.4, abs=0.02)
    assert answers["strokes"].value == pytest.approx(
        dict.fromkeys(("7F", "80", "81", "82", "83"), 0.5), abs=0.02
    )
    moves = answers["moves"].value
    assert {moves[code] for code in ("29", "2C", "21", "40", "20")} == {"rpm"}
    assert {moves[code] for code in ("1C", "1E")} <= {"key", "other"}
    assert moves["08"] == moves["72"] == "constant"
    assert answers["uacc_scale"].value["formula"] == "b/10"
    assert answers["uacc_sign"].value["signed"] is False
    assert answers["freq"].value["unit"] == "min-1"
    assert answers["freq"].value["cranking"]
    assert answers["freq"].value["by_hand"] == 270
    assert "270 rpm of it timed by hand" in answers["freq"].text.en
    assert answers["fuel_factors"].value["42"]["neutral"] is True
    assert 0.95 < answers["valf"].value["value"] < 1.05
    assert found.unit["passports"][0] == "МИКАС 7.1"
    assert UnitProfile.from_json(found.unit).to_json() == found.unit

    again = read_survey(tmp_path / "unit.zip")
    assert again == found
    assert conclude(again.measured) == found.answers
    assert not (tmp_path / "unit.zip.part").exists()


def test_what_is_not_certain_stays_open(tmp_path):
    """E2 without a voltmeter, and with one that fits no formula; a unit without its codes."""
    file = drive(tmp_path, starts=3000.0, raises=3100.0)
    without = by_name(surveyed(url_of(file), tmp_path / "a.zip", engine=False))
    assert without["uacc_scale"].verdict is OPEN
    odd = Beside({"voltmeter": 15.5})
    other = by_name(surveyed(url_of(file), tmp_path / "b.zip", odd, engine=False))
    assert other["uacc_scale"].verdict is OPEN
    assert other["uacc_scale"].value["formula"] is None
    bare = by_name(surveyed(url_of(file, missing="61"), tmp_path / "c.zip", Beside(), engine=False))
    for name in ("codes", "max_list_61", "checksum_accepted", "checksum_sent"):
        assert bare[name].verdict is OPEN, name
    slow = by_name(surveyed(url_of(file, latency_ms=16), tmp_path / "d.zip", engine=False))
    assert slow["turn_round"].verdict is OPEN
    assert "16 ms" in slow["turn_round"].text.en
    assert slow["least_pause"].verdict is OPEN
    assert "less than 16 ms, which this adapter itself leaves" in slow["least_pause"].text.en


@pytest.mark.parametrize("raw", ["00", "80", "FF"])
def test_dead_bytes_of_an_ignition_unit_decide_nothing(tmp_path, raw):
    url = url_of(drive(tmp_path), ignition_only=1, model="5.4")
    measured = surveyed(url, tmp_path / "unit.zip", Beside()).measured
    measured["factors"] = {code: [raw] * 3 for code in ("42", "41", "39")}
    answers = {answer.id: answer for answer in conclude(measured)}
    for name in ("fuel_factors", "valf"):
        assert answers[name].verdict is OPEN
        assert answers[name].value is None
        assert "the ignition alone" in answers[name].text.en


def test_a_starter_timed_by_hand_that_freq_does_not_show_leaves_its_unit_open(tmp_path):
    person = Beside({"voltmeter": 12.6, "starter": 20.0})
    answer = by_name(surveyed(url_of(drive(tmp_path)), tmp_path / "unit.zip", person))["freq"]
    assert answer.verdict is OPEN
    assert "600 rpm of it timed by hand" in answer.text.en
