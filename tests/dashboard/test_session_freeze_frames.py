"""Freeze frames of the running connection: taken, completed, kept in the folder, deleted."""

from __future__ import annotations

import pytest

from dashboard.rig import ME, rig
from mikas.client.identity import Passport
from mikas.dashboard.session.freeze_frames import FreezeFrameStore
from mikas.dashboard.session.history import History
from mikas.sampling.events import FaultReading, Gap, UnitFound

CAR = "sim:?scenario=warm-idle&faults=71"
NAMES = ("FREQ", "TWAT", "MINERR")


def frames(it):
    return it.get("/freeze-frames")["frames"]


def stores(it, code):
    """The unit stores one more fault; waits until that is known."""
    it.cars.car(CAR).faults.append(code)
    it.until(lambda message: code in {one["code"] for one in frames(it)})


def test_a_new_fault_has_the_values_of_its_moment_and_they_survive_the_program(tmp_path):
    with rig(tmp_path, CAR, names=NAMES) as it:
        it.until(lambda message: message["state"]["fault_count"] == 1)
        samples = it.get("/state")["samples"]
        it.until(lambda message: message["state"]["samples"] > samples + 40)
        assert frames(it) == []  # that one was stored before
        stores(it, 13)
        (frame,) = frames(it)
        assert frame["without"] < frame["seen"]
        then = {value["name"]: value["value"] for value in frame["values"]}
        assert then["MINERR"] in (13, 71)  # 71: 02 was read before the next row
        assert 80 < then["TWAT"] < 100

        def is_whole():
            times = it.get(f"/freeze-frames/{frame['id']}")["times"]
            return times[-1] > frame["seen"] + 4 and times[0] < frame["without"] - 4

        it.until(lambda message: is_whole())
        times = it.get(f"/freeze-frames/{frame['id']}")["times"]
        between = [time for time in times if frame["without"] < time < frame["seen"]]
        assert len(between) <= 1  # two values of MINERR; 02 was read before the next row
        report = it.get("/report").text
        assert "The unit stored the fault between" in report
        assert "No freeze frame (71): stored before the first reading" in report
        assert it.get("/freeze-frames/1.000-13", 404)["code"] == "NotFound"
    (kept,) = (tmp_path / "state" / "freeze-frames").rglob("*.json")
    (kept.parent / "2.000-9.json").write_text('{"code": "no"}')
    with rig(tmp_path, CAR, names=NAMES) as it:
        it.until(lambda message: message["state"]["fault_count"] is not None)
        assert frames(it) == [frame]
        url = f"/api/freeze-frames/{frame['id']}"
        answer = it.client.delete(url, headers={"X-Mikas-Client": "tester-0001"})
        assert answer.json() == {"frames": []}
    assert not kept.exists()


def test_what_was_erased_and_comes_back_has_another_frame(tmp_path):
    with rig(tmp_path, CAR, names=NAMES) as it:
        it.until(lambda message: message["state"]["fault_count"] == 1)
        stores(it, 13)
        nonce = it.post("/changes", {"kind": "erase_faults"})["nonce"]
        it.post(f"/changes/{nonce}")
        it.until(lambda message: message["state"]["fault_count"] == 0)
        it.cars.car(CAR).faults.append(13)
        it.until(lambda message: len(frames(it)) == 2)
        again, first = frames(it)
        assert [again["code"], first["code"]] == [13, 13]
        assert first["seen"] < again["without"] < again["seen"]
        (fault,) = it.get("/faults")["faults"]
        assert fault["frame"] == again["id"]
        it.client.delete(f"/api/freeze-frames/{again['id']}", headers=ME)
        (fault,) = it.get("/faults")["faults"]
        assert fault["frame"] is None  # the other one is of an earlier appearance


def unit(time, program, *, another=False):
    return UnitFound(time, 0x0A, Passport((program, None, None), (None,) * 5), another)


@pytest.fixture
def store(tmp_path):
    """A store with the values of ten seconds of a unit."""
    history = History()
    made = FreezeFrameStore(tmp_path, history, lambda: 30.0)
    made.begin_connection(0.0)
    made.add_event(unit(0.0, "one"))
    for time in range(1, 11):
        history.add(float(time), ("FREQ",), [float(time)])
    made.history = history
    return made


def reading(store, before, read):
    store.keep_frames_of(FaultReading(read, (13,)), FaultReading(before, ()))


def test_a_value_of_an_older_connection_is_none_of_the_moment(store):
    store.begin_connection(12.0)
    reading(store, 9.0, 13.0)
    assert store.frames == []
    store.history.add(14.0, ("FREQ",), [14.0])
    reading(store, 9.0, 14.1)
    assert [frame.then["FREQ"].value for frame in store.frames] == [14.0]


def test_another_cars_values_are_in_no_frame(store):
    store.add_event(unit(11.0, "two", another=True))
    store.history.add(12.0, ("FREQ",), [12.0])
    reading(store, 11.5, 12.5)
    assert [frame.times for frame in store.frames] == [(12.0,)]


def test_a_gap_that_becomes_known_later_takes_its_value_away(store):
    reading(store, 9.0, 13.0)
    assert [frame.then["FREQ"].value for frame in store.frames] == [10.0]
    store.history.add(14.0, ("FREQ",), [14.0])
    store.add_event(Gap(14.0, 10.0, 14.0))
    store.follow(30.0)
    assert store.frames == []
