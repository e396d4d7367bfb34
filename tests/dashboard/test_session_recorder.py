"""Recording the running connection from the page."""

from __future__ import annotations

import threading
from itertools import pairwise

import pytest

import mikas
from dashboard.rig import ADAPTER, ME, OTHER, Cars, rig
from mikas.client.identity import PassportReader
from mikas.dashboard.session.connection import Connection
from recording.recorder_harness import SmallDisk


def test_a_recording_is_made_with_its_markers_and_can_be_read_again(idle):
    state = idle.post("/recording/start", {"name": "Volga"})
    assert state["recording"]["file"] == "Volga.pcapng"
    idle.until(lambda it: it["state"]["recording"]["samples"] > 5)
    at = idle.post("/recording/marker", {"label": "стук"})["time"]
    idle.post("/recording/note", {"text": "на холостых"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 8)
    assert idle.post("/recording/stop")["recording"] is None
    path = idle.dashboard.settings.recordings / "Volga.pcapng"
    recorded = mikas.open(path).to_pandas()["TWAT"].dropna().to_list()
    live = idle.get("/history", seconds=3600, points=20000, names="TWAT")["values"][0]
    starts = range(len(live) - len(recorded) + 1)
    assert any(live[start : start + len(recorded)] == recorded for start in starts)
    assert 86 <= recorded[0] <= 95  # warm, by the thermostat
    events = idle.get("/history", seconds=3600)["events"]
    marker = next(event for event in events if event["kind"] == "marker")
    assert (marker["label"], marker["time"]) == ("стук", pytest.approx(at))
    assert [e["on"] for e in events if e["kind"] == "recording"] == [True, False]


def more_samples(idle):
    """Wait until the recording has more samples than now."""
    before = idle.get("/state")["recording"]["samples"]
    idle.until(lambda it: it["state"]["recording"]["samples"] > before)


def test_a_marker_is_named_after_the_moment_also_when_the_recording_has_ended(idle):
    idle.post("/recording/start", {"name": "a"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 3)
    first = idle.post("/recording/marker")["time"]
    idle.put("/recording/marker", {"time": first, "label": "knock"})
    more_samples(idle)
    second = idle.post("/recording/marker")["time"]
    idle.post("/recording/stop")
    idle.put("/recording/marker", {"time": second, "label": "стоп"})
    idle.put("/recordings/a.pcapng/marker", {"time": first, "label": "knock, hot"})
    assert idle.put("/recording/marker", {"time": 1.5, "label": "x"}, 404)["ru"]
    assert idle.put("/recordings/a.pcapng/marker", {"time": 1.5, "label": "x"}, 404)["ru"]

    def markers(events):
        return [(it["time"], it["label"]) for it in events if it["kind"] == "marker"]

    detail = idle.get("/recordings/a.pcapng")
    assert markers(detail["events"]) == [(first, "knock, hot"), (second, "стоп")]
    assert detail["markers"] == 2
    live = idle.get("/history", seconds=3600)["events"]
    assert markers(live) == [(first, "knock"), (second, "стоп")]


def test_a_marker_is_removed_and_brought_back_while_recording_and_afterwards(idle):
    def kept():
        detail = idle.get("/recordings/a.pcapng")
        found = [(it["time"], it["label"]) for it in detail["events"] if it["kind"] == "marker"]
        assert len(found) == detail["markers"]
        return found

    def shown():
        events = idle.get("/history", seconds=3600)["events"]
        markers = (it for it in events if it["kind"] == "marker")
        return [it["time"] for it in markers if "removed" not in it]

    idle.post("/recording/start", {"name": "a"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 3)
    first = idle.post("/recording/marker", {"label": "knock"})["time"]
    more_samples(idle)
    second = idle.post("/recording/marker")["time"]
    idle.delete("/recording/marker", time=first)
    assert shown() == [second]
    idle.put("/recording/marker", {"time": first, "label": "knock"})
    assert shown() == [first, second]
    idle.delete("/recording/marker", time=second)
    third = idle.post("/recording/marker")["time"]
    assert third >= second, "a note about an earlier marker must not set the recording's clock back"
    idle.post("/recording/stop")
    assert kept() == [(first, "knock"), (third, "")]
    idle.delete("/recordings/a.pcapng/marker", time=first)
    idle.delete("/recording/marker", time=third)
    assert kept() == []
    idle.put("/recordings/a.pcapng/marker", {"time": first, "label": "hot"})
    assert kept() == [(first, "hot")]
    assert idle.delete("/recording/marker", 404, time=1.5)["ru"]
    assert idle.delete("/recordings/a.pcapng/marker", 404, time=1.5)["ru"]


def test_markers_between_two_samples_have_times_of_their_own(idle):
    idle.post("/recording/start", {"name": "a"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 3)
    idle.cars.pull()
    idle.until(lambda it: it["state"]["line"] == "no-port")
    pressed, marked = [], []
    for label in ("first", "second", "third"):
        pressed.append(idle.get("/state")["now"])
        marked.append(idle.post("/recording/marker", {"label": label})["time"])
    assert all(before <= time for before, time in zip(pressed, marked, strict=True))
    assert marked == sorted(set(marked))
    idle.post("/recording/stop")
    events = idle.get("/recordings/a.pcapng")["events"]
    kept = {it["label"]: it["time"] for it in events if it["kind"] == "marker"}
    assert kept == dict(zip(("first", "second", "third"), marked, strict=True))


def test_a_name_that_is_taken_gets_a_number(idle):
    assert idle.post("/recording/start", {"name": "a"})["recording"]["file"] == "a.pcapng"
    assert idle.post("/recording/start", {"name": "a"})["recording"]["file"] == "a (2).pcapng"
    assert idle.post("/recording/start", {})["recording"]["file"].startswith("20")


def test_a_folder_that_can_not_be_written_is_reported_and_sampling_goes_on(idle):
    idle.dashboard.settings.recordings.write_text("in the way")
    error = idle.post("/recording/start", {}, 400)
    assert error["ru"]
    assert idle.sampling()["recording"] is None


def test_a_recording_that_breaks_off_says_so_and_another_can_begin(idle, monkeypatch):
    disk = SmallDisk(monkeypatch)
    idle.post("/recording/start", {"name": "a"})
    disk.room = 0
    state = idle.until(lambda it: (it["state"]["recording"] or {}).get("failure"))["state"]
    assert state["recording"]["failure"]["ru"]
    disk.room = 1 << 30
    assert idle.post("/recording/start", {"name": "b"})["recording"]["failure"] is None


def test_without_a_connection_nothing_can_be_recorded(off):
    assert off.post("/recording/start", {}, 503)["code"] == "NotConnected"
    assert off.post("/recording/note", {"text": "x"}, 409)["code"] == "Busy"
    assert off.post("/recording/stop")["recording"] is None


def test_it_begins_without_an_ecu_and_waits_with_the_line(idle):
    idle.cars.pull()
    idle.until(lambda it: it["state"]["line"] == "no-port")
    idle.post("/recording/start", {"name": "waiting"})
    idle.cars.put_back()
    idle.until(lambda it: it["state"]["recording"]["samples"] > 0)


def test_disconnecting_ends_it(idle):
    idle.post("/recording/start", {"name": "a"})
    assert idle.post("/recording/start", {"name": "b"}, 409, OTHER)["code"] == "NotController"
    assert idle.post("/disconnect", headers=ME)["recording"] is None
    (only,) = idle.get("/recordings")["recordings"]
    assert (only["id"], only["gaps"]) == ("a.pcapng", 0)


def test_a_lid_closed_for_ten_minutes_is_a_gap_and_nothing_is_doubled(idle):
    idle.post("/recording/start", {"name": "lid"})
    with idle.live() as live:
        live.until(lambda it: it["state"]["recording"]["samples"] > 3)
        idle.cars.clock.sleep(600)
        began = idle.get("/state")["samples"]
        live.until(lambda it: it["state"]["samples"] > began + 5)
    state = idle.post("/recording/stop")
    assert (state["line"], state["recording"]) == ("sampling", None)
    times = idle.get("/recordings/lid.pcapng/rows", points=20000)["times"]
    assert times == sorted(set(times))
    assert sum(after - before > 500 for before, after in pairwise(times)) == 1
    history = idle.get("/history", seconds=7200, points=20000)["times"]
    assert history == sorted(set(history))
    fuel = idle.get("/history", seconds=7200, points=20000, names="FUEL_FLOW")["values"][0]
    assert all(value is None or value < 10 for value in fuel)


def test_a_list_set_before_the_recording_began_can_be_decoded_in_it(idle):
    idle.put("/plan", {"wanted": [{"name": "TWAT"}], "method": "list", "rate": 5})
    idle.until(lambda it: it["state"]["method"] == "list" and "data" in it)
    idle.post("/recording/start", {"name": "list"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 3)
    idle.post("/recording/stop")
    rows = idle.get("/recordings/list.pcapng/rows")
    assert rows["names"] == ["TWAT"]
    assert len(rows["times"]) > 3


def test_nothing_can_be_recorded_before_the_first_answer(tmp_path):
    with rig(tmp_path, "sim:?supplied=0") as it:
        it.until(lambda message: message["state"]["line"] == "no-echo")
        error = it.post("/recording/start", {}, 503)
        assert error["code"] == "NotConnected"
        assert "12 V" in error["en"]
        assert not it.dashboard.settings.recordings.exists()


class Held:
    """Something that waits until a request waits for its turn on the line."""

    def __init__(self, monkeypatch):
        self._asked = threading.Event()
        ask = Connection.ask

        async def asked(connection, *job, **seconds):
            self._asked.set()
            return await ask(connection, *job, **seconds)

        monkeypatch.setattr(Connection, "ask", asked)

    def wait(self):
        self._asked.wait()

    def go_on(self):
        self._asked.set()


def begins_early(it, held):
    """Start a recording of what is held; the unit is in it."""
    try:
        state = it.post("/recording/start", {"name": "early"})
    finally:
        held.go_on()
    assert state["recording"]["file"] == "early.pcapng"
    it.until(lambda message: message["state"]["recording"]["samples"] > 3)
    it.post("/recording/stop")
    assert it.get("/recordings/early.pcapng")["passport"]


def test_while_the_port_is_being_opened_it_begins_with_the_connection(tmp_path, monkeypatch):
    held, open_port = Held(monkeypatch), Cars.open

    def opened(cars, url):
        held.wait()
        return open_port(cars, url)

    monkeypatch.setattr(Cars, "open", opened)
    with rig(tmp_path) as it:
        state = it.get("/state")
        assert (state["line"], state["reason_code"]) == ("no-port", None)
        begins_early(it, held)


def test_while_values_come_and_the_unit_is_not_known_it_begins_when_it_is(tmp_path, monkeypatch):
    held, in_steps = Held(monkeypatch), PassportReader.steps

    def steps(passports):
        yield
        held.wait()
        return (yield from in_steps(passports))

    monkeypatch.setattr(PassportReader, "steps", steps)
    with rig(tmp_path) as it:
        it.until(lambda message: message["state"]["line"] == "sampling")
        begins_early(it, held)


def _recordings(it):
    events = it.get("/history", seconds=7200)["events"]
    return [(e["file"], e["on"]) for e in events if e["kind"] == "recording"]


def test_another_port_is_another_recording(idle):
    idle.post("/recording/start", {"name": "a"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 3)
    idle.post("/connect", {"port": ADAPTER.url, "method": "batch", "rate": 5})
    idle.until(lambda it: (it["state"]["recording"] or {"samples": 0})["samples"] > 3)
    idle.post("/recording/stop")
    assert _recordings(idle) == [
        ("a.pcapng", True),
        ("a.pcapng", False),
        ("a (2).pcapng", True),
        ("a (2).pcapng", False),
    ]
    first, second = (idle.get(f"/recordings/{file}/rows") for file in ("a.pcapng", "a (2).pcapng"))
    assert first["times"][-1] < second["times"][0]
    idle.post("/disconnect")
    idle.post("/connect", {"port": "sim:?scenario=warm-idle"})
    assert idle.sampling()["recording"] is None


def test_the_same_port_goes_on_in_the_same_file_with_a_gap(idle):
    idle.post("/recording/start", {"name": "a"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 3)
    idle.post("/connect", {"port": "sim:?scenario=warm-idle", "method": "batch", "rate": 5})
    idle.until(lambda it: it["state"]["line"] == "sampling" and "data" in it)
    state = idle.post("/recording/marker", {"label": "x"}) and idle.get("/state")
    assert (state["recording"]["file"], state["recording"]["gaps"]) == ("a.pcapng", 1)


def test_another_car_behind_the_same_port_gets_its_own_file(idle):
    idle.post("/recording/start", {"name": "a"})
    idle.until(lambda it: it["state"]["recording"]["samples"] > 3)
    url = idle.get("/state")["port"]
    idle.cars.park(f"{url}&model=5.4", url)
    idle.post("/connect", {"port": url, "method": "batch", "rate": 5})
    idle.until(lambda it: it["state"]["recording"]["file"] == "a-2.pcapng")


def test_the_faults_are_read_at_both_ends_and_when_another_is_stored(idle):
    idle.post("/recording/start", {"name": "faults"})
    idle.until(lambda it: it["state"]["fault_count"] == 0)
    idle.until(lambda it: it["state"]["recording"]["samples"] > 3)
    idle.cars.car(idle.get("/state")["port"]).faults.append(53)
    idle.until(lambda it: it["state"]["fault_count"] == 1)
    idle.post("/recording/stop")
    read = [
        (event["codes"], event["erased"])
        for event in idle.get("/recordings/faults.pcapng")["events"]
        if event["kind"] == "faults"
    ]
    assert read == [([], False), ([53], False), ([53], False)]
    live = [it for it in idle.get("/history", seconds=900)["events"] if it["kind"] == "faults"]
    assert [it["codes"] for it in live] == [[53]]
    (listed,) = idle.get("/recordings")["recordings"]
    assert listed["faults"] == [53]


def test_a_unit_that_is_silent_to_02_is_recorded_all_the_same(tmp_path):
    with rig(tmp_path, "sim:?scenario=warm-idle&missing=02") as it:
        it.sampling()
        it.post("/recording/start", {"name": "a"})
        it.until(lambda message: message["state"]["recording"]["samples"] > 5)
        assert it.post("/recording/stop")["recording"] is None
        (listed,) = it.get("/recordings")["recordings"]
        assert (listed["faults"], listed["gaps"]) == (None, 0)
