"""All that the page shows and keeps has true dates after the computer's date was set."""

from __future__ import annotations

import json
from datetime import datetime
from itertools import pairwise

import pytest

from dashboard.dumps_rig import XRAM, ended
from dashboard.rig import rig
from dashboard.test_true_dates import NIGHT, YEARS, record, set_date

CAR = "sim:?scenario=warm-idle&faults=71"
COLD = "duration = 999\n[start]\nambient = 12\n"
NAMES = ("FREQ", "TWAT", "MINERR")
SOON = 1800.0  # s of the tests' clock, which runs fast

set_by = pytest.mark.parametrize("seconds", [YEARS, -NIGHT])


@pytest.fixture
def car(tmp_path):
    """A dashboard on a car with one stored fault, which is read."""
    with rig(tmp_path, CAR, names=NAMES) as it:
        it.until(lambda message: message["state"]["fault_count"] == 1)
        yield it


def is_now(it, time):
    return time == pytest.approx(it.cars.clock.date(), abs=SOON)


@set_by
def test_live_data_and_the_state_have_true_dates(car, seconds):
    set_date(car, seconds)
    message = car.until(lambda it: "data" in it)
    assert message["later"] == pytest.approx(seconds, abs=1)
    state = car.get("/state")
    times = (message["now"], *message["data"]["times"], state["now"], state["since"])
    assert all(is_now(car, time) for time in (*times, state["fault_time"]))
    assert is_now(car, car.post("/unlock", {"minutes": 10})["unlocked_until"] - 600)
    car.post("/recording/start", {"name": "a"})
    car.until(lambda it: it["state"]["recording"]["samples"] > 3)
    assert is_now(car, car.get("/state")["recording"]["since"])


@set_by
def test_an_event_has_its_true_date(car, seconds):
    set_date(car, seconds)
    with car.live() as live:
        live.next()
        time = car.post("/recording/marker", {"label": "x"})["time"]
        message = live.until(
            lambda message: any(each["kind"] == "marker" for each in message.get("events", ()))
        )
    (event,) = [each for each in message["events"] if each["kind"] == "marker"]
    assert event["time"] == time
    assert is_now(car, time)


@set_by
def test_the_history_is_moved_as_a_whole_and_no_value_against_another(car, seconds):
    before = car.get("/history", seconds=3600)
    car.post("/recording/marker", {"label": "before"})
    set_date(car, seconds)
    car.sampling()
    history = car.get("/history", seconds=3600, points=20_000)
    assert history["later"] == pytest.approx(seconds, abs=1)
    times = history["times"]
    assert is_now(car, times[0])
    assert is_now(car, times[-1])
    moved = [time + history["later"] - before["later"] for time in before["times"]]
    assert times[: len(moved)] == pytest.approx(moved, abs=1e-5)
    assert all(0 < b - a < 5 for a, b in pairwise(times))
    assert all(is_now(car, event["time"]) for event in history["events"])
    found = car.get("/history/find", expression="FREQ > 0")["hits"]
    assert is_now(car, found[0]["begin"])


@set_by
def test_a_marker_has_its_date_and_is_found_by_it(car, seconds):
    record(car, "a")
    before = car.post("/recording/marker", {"label": "before"})["time"]
    set_date(car, seconds)
    after = car.post("/recording/marker", {"label": "after"})["time"]
    later = car.get("/history", seconds=1)["later"]
    for time, name in ((before + later, "first"), (after, "second")):
        assert is_now(car, time)
        car.put("/recording/marker", {"time": time, "label": name})
    car.post("/recording/stop")
    events = car.get("/recordings/a.pcapng")["events"]
    marks = {it["label"]: it["time"] for it in events if it["kind"] == "marker"}
    assert marks == {
        "first": pytest.approx(before + later, abs=1e-5),
        "second": pytest.approx(after, abs=1e-5),
    }


@set_by
def test_values_faults_and_memory_are_of_true_dates(car, seconds):
    set_date(car, seconds)
    car.sampling()
    value = car.get("/channels/FREQ/value")
    assert is_now(car, value["time"])
    at = car.get("/history", seconds=60)["times"][-3]
    then = car.get("/channels/FREQ/value", at=at)
    assert then["time"] == pytest.approx(at, abs=1e-3)
    for last in (True, False):
        faults = car.get("/faults", last=last)
        assert is_now(car, faults["time"])
        assert is_now(car, faults["faults"][0]["first_seen"])
    assert is_now(car, car.get("/memory/sfr", address="0x80", count=1)["time"])
    assert is_now(car, car.post("/changes", {"kind": "erase_faults"})["expires"])


