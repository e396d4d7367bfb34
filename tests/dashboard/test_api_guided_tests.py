"""Guided tests through the API: a run on the virtual car, its result, and what is refused."""

from __future__ import annotations

import json

import pytest

import mikas
from dashboard.rig import OTHER, rig
from mikas.guided.result import read
from mikas.recording import CaptureReader, CaptureWriter
from mixture_by_meter import MIXTURE

CAR = "duration = 999\n[start]\nambient = 12\n[condition]\ncoolant_sensor = 15\n"
WRONG = "title = 'x'\n[step.one]\ntext = 'x'\nholds = 1\n"


@pytest.fixture
def cold(tmp_path):
    """A cold car with the ignition on; its coolant sensor shows 15 °C too much."""
    (tmp_path / "car.toml").write_text(CAR, "utf-8")
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "wrong.toml").write_text(WRONG, "utf-8")
    with rig(tmp_path, f"sim:?scenario={tmp_path / 'car.toml'}") as it:
        it.sampling()
        yield it


def finished(it):
    it.until(lambda _: it.get("/tests/run")["run"]["result"] is not None)
    return it.get("/tests/run")["run"]


def test_a_run_finds_the_fault_and_is_kept(cold, tmp_path):
    plan = cold.get("/state")["plan"]["wanted"]
    cold.post("/recording/start", {"name": "drive"})
    run = cold.post("/tests/sensors/start")["run"]
    assert (run["name"], run["phase"], run["result"]) == ("sensors", "start", None)
    wanted = {it["name"] for it in cold.get("/state")["plan"]["wanted"]}
    assert {"TAIR", "TWAT", "THR", "JAIR"} <= wanted
    run = finished(cold)
    result = run["result"]
    assert (run["phase"], result["outcome"], result["in_report"]) == ("done", "attention", False)
    (finding,) = result["findings"]
    assert finding["rule"] == "apart"
    assert "27 °C" in finding["text"]["en"]
    assert finding["doubt"]["ru"]
    assert cold.get("/state")["plan"]["wanted"] == plan
    assert cold.put(f"/tests/results/{result['id']}", {"in_report": True})["in_report"]
    assert [it["id"] for it in cold.get("/tests/results")["results"]] == [result["id"]]
    last = next(it for it in cold.get("/tests")["tests"] if it["name"] == "sensors")["last"]
    assert (last["id"], last["outcome"]) == (result["id"], "attention")
    cold.post("/recording/stop")
    (file,) = (tmp_path / "recordings").glob("*.pcapng")
    (note,) = (note for note in CaptureReader(file).notes() if note.kind == "test")
    assert read(note.data).verdict.en == result["verdict"]["en"]
    page = cold.get("/report", lang="en").text
    assert finding["text"]["en"] in page
    assert finding["text"]["en"] in cold.get(f"/recordings/{file.name}/report", lang="en").text
    kept = tmp_path / "state" / "tests"

    def stored():
        return [json.loads(each.read_text("utf-8"))[0] for each in kept.glob("*.json")]

    cold.until(lambda _: any(it["in_report"] for it in stored()))
    assert [it["id"] for it in stored()] == [result["id"]]
    assert cold.post("/tests/run/cancel")["run"] is None


def test_skipping_every_step_tells_nothing(cold):
    (wrong,) = cold.get("/tests")["errors"]
    assert (wrong["line"], wrong["file"].endswith("wrong.toml")) == (4, True)
    assert cold.get("/tests/run")["run"] is None
    assert cold.post("/tests/none/start", status=404)
    assert cold.post("/tests/run/skip", status=409)
    cold.post("/tests/cranking/start")
    assert cold.get("/tests")["running"] == "cranking"
    assert cold.post("/tests/sensors/start", status=409)["code"] == "Busy"
    assert cold.post("/tests/run/cancel", status=409, headers=OTHER)["code"] == "NotController"
    cold.until(lambda _: cold.get("/tests/run")["run"]["step"] == 1)
    run = cold.get("/tests/run")["run"]
    assert run["values"].keys() == {"FREQ", "UACC"}
    result = cold.post("/tests/run/skip")["run"]["result"]
    assert (result["outcome"], result["findings"]) == ("unknown", [])
    assert all("skipped" in it["en"] for it in result["missing"])
    assert cold.put("/tests/results/none", {"in_report": True}, status=404)


def test_a_run_shows_what_keeps_it_waiting(cold):
    cold.post("/tests/idle/start")
    runs = []

    def has_a_value(_):  # which may be missing again in the next look, on a loaded computer
        runs.append(cold.get("/tests/run")["run"])
        return any(it["value"] is not None for it in runs[-1]["unmet"])

    cold.until(has_a_value)
    run = runs[-1]
    assert (run["phase"], run["step"]) == ("start", None)
    (unmet,) = run["unmet"]
    assert {key: unmet[key] for key in ("name", "value", "sign", "limit")} == {
        "name": "FREQ",
        "value": 0,
        "sign": ">",
        "limit": 500,
    }
    assert unmet["text"]["ru"].startswith("Обороты 0")
    cold.post("/tests/run/cancel")


def test_a_test_over_a_recording_has_its_result(cold, tmp_path):
    """The recording is by a clock of its own: in one of a loaded computer a gap may cut a step."""
    port = f"sim:?clock=simulated&scenario={tmp_path / 'car.toml'}"
    drive = tmp_path / "recordings" / "drive.pcapng"
    drive.parent.mkdir(exist_ok=True)
    with CaptureWriter(drive, url=port) as writer, mikas.connect(port, sink=writer) as ecu:
        for _ in ecu.watch("FREQ", "TWAT", "TAIR", "THR", "JAIR", "UACC", rate=5, count=300):
            pass
    over = cold.get("/recordings/drive.pcapng/tests/sensors")
    assert ([it["rule"] for it in over["result"]["findings"]], over["why"]) == (["apart"], None)
    none = cold.get("/recordings/drive.pcapng/tests/charging")
    assert none["result"] is None
    assert none["why"]["en"].startswith("the recording does not have this step: Start the engine")
    assert [it["en"][:14] for it in none["left_out"]] == ["Switch on high"]
    none = cold.get("/recordings/drive.pcapng/tests/warmup")
    assert none["why"]["ru"].startswith("в записи нет того, с чего проверка начинается: Двигатель")
    none = cold.get("/recordings/drive.pcapng/tests/knock")
    assert none["why"]["en"] == "the recording has no values of UOZ, UOZOC, DET"
    cold.get("/recordings/drive.pcapng/tests/none", 404)
    cold.get("/recordings/none.pcapng/tests/sensors", 404)


def test_a_test_that_names_lambda_waits_for_its_meter(tmp_path):
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "mixture.toml").write_text(MIXTURE, "utf-8")
    with rig(tmp_path, "sim:?scenario=warm-idle") as it:
        refused = it.post("/tests/mixture/start", status=400)
        assert "No instrument beside the unit gives LAMBDA" in refused["en"]
        assert "«Связь»" in refused["ru"]
        it.post("/instruments", {"definition": "aem", "port": "sim:"})
        it.post("/tests/mixture/start")
        run = finished(it)
    (number,) = run["result"]["numbers"]
    assert number["value"] == pytest.approx(1, abs=0.3)
