"""The survey through the API: led by instructions, stopped, gone on with, shown, saved."""

from __future__ import annotations

import json
import threading
from urllib.parse import quote

from dashboard.rig import OTHER, rig
from mikas.dashboard.session.survey_run import USUAL, usual_seconds
from mikas.survey import read_survey
from mikas.survey.steps.table import STEPS
from survey.survey_harness import drive

CAR = "sim:?scenario=survey"


def wait(it, accepted):
    """The first state that is accepted; a step of the fast time may take some hundredths."""
    for _ in range(6000):
        state = it.get("/survey")
        if accepted(state):
            return state
        threading.Event().wait(0.01)
    raise AssertionError(f"it never came; last: {state}")


def pass_to(it, time):
    """Lets the car's time pass to `time`: the person takes a while."""
    it.cars.clock.sleep(max(0.0, time - it.cars.clock.now()))


def step_is(name):
    return lambda it: it["step"] is not None and it["step"]["name"] == name


def ended(state):
    return state["phase"] != "running"


def test_a_survey_without_the_engine_is_shown_and_then_saved(off, tmp_path):
    assert off.get("/survey")["phase"] == "idle"
    consents = {"passports": False, "memory": False, "engine": False}
    state = off.post("/survey/start", {"port": CAR, "voltmeter": 12.4, **consents})
    assert (state["phase"], state["port"], state["consents"]) == ("running", CAR, consents)
    codes = wait(off, lambda it: step_is("codes")(it) and it["step"]["done"] > 20)
    assert (codes["step"]["regime"], codes["step"]["of"]) == ("standing", 256)
    assert 20 < codes["left"] < 200
    assert off.get("/state")["surveying"] is True
    assert off.get("/survey/result", status=409)["code"] == "Busy"
    done = wait(off, ended)
    assert (done["phase"], done["error"], done["saved"]) == ("finished", None, None)
    assert done["found"] > 15
    shown = off.get("/survey/result")
    texts = {it["name"]: it["text"] for it in shown["members"]}
    assert texts.keys() == {"README.txt", "survey.json", "unit.json", "capture.pcapng"}
    assert json.loads(texts["unit.json"])["passports"] is None
    assert json.loads(texts["survey.json"])["measured"]["voltage"]["meter"] == 12.4
    assert {it["verdict"] for it in shown["answers"]} >= {"found", "not-asked"}
    assert off.get("/survey/file", status=404)
    saved = off.post("/survey/save")
    assert (saved["phase"], saved["saved"]["name"]) == ("idle", "virtual-survey.zip")
    answer = off.get("/survey/file")
    assert answer.headers["content-disposition"] == 'attachment; filename="virtual-survey.zip"'
    file = tmp_path / "got.zip"
    file.write_bytes(answer.content)
    kept = read_survey(file)
    assert [it.id for it in kept.answers] == [it["id"] for it in shown["answers"]]
    assert len(answer.content) == saved["saved"]["bytes"]
    assert off.post("/survey/save", status=404)["code"] == "NotFound"


def test_instructions_and_questions_lead_to_the_raised_speed(tmp_path):
    file = drive(tmp_path, starts=380.0, raises=700.0, raised=300.0)
    with rig(tmp_path, None) as it:
        car = f"sim:?scenario={quote(str(file))}"
        began = it.cars.clock.now()  # the car's time is a moment later
        it.post("/survey/start", {"port": car, "engine": True, "voltmeter": None})
        start = wait(it, lambda now: now["instruction"] is not None)
        assert "START the engine" in start["instruction"]["en"]
        pass_to(it, began + 379)
        wait(it, step_is("cranking"))
        asked = wait(it, lambda now: now["asked"] is not None)["asked"]
        assert (asked["name"], asked["kind"], asked["unit"]["ru"]) == (
            "tachometer", "number", "об/мин",
        )  # fmt: skip
        low = it.post("/survey/answer", {"id": asked["id"], "figure": 5}, status=400)
        assert "from 200 to 3000 rpm" in low["en"]
        it.post("/survey/answer", {"id": asked["id"] + 1, "figure": 800}, status=409)
        late = it.post("/survey/answer", {"id": asked["id"], "figure": 850})
        assert late["asked"] is None
        it.post("/survey/answer", {"id": asked["id"], "figure": 900}, status=409)
        timed = wait(it, lambda now: now["asked"] is not None)["asked"]
        assert (timed["name"], timed["low"], timed["high"]) == ("starter", 1, 20)
        it.post("/survey/answer", {"id": timed["id"], "figure": 6.5})
        hold = wait(it, lambda now: now["instruction"] is not None)
        assert "2,500 rpm" in hold["instruction"]["en"]
        pass_to(it, began + 699)
        assert wait(it, step_is("strokes_raised"))["step"]["regime"] == "raised"
        release = wait(it, lambda now: now["instruction"] is not None)
        assert release["instruction"]["ru"] == "Отпустите педаль: снова холостой ход."
        pass_to(it, began + 1000)
        assert wait(it, ended)["phase"] == "finished"
        survey = next(
            json.loads(each["text"])
            for each in it.get("/survey/result")["members"]
            if each["name"] == "survey.json"
        )
        assert survey["measured"]["tachometer"]["shown"] == 850
        assert survey["measured"]["starter"] == {"puffs": 6.5}
        assert survey["measured"]["voltage"]["meter"] is None