@set_by
def test_a_change_has_its_date_in_the_journal(car, seconds):
    set_date(car, seconds)
    asked = car.post("/changes", {"kind": "erase_faults"})
    car.post(f"/changes/{asked['nonce']}")
    entries = car.get("/journal")["entries"]
    assert {entry["state"] for entry in entries} == {"started", "done"}
    assert all(is_now(car, entry["time"]) for entry in entries)


@set_by
def test_a_dump_has_its_date(car, seconds):
    set_date(car, seconds)
    dump = ended(car, car.post("/dumps", XRAM)["id"], "done", "failed")
    manifest = car.dashboard.settings.dumps / f"{dump['file']}.json"
    assert is_now(car, json.loads(manifest.read_text("utf-8"))["time"])


@set_by
def test_freeze_frames_have_true_dates_also_in_their_files(tmp_path, seconds):
    def frames(it):
        return it.get("/freeze-frames")["frames"]

    def stores(it, code):
        it.cars.car(CAR).faults.append(code)
        it.until(lambda _: code in {one["code"] for one in frames(it)})

    with rig(tmp_path, CAR, names=NAMES) as it:
        it.until(lambda message: message["state"]["fault_count"] == 1)
        stores(it, 13)
        set_date(it, seconds)
        stores(it, 14)
        shown = frames(it)
        assert [frame["code"] for frame in shown] == [14, 13]
        for frame in shown:
            rows = it.get(f"/freeze-frames/{frame['id']}")
            times = (frame["without"], frame["seen"], rows["times"][0], rows["times"][-1])
            assert all(is_now(it, time) for time in times)
        faults = it.get("/faults", last=True)["faults"]
        named = {fault["code"]: fault["frame"] for fault in faults}
        assert named == {71: None} | {frame["code"]: frame["id"] for frame in frames(it)}
        it.post("/disconnect")  # completes them
        shown, date = frames(it), it.cars.clock.date()
        kept = tmp_path / "state" / "freeze-frames"

        def written():
            return {file.stem for file in kept.rglob("*.json")}

        it.until(lambda _: written() == {frame["id"] for frame in shown})
    for file in kept.rglob("*.json"):
        assert json.loads(file.read_text("utf-8"))["seen"] == pytest.approx(date, abs=SOON)
    with rig(tmp_path, CAR, names=NAMES) as it:
        it.until(lambda message: message["state"]["fault_count"] is not None)
        assert frames(it) == shown


@set_by
def test_results_of_guided_tests_have_true_dates_also_in_their_file(tmp_path, seconds):
    def finish(it):
        it.post("/tests/sensors/start")
        it.until(lambda _: it.get("/tests/run")["run"]["result"] is not None)
        it.post("/tests/run/cancel")

    (tmp_path / "car.toml").write_text(COLD, "utf-8")
    with rig(tmp_path, f"sim:?scenario={tmp_path / 'car.toml'}") as it:
        it.sampling()
        finish(it)
        set_date(it, seconds)
        (result,) = it.get("/tests/results")["results"]
        last = next(each for each in it.get("/tests")["tests"] if each["name"] == "sensors")["last"]
        curve, step = result["curves"][0], result["steps"][0]
        times = (result["began"], last["ended"], curve["times"][-1], step["began"], step["ended"])
        assert all(is_now(it, time) for time in times)
        it.put(f"/tests/results/{result['id']}", {"in_report": True})
        day = datetime.fromtimestamp(it.cars.clock.date()).astimezone()
        assert f"{day:%d.%m}" in it.get("/report", lang="ru").text
        finish(it)
        date, kept = it.cars.clock.date(), tmp_path / "state" / "tests"

        def dates():
            (file,) = kept.glob("*.json")
            return [each["ended"] for each in json.loads(file.read_text("utf-8"))]

        it.until(lambda _: dates() == [pytest.approx(date, abs=SOON)] * 2)
