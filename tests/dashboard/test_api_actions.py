"""Actions on conditions in the dashboard: kept as TOML, followed live, tried on past values."""

from __future__ import annotations

import errno
import sys

import pytest

from dashboard.rig import ME, OTHER, rig

IDLE = "sim:?scenario=warm-idle"
RUNS = {
    "name": "runs", "when": "FREQ > 100", "hold": 2, "until": "FREQ < 50",
    "mark": {"en": "engine at {FREQ}", "ru": ""}, "sound": True,
    "speak": {"en": "Runs", "ru": "Работает"},
}  # fmt: skip


def put(it, *rules, status=200, headers=ME, **more):
    return it.put("/actions", {"rules": list(rules), **more}, status, headers)


def done(it, name):
    """The event of an action, when it comes."""

    def of(message):
        return [e for e in message.get("events", []) if e["kind"] == "action" and e["name"] == name]

    return of(it.until(of))[0]


@pytest.fixture
def recording(idle):
    idle.post("/recording/start", {"name": "drive"})
    return idle


def test_there_are_none_at_first(idle):
    assert idle.get("/actions") == {
        "rules": [], "broker": "", "topic": "", "problem": None, "waits": {},
        "network": sys.platform != "emscripten",
        "file": str(idle.dashboard.settings.in_state("actions.toml")),
    }  # fmt: skip


def test_a_rule_acts_once_its_condition_has_held_and_pages_hear_of_it(recording):
    with recording.live() as live:
        kept = put(recording, RUNS)["rules"]
        assert kept == [
            {
                **RUNS,
                "mark": {"en": "engine at {FREQ}", "ru": "engine at {FREQ}"},
                "again": 0, "once": False, "record": None, "mqtt": False, "webhook": "",
            }
        ]  # fmt: skip
        found = live.until(lambda it: any(e["kind"] == "action" for e in it.get("events", [])))
        (event,) = [e for e in found["events"] if e["kind"] == "action"]
    assert (event["name"], event["sound"], event["failed"]) == ("runs", True, False)
    assert event["speak"] == {"en": "Runs", "ru": "Работает"}
    recording.post("/recording/stop")
    identity = recording.get("/recordings")["recordings"][0]["id"]
    events = recording.get(f"/recordings/{identity}")["events"]
    (marker,) = [e for e in events if e["kind"] == "marker"]
    assert marker["label"].startswith("engine at 8")


def test_a_rule_starts_a_recording_and_another_ends_it(idle):
    start = {"name": "start", "when": "FREQ > 100", "record": "start"}
    stop = {"name": "stop", "when": "FREQ > 100", "hold": 20, "record": "stop"}
    with idle.live() as live:
        put(idle, start, stop)
        live.until(lambda it: it["state"]["recording"] is not None)
        live.until(lambda it: it["state"]["recording"] is None)
    assert len(idle.get("/recordings")["recordings"]) == 1


def test_two_rules_that_start_a_recording_in_one_instant_start_one(idle):
    rules = [{"name": name, "when": "FREQ > 100", "record": "start"} for name in ("a", "b", "c")]
    seen = []

    def is_later(message):
        seen.extend(e for e in message.get("events", []) if e["kind"] in ("action", "recording"))
        return any(e["kind"] == "action" and e["name"] == "later" for e in seen)

    with idle.live() as live:
        put(idle, *rules, {"name": "later", "when": "FREQ > 100", "hold": 20, "mark": {"en": "x"}})
        live.until(is_later)
    assert [e["kind"] for e in seen if e["kind"] == "recording"] == ["recording"]
    assert not any(e["failed"] for e in seen if e["kind"] == "action")
    assert len(idle.get("/recordings")["recordings"]) == 1


def test_rules_are_a_file_that_a_person_can_read_and_they_outlive_the_program(tmp_path):
    with rig(tmp_path, None) as it:
        put(it, RUNS)
        file = it.dashboard.settings.in_state("actions.toml")
        text = file.read_text("utf-8")
        assert 'when = "FREQ > 100"' in text
        assert "for = 2" in text
    with rig(tmp_path, None) as it:
        assert [rule["name"] for rule in it.get("/actions")["rules"]] == ["runs"]
    file.write_text(text.replace("FREQ > 100", "FREK > 100").replace("{FREQ}", ""), "utf-8")
    with rig(tmp_path, None) as it:
        found = it.get("/actions")
        assert (found["problem"], len(found["rules"])) == (None, 1)
        assert "FREK" in found["waits"]["runs"]["en"]
        assert "ближайшее — FREQ" in found["waits"]["runs"]["ru"]
    file.write_text(text.replace("FREQ > 100", "FREQ >"), "utf-8")
    with rig(tmp_path, None) as it:
        found = it.get("/actions")
        assert found["rules"] == []
        assert "actions.toml:2" in found["problem"]["en"]
        assert "ошибка в записи" in found["problem"]["ru"]
        put(it, RUNS)
        assert it.get("/actions")["problem"] is None
    assert "FREQ >" in file.with_name("actions.toml.broken").read_text("utf-8")