def test_what_was_stopped_goes_on_after_a_new_start_with_its_consents(tmp_path):
    with rig(tmp_path, CAR) as it:
        it.sampling()
        it.post("/survey/start", {"passports": True, "engine": False})
        wait(it, lambda now: step_is("codes")(now) and now["step"]["done"] > 10)
        assert it.post("/connect", {"port": CAR}, status=409)["en"].startswith(
            "Not now: a survey of the unit is running"
        )
        assert it.post("/survey/start", {}, status=409)["code"] == "Busy"
        assert it.post("/doctor", {}, status=409)["code"] == "Busy"
        assert it.post("/survey/stop", status=409, headers=OTHER)["code"] == "NotController"
        stopped = it.post("/survey/stop")
        assert (stopped["phase"], stopped["error"]) == ("stopped", None)
        assert stopped["consents"]["passports"] is True
        assert it.post("/survey/stop")["phase"] == "stopped"
        it.sampling()  # the connection has its port again
    with rig(tmp_path, None) as it:
        assert it.get("/survey")["found"] == stopped["found"]
        it.post("/survey/start", {"port": CAR, "passports": False, "memory": True})
        again = wait(it, lambda now: now["step"] is not None)
        assert again["step"]["name"] == "codes"
        assert again["consents"]["passports"] is False
        answered(it, "voltmeter", None)
        assert wait(it, ended)["phase"] == "finished"
        unit = next(
            json.loads(each["text"])
            for each in it.get("/survey/result")["members"]
            if each["name"] == "unit.json"
        )
        assert unit["passports"][0] == "МИКАС 7.1"
        assert unit["max_block"] is None
    with rig(tmp_path, None) as it:  # a reload before it is saved
        saved = it.post("/survey/save")
        assert (saved["virtual"], saved["saved"]["name"]) == (True, "virtual-survey.zip")


def test_a_pulled_cable_ends_it_and_it_goes_on(off):
    off.post("/survey/start", {"port": "/dev/ttyUSB7", "engine": False}, status=200)
    failed = wait(off, ended)
    assert failed["error"] is not None  # no car is behind that cable
    off.cars.park(CAR, "/dev/ttyUSB7")
    off.post("/survey/start", {"port": "/dev/ttyUSB7", "engine": False})
    wait(off, lambda now: step_is("codes")(now) and now["step"]["done"] > 10)
    off.cars.pull()
    lost = wait(off, ended)
    assert lost["virtual"] is False
    assert (lost["phase"], lost["error"]["code"]) == ("stopped", "LinkLost")
    assert lost["found"] > 3
    off.cars.put_back()
    assert off.post("/survey/start", {"port": "/dev/ttyUSB7"})["error"] is None
    answered(off, "voltmeter", 12.4)  # given before the loss, and not lost with it
    assert wait(off, ended)["phase"] == "finished"
    members = {each["name"]: each["text"] for each in off.get("/survey/result")["members"]}
    assert json.loads(members["survey.json"])["measured"]["voltage"]["meter"] == 12.4


def answered(it, name, figure):
    """Answers the question for this instrument's figure."""
    asked = wait(it, lambda now: now["asked"] is not None)["asked"]
    assert asked["name"] == name
    it.post("/survey/answer", {"id": asked["id"], "figure": figure})


def test_what_was_measured_before_a_loss_is_saved_without_its_error(off):
    off.cars.park(CAR, "/dev/ttyUSB7")
    off.post("/survey/start", {"port": "/dev/ttyUSB7", "engine": False})
    wait(off, lambda now: step_is("codes")(now) and now["step"]["done"] > 10)
    off.cars.pull()
    assert wait(off, ended)["error"] is not None
    saved = off.post("/survey/save")
    assert (saved["phase"], saved["error"]) == ("idle", None)


def test_a_survey_that_ends_while_its_state_is_read_has_its_error(off, monkeypatch):
    surveys = off.dashboard.surveys
    off.cars.park(CAR, "/dev/ttyUSB7")
    off.post("/survey/start", {"port": "/dev/ttyUSB7", "engine": False})
    wait(off, step_is("codes"))
    saved = surveys.saved

    def lost_meanwhile():
        off.cars.pull()
        for _ in range(5000):
            if surveys.runs:
                threading.Event().wait(0.001)
        return saved()

    monkeypatch.setattr(surveys, "saved", lost_meanwhile)
    states = [off.get("/survey"), off.get("/survey")]
    assert all(ended(it) is (it["error"] is not None) for it in states)
    assert ended(states[1])


def test_what_is_not_wanted_is_forgotten(off):
    off.post("/survey/start", {"port": CAR, "engine": False})
    wait(off, step_is("codes"))
    assert off.delete("/survey", status=409)["code"] == "Busy"
    off.post("/survey/stop")
    assert off.delete("/survey")["phase"] == "idle"
    assert off.get("/survey/result", status=404)["code"] == "NotFound"
    off.post("/survey/answer", {"id": 0}, status=404)


def test_a_damaged_folder_is_named(off, tmp_path):
    folder = tmp_path / "recordings" / "surveys" / "mikas-survey.zip.part"
    folder.mkdir(parents=True)
    (folder / "state.json").write_text('{"schema": 1, "measured": {}}', "utf-8")
    assert "mikas-survey.zip.part" in off.get("/survey", status=400)["en"]
    assert off.delete("/survey")["phase"] == "idle"


def test_the_usual_times_are_of_steps_that_there_are():
    names = {step.name for step in STEPS}
    assert set(USUAL) <= names
    assert all(0 < usual_seconds(step) < 100 for step in STEPS)
