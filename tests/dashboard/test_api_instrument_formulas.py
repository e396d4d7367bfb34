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


def actions(message):
    return [e for e in message.get("events", []) if e["kind"] == "action"]


def acted(name):
    return lambda message: [e for e in actions(message) if e["name"] == name]


def test_an_action_fires_on_a_meter_that_is_added_later(idle):
    idle.put("/actions", {"rules": [LEAN]})
    tried = idle.post("/actions/try", LEAN)
    assert (tried["problem"], tried["value"], tried["count"]) == (None, None, 0)
    with idle.live() as live:
        idle.post("/instruments", METER)
        (event,) = actions(live.until(actions))
    assert (event["name"], event["text"]["en"]) == ("lean", f"Action lean: {LEAN['when']}")
    tried = idle.post("/actions/try", LEAN)
    assert (tried["value"], tried["count"]) == (1, 1)


def test_a_rule_of_a_labelled_meter_rests_while_it_is_away_and_the_others_act(tmp_path):
    rule = {**LEAN, "when": "LAMBDA_LEFT > 0.5"}
    other = {**LEAN, "name": "other", "when": "FREQ > 100"}
    left = METER | {"label": "left"}
    with rig(tmp_path, IDLE) as it:
        problem = it.put("/actions", {"rules": [rule]}, 400)["en"]
        assert "LAMBDA_LEFT" in problem
        assert "nearest is LAMBDA" in problem
        it.post("/instruments", left)
        assert it.put("/actions", {"rules": [rule, other]})["waits"] == {}
        it.delete("/instruments/left:aem")
    with rig(tmp_path, IDLE) as it, it.live() as live:
        found = it.get("/actions")
        assert found["problem"] is None
        assert [each["name"] for each in found["rules"]] == ["lean", "other"]
        assert list(found["waits"]) == ["lean"]
        assert "LAMBDA_LEFT" in found["waits"]["lean"]["en"]
        assert "Connection" in found["waits"]["lean"]["en"]
        live.until(acted("other"))
        it.post("/actions/lean/perform")
        it.post("/instruments", left)
        found = it.get("/actions")
        assert (found["waits"], len(found["rules"])) == ({}, 2)
        live.until(acted("lean"))


def test_rules_are_saved_while_the_meter_of_one_is_away(tmp_path):
    rule = {**LEAN, "when": "LAMBDA_LEFT > 0.5"}
    with rig(tmp_path, IDLE) as it:
        it.post("/instruments", METER | {"label": "left"})
        it.put("/actions", {"rules": [rule]})
        it.delete("/instruments/left:aem")
        assert list(it.get("/actions")["waits"]) == ["lean"]
        more = {**LEAN, "name": "more", "when": "LAMBDA_LEFT > 2 and FREQ > 1"}
        kept = it.put(
            "/actions", {"rules": [rule, {**LEAN, "name": "b", "when": "FREQ > 1"}, more]}
        )
        assert list(kept["waits"]) == ["lean", "more"]
        wrong = {**LEAN, "name": "c", "when": "LAMBDA_RIGHT > 1"}
        assert "LAMBDA_RIGHT" in it.put("/actions", {"rules": [rule, wrong]}, 400)["en"]
    with rig(tmp_path, IDLE) as it:
        assert [each["name"] for each in it.get("/actions")["rules"]] == ["lean", "b", "more"]
        tried = it.post("/actions/try", rule)
        assert (tried["problem"], tried["value"]) == (None, None)
        assert "LAMBDA_LEFT" in tried["waits"]["en"]


def test_a_meter_that_comes_does_not_let_the_other_rules_act_once_more(tmp_path):
    once = {**LEAN, "name": "once", "when": "FREQ > 100", "once": True}
    left = METER | {"label": "left"}
    with rig(tmp_path, IDLE) as it:
        it.post("/instruments", left)
        it.put("/actions", {"rules": [{**LEAN, "when": "LAMBDA_LEFT > 0.5"}]})
        it.delete("/instruments/left:aem")
        it.put("/actions", {"rules": [{**LEAN, "when": "LAMBDA_LEFT > 0.5"}, once]})
        seen = []
        with it.live() as live:
            live.until(acted("once"))
            it.post("/instruments", left)
            live.until(lambda message: seen.extend(actions(message)) or acted("lean")(message))
        assert [each["name"] for each in seen] == ["lean"]


def test_a_rule_on_a_meter_that_is_not_there_says_so(idle):
    tried = idle.post("/actions/try", LEAN)
    assert "No instrument beside the unit gives LAMBDA" in tried["waits"]["en"]
    assert "Connection" in tried["waits"]["en"]
    assert "LAMBDA" in tried["waits"]["ru"]
    kept = idle.put("/actions", {"rules": [LEAN]})
    assert kept["waits"] == {"lean": tried["waits"]}
    idle.post("/instruments", METER)
    assert idle.post("/actions/try", LEAN)["waits"] is None
    assert idle.get("/actions")["waits"] == {}


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


def test_a_kept_condition_does_not_keep_others_from_being_saved_while_its_meter_is_away(tmp_path):
    text = {"en": "Boost", "ru": "Наддув"}
    gauge = {
        "text": text,
        "patterns": ["{BOOST_BAR}"],
        "channels": [{"name": "BOOST_BAR", "text": text}],
    }
    boost = {"name": "", "expression": "BOOST_BAR > 1"}
    with rig(tmp_path, None) as it:
        it.put("/instruments/definitions/gauge", gauge)
        it.post("/instruments", {"definition": "gauge", "port": "/dev/ttyUSB9"})
        it.put("/searches", {"searches": [boost]})
        it.delete("/instruments/gauge")
        more = {"searches": [boost, {"name": "", "expression": "FREQ > 1"}]}
        assert it.put("/searches", more) == more
        new = {"searches": [{"name": "", "expression": "BOOST_BAR > 2"}]}
        assert it.put("/searches", new, 400)["code"] == "UnknownParameter"


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