@pytest.mark.parametrize(
    ("wish", "says"),
    [
        ({"name": "a", "when": "FREQ >", "sound": True}, "not a formula"),
        ({"name": "a", "when": "FREK > 1", "sound": True}, "nearest is FREQ"),
        ({"name": "a", "when": "FREQ > 1"}, "does nothing"),
        ({"name": "a b", "when": "FREQ > 1", "sound": True}, "pattern"),
        ({"name": "a", "when": "FREQ > 1", "hold": -1, "sound": True}, "0 or more"),
        ({"name": "a", "when": "FREQ > 1", "webhook": "http://10.0.0.1/"}, "not this computer"),
        ({"name": "a", "when": "FREQ > 1", "mqtt": True}, "broker"),
        ({"name": "a", "when": "FREQ > 1", "mark": {"en": "{TWAT}"}}, "TWAT"),
    ],
)
def test_what_makes_no_sense_is_refused_and_the_rules_before_stay(shared_idle, wish, says):
    put(shared_idle, {**RUNS, "hold": 3000})
    assert says in put(shared_idle, wish, status=400)["en"]
    assert [rule["name"] for rule in shared_idle.get("/actions")["rules"]] == ["runs"]


def test_rules_that_can_not_be_kept_are_not_used(idle, monkeypatch):
    """A full disk: the rules on the page, in the file and at work stay the same."""
    put(idle, RUNS)

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("mikas.dashboard.session.actions.save", full)
    put(idle, {**RUNS, "name": "other"}, status=400)
    assert [it["name"] for it in idle.get("/actions")["rules"]] == ["runs"]
    assert [it.name for it in idle.dashboard.actions.loaded.rules] == ["runs"]


def test_a_name_stands_for_one_rule(shared_idle):
    assert "two rules" in put(shared_idle, RUNS, RUNS, status=400)["en"]


def test_another_client_needs_control(shared_idle):
    put(shared_idle)
    assert put(shared_idle, RUNS, status=409, headers=OTHER)["code"] == "NotController"


def test_a_trial_says_when_a_rule_would_have_acted(idle):
    idle.until(lambda message: idle.get("/state")["samples"] > 40)
    tried = idle.post("/actions/try", {"name": "x", "when": "FREQ > 100"})
    assert (tried["problem"], tried["value"], tried["count"]) == (None, 1, 1)
    assert tried["seconds"] > 5
    assert tried["times"][0] < idle.get("/state")["now"]
    never = idle.post("/actions/try", {"name": "x", "when": "FREQ > 100", "hold": 3000})
    assert (never["count"], never["times"]) == (0, [])
    wrong = idle.post("/actions/try", {"name": "x", "when": "FREQ >"})
    assert "not a formula" in wrong["problem"]["en"]


def test_a_rule_is_done_as_a_trial_but_for_the_recording(idle):
    put(idle, {**RUNS, "hold": 3000, "record": "start"})
    with idle.live() as live:
        idle.post("/actions/runs/perform")
        found = live.until(lambda it: any(e["kind"] == "action" for e in it.get("events", [])))
    assert any(e["kind"] == "marker" for e in found["events"])
    assert idle.get("/state")["recording"] is None
    assert idle.post("/actions/none/perform", status=404)["code"] == "NotFound"


def test_a_webhook_that_nobody_answers_is_said_on_the_page_and_stops_nothing(idle):
    if not idle.get("/actions")["network"]:
        pytest.skip("a page has no network")
    with idle.live() as live:
        put(idle, {"name": "hook", "when": "FREQ > 100", "webhook": "http://127.0.0.1:9/x"})
        found = live.until(
            lambda it: any(e.get("failed") for e in it.get("events", []) if e["kind"] == "action")
        )
    (event,) = [e for e in found["events"] if e["kind"] == "action" and e["failed"]]
    assert "http://127.0.0.1:9/x" in event["text"]["en"]
    assert idle.sampling()["line"] == "sampling"


def test_a_rule_rests_whose_channel_a_changed_catalog_lacks_and_the_others_act(idle):
    twice = {"formula": "FREQ * 2", "text": {"en": "twice", "ru": "вдвое"}, "new": True}
    idle.put("/channels/TWICE", twice)
    other = {"name": "b", "when": "FREQ > 10", "sound": True, "hold": 3000}
    put(idle, {"name": "a", "when": "TWICE > 10", "sound": True, "hold": 3000}, other)
    version = idle.get("/catalog")["version"]
    idle.delete("/channels/TWICE", version=version)
    found = idle.get("/actions")
    assert (found["problem"], len(found["rules"]), list(found["waits"])) == (None, 2, ["a"])
    assert "TWICE" in found["waits"]["a"]["en"]
    idle.put("/channels/TWICE", twice)
    assert idle.get("/actions")["waits"] == {}
