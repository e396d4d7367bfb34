"""CO set by a meter through the API: what to write next, each byte through the gate, and back."""

from __future__ import annotations

import pytest

from dashboard.rig import OTHER, rig

IDLE = "sim:?scenario=warm-idle"
COLD = "sim:?scenario=cold-start"


@pytest.fixture
def idle(tmp_path):
    with rig(tmp_path, IDLE) as it:
        it.sampling()
        yield it


def test_what_the_unit_has_and_whether_it_is_warm_idle(idle):
    found = idle.get("/co")
    assert found["now"] == {"raw": "88", "value": pytest.approx(-0.46875)}
    assert found["problems"] == []
    assert 700 < found["values"]["FREQ"] < 1000
    assert {each["meter"]: each["within"] for each in found["meters"]} == {
        "co": 0.2, "lambda": 0.015,
    }  # fmt: skip
    idle.post("/control/take", {"force": True})
    idle.get("/co", 409, headers=OTHER)


@pytest.mark.parametrize("sign", [1, -1])
def test_step_by_step_until_the_meter_is_in_the_band_and_back_to_what_was_found(idle, sign):
    idle.post("/unlock", {})
    figures, turned = [], False
    for _ in range(12):
        raw = int(idle.get("/co")["now"]["raw"], 16)
        figures.append(max(0.1, 2.0 + sign * 0.08 * (raw - 0x88)))
        asked = {"meter": "co", "target": 0.8, "found": "88", "figures": figures}
        due = idle.post("/co/step", asked)
        assert due["problems"] == []
        turned |= due["turned"]
        if due["outcome"] != "write":
            break
        change = {"kind": "write_parameter", "name": "RCOD", "raw": due["next"]["raw"]}
        idle.post(f"/changes/{idle.post('/changes', change)['nonce']}")
    assert due["outcome"] == "set"
    assert turned == (sign < 0)
    assert int(due["now"]["raw"], 16) - 0x88 == pytest.approx(-15 * sign, abs=3)
    start = idle.get("/parameters/RCOD")["start"]
    assert start["raw"] == "88"
    change = {"kind": "write_parameter", "name": "RCOD", "raw": start["raw"]}
    idle.post(f"/changes/{idle.post('/changes', change)['nonce']}")
    assert idle.get("/co")["now"]["raw"] == "88"


def test_nothing_is_written_by_a_step_and_locked_writing_stays_locked(idle):
    due = idle.post(
        "/co/step", {"meter": "lambda", "target": 0.98, "found": "88", "figures": [1.02]}
    )
    assert (due["outcome"], due["next"]["raw"], due["now"]["raw"]) == ("write", "90", "88")
    assert "richer" in due["why"]["en"]
    change = {"kind": "write_parameter", "name": "RCOD", "raw": "90"}
    assert idle.post("/changes", change, 403)["code"] == "Locked"
    assert idle.get("/co")["now"]["raw"] == "88"


def test_a_figure_that_does_not_follow_ends_with_what_was_found(idle):
    idle.post("/unlock", {})
    figures = []
    for _ in range(4):
        figures.append(3.0)
        asked = {"meter": "co", "target": 0.8, "found": "88", "figures": figures}
        due = idle.post("/co/step", asked)
        change = {"kind": "write_parameter", "name": "RCOD", "raw": due["next"]["raw"]}
        idle.post(f"/changes/{idle.post('/changes', change)['nonce']}")
        if due["outcome"] == "stop":
            break
    assert due["outcome"] == "stop"
    assert "does not follow RCOD" in due["why"]["en"]
    assert idle.get("/co")["now"]["raw"] == "88"


def test_a_unit_that_does_not_keep_what_was_written_is_said(idle):
    due = idle.post(
        "/co/step", {"meter": "co", "target": 0.8, "found": "88", "figures": [2.0, 1.5]}
    )
    (problem,) = due["problems"]
    assert "CO potentiometer" in problem["en"]
    assert "потенциометр" in problem["ru"]


def test_a_cold_engine_and_impossible_figures_are_refused(tmp_path):
    with rig(tmp_path, COLD) as it:
        it.sampling()
        assert any("°C" in each["en"] for each in it.get("/co")["problems"])
        asked = {"meter": "co", "target": 0.8, "found": "88", "figures": [2.0]}
        assert it.post("/co/step", asked)["problems"]
        error = it.post("/co/step", {**asked, "meter": "lambda", "figures": [0.2]}, 400)
        assert "from 0.5 to 2" in error["en"]
        error = it.post("/co/step", {**asked, "within": 1.5}, 400)
        assert "up to 1" in error["en"]
        it.post("/co/step", {**asked, "figures": []}, 400)
        it.post("/co/step", {**asked, "found": "xyz"}, 400)


def test_without_a_connection_there_is_nothing_to_set(tmp_path):
    with rig(tmp_path, None) as it:
        it.get("/co", 503)
