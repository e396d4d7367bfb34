"""Formulas that name an instrument, in the dashboard: actions, searches, channels of one's own."""

from __future__ import annotations

import pytest

from dashboard.rig import rig

IDLE = "sim:?scenario=warm-idle"
METER = {"definition": "aem", "port": "sim:"}

LEAN = {"name": "lean", "when": "LAMBDA > 0.5 and FREQ > 100", "hold": 1, "sound": True}
LEANER = {
    "new": True,
    "text": {"en": "Leaner than asked", "ru": "Беднее расчётного"},
    "formula": "LAMBDA - FREQ / 1000",
    "decimals": 3,
}


def until_value(it, name):
    def has(message):
        data = message.get("data")
        return (
            data is not None
            and name in data["names"]
            and data["values"][data["names"].index(name)][-1] is not None
        )

    it.until(has)


def test_an_action_fires_on_a_meter_that_is_added_later(idle):
    idle.put("/actions", {"rules": [LEAN]})
    tried = idle.post("/actions/try", LEAN)
    assert (tried["problem"], tried["value"], tried["count"]) == (None, None, 0)
    with idle.live() as live:
        idle.post("/instruments", METER)

        def fired(message):
            return [e for e in message.get("events", []) if e["kind"] == "action"]

        (event,) = fired(live.until(fired))
    assert (event["name"], event["text"]["en"]) == ("lean", f"Action lean: {LEAN['when']}")
    tried = idle.post("/actions/try", LEAN)
    assert (tried["value"], tried["count"]) == (1, 1)


def test_a_rule_of_a_labelled_meter_is_kept_while_it_is_away(tmp_path):
    rule = {**LEAN, "when": "LAMBDA_LEFT > 0.5"}
    with rig(tmp_path, IDLE) as it:
        problem = it.put("/actions", {"rules": [rule]}, 400)["en"]
        assert "LAMBDA_LEFT" in problem
        assert "nearest is LAMBDA" in problem
        it.post("/instruments", METER | {"label": "left"})
        it.put("/actions", {"rules": [rule, {**LEAN, "name": "other", "when": "FREQ > 1"}]})
    with rig(tmp_path, IDLE) as it:
        assert it.get("/actions")["problem"] is None
        it.delete("/instruments/left:aem")
        assert [each["name"] for each in it.get("/actions")["rules"]] == ["lean", "other"]
    with rig(tmp_path, IDLE) as it:
        assert "LAMBDA_LEFT" in it.get("/actions")["problem"]["en"]
        it.post("/instruments", METER | {"label": "left"})
        assert it.get("/actions")["problem"] is None
        assert len(it.get("/actions")["rules"]) == 2


def test_moments_of_a_meter_are_found_live_and_recorded(idle):
    idle.post("/instruments", METER | {"label": "left"})
    idle.post("/recording/start", {"name": "drive"})
    until_value(idle, "LAMBDA_LEFT")
    idle.until(lambda it: (it["state"]["recording"] or {"samples": 0})["samples"] > 20)
    idle.post("/recording/stop")
    expression = "LAMBDA_LEFT > 0.5 and FREQ > 100"
    live = idle.get("/history/find", expression=expression)
    assert live["count"] >= 1
    assert live["peak_of"] == "LAMBDA_LEFT"
    assert live["hits"][0]["peak"] == pytest.approx(1, abs=0.3)
    idle.delete("/instruments/left:aem")
    found = idle.get("/recordings/drive.pcapng/find", expression=expression)
    assert found["hits"][0]["peak"] == pytest.approx(1, abs=0.3)
    unknown = idle.get("/history/find", 400, expression=expression)
    assert unknown["code"] == "UnknownParameter"
    gone = idle.get("/recordings/drive.pcapng/find", 400, expression="GPS_SPEED > 1")
    assert "GPS_SPEED: not in this recording" in gone["en"]
    kept = {"searches": [{"name": "", "expression": expression}]}
    assert idle.put("/searches", kept) == kept
    wrong = {"searches": [{"expression": "LAMDBA_LEFT > 1"}]}
    assert idle.put("/searches", wrong, 400)["code"] == "UnknownParameter"


def test_a_channel_of_ones_own_is_computed_from_a_meter_and_the_unit(idle):
    idle.post("/instruments", METER)
    until_value(idle, "LAMBDA")
    tried = idle.post("/channels/try", {"formula": "LAMBDA - FREQ / 1000"})
    assert tried["problem"] is None
    assert [each["name"] for each in tried["inputs"]] == ["LAMBDA", "FREQ"]
    assert tried["value"] == pytest.approx(
        tried["inputs"][0]["value"] - tried["inputs"][1]["value"] / 1000
    )
    wrong = idle.post("/channels/try", {"formula": "LAMDBA - FREQ"})
    assert "the nearest is LAMBDA" in wrong["problem"]["en"]
    idle.put("/channels/LEANER", LEANER)
    idle.put("/plan", {"wanted": [{"name": "FREQ"}, {"name": "LEANER"}]})
    until_value(idle, "LEANER")
    assert idle.get("/channels/LEANER/value")["value"] == pytest.approx(0, abs=0.3)


WAY = {"new": True, "text": {"en": "Way", "ru": "Путь"}, "formula": "GPS_SPEED / 3600"}


def test_what_instruments_alone_give_is_sampled_beside_a_parameter(idle):
    idle.put("/channels/WAY", WAY)
    idle.put("/channels/TWICE", {**WAY, "formula": "FREQ * 2"})
    alone = {"wanted": [{"name": "WAY"}]}
    assert "name a parameter of the unit" in idle.put("/plan", alone, 400)["en"]
    both = {"wanted": [{"name": "WAY"}, {"name": "TWICE"}]}
    idle.put("/plan", both)
    price = idle.post("/plan/price", both)
    assert price["more"]["TWAT"]["seconds"] >= 0
    assert "nothing is chosen" in idle.post("/plan/price", alone, 400)["en"]
    idle.put("/plan/first", {"names": ["WAY"]})
    idle.delete("/channels/TWICE")
    idle.post("/instruments", {"definition": "nmea", "port": "sim:"})
    until_value(idle, "WAY")
    assert idle.get("/state")["samples"] > 0
