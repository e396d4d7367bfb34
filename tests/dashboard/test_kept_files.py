"""What is kept of each unit in the state folder: written aside, bounded, never older than shown."""

from __future__ import annotations

import json
import re
import threading
from dataclasses import replace
from types import SimpleNamespace

import pytest

from dashboard.rig import rig
from mikas.client import Passport
from mikas.client.cars import CarDetails
from mikas.client.limits import unit_file
from mikas.dashboard.session import freeze_frames, guided_tests
from mikas.dashboard.session.freeze_frames import FreezeFrameStore
from mikas.dashboard.session.guided_tests import GuidedTests
from mikas.dashboard.session.history import History
from mikas.errors import UsageError
from mikas.guided.definition import VerdictKind
from mikas.guided.result import TestResult
from mikas.i18n import Text
from mikas.sampling.events import FaultReading, UnitFound
from mikas.virtual import VIRTUAL_PASSPORT

TILE = {"kind": "gauge", "names": ["TWAT"], "span": 1}
PRESET = {"id": "a", "name": {"en": "a", "ru": "a"}, "tiles": [TILE]}


@pytest.mark.parametrize(
    ("name", "damaged"),
    [
        ("presets.json", "no JSON"),
        ("presets.json", '[{"id": "mine"}]'),
        ("searches.json", '{"a": 1}'),
        ("references.json", "[1]"),
        ("cars.json", '{"car": "Volga"}'),
        ("instruments.json", '[{"definition": "aem"}]'),
    ],
)
def test_what_can_not_be_used_is_said_and_kept_aside(tmp_path, name, damaged):
    state = tmp_path / "state"
    state.mkdir()
    (state / name).write_text(damaged, "utf-8")
    (state / f"{name}.broken").write_text("of last year", "utf-8")
    with rig(tmp_path, None) as it:
        (problem,) = it.get("/about")["problems"]
        assert f"{name}: the content is damaged" in problem["en"]
        assert f"keeps it as {name}.broken-2" in problem["en"]
        assert f"{name}: содержимое повреждено" in problem["ru"]
        assert it.get("/presets") == {"presets": []}
        assert (state / name).read_text("utf-8") == damaged  # nothing is touched before
        it.put("/presets", {"presets": [PRESET]})
        it.put("/searches", {"searches": [{"name": "", "expression": "FREQ > 0"}]})
        it.dashboard.library.references.mark("a.pcapng", on=True)
        it.dashboard.cars.keep(UNIT.identity, CarDetails("Volga"))
        it.post("/instruments", {"definition": "phone", "port": "position:"})
        assert (state / f"{name}.broken-2").read_text("utf-8") == damaged
        assert it.get("/about")["problems"] == []
        assert it.get("/presets")["presets"][0]["id"] == "a"
        assert len(list(state.glob("*.broken*"))) == 2


UNIT = UnitFound(0.0, 0x71, Passport(("A", "B"), ("C", "D")))


@pytest.fixture
def store(tmp_path):
    history = History()
    for second in range(20):
        history.add(float(second), ("FREQ",), [800.0 + second])
    return FreezeFrameStore(tmp_path, history, lambda: 19.0)


def seen(store, code, time):
    store.keep_frames_of(FaultReading(time, (code,)), FaultReading(time - 1, ()))


def test_sampling_goes_on_while_a_frame_is_written(store, tmp_path, monkeypatch):
    store.begin_unit(UNIT)
    writing, go_on = threading.Event(), threading.Event()

    def slow(file, text):
        writing.set()
        assert go_on.wait(60)
        file.write_text(text, "utf-8")

    monkeypatch.setattr(freeze_frames, "save", slow)
    seen(store, 13, 8.0)
    assert writing.wait(60)
    sampling = threading.Thread(target=store.follow, args=(9.0,), daemon=True)
    sampling.start()
    sampling.join(5)
    went_on = not sampling.is_alive()
    go_on.set()
    assert went_on
    store.finish()
    assert len(list(tmp_path.rglob("*.json"))) == 1
    (frame,) = store.frames
    assert store.delete(frame.id)
    assert list(tmp_path.rglob("*.json")) == []


def test_frames_stay_when_more_of_the_units_passport_is_known(store, tmp_path):
    lost = Passport(("A", None), ("C", "D"))
    store.begin_unit(replace(UNIT, passport=lost))
    seen(store, 13, 8.0)
    store.finish()  # writes it
    (frame,) = store.frames
    store.begin_unit(UNIT)
    assert store.frames == [frame]
    again = FreezeFrameStore(tmp_path, History(), lambda: 19.0)
    again.begin_unit(UNIT)
    assert [each.id for each in again.frames] == [frame.id]
    store.begin_unit(replace(UNIT, passport=Passport(("A", "X"), ("C", "D")), another=True))
    assert store.frames == []


def test_frames_join_those_that_are_kept_under_the_whole_passport(store, tmp_path, said):
    """The frames of the part stayed in a folder that no session looked into."""
    store.begin_unit(UNIT)
    seen(store, 13, 8.0)
    store.finish()
    later = FreezeFrameStore(tmp_path, store._history, lambda: 19.0)  # noqa: SLF001
    later.begin_unit(replace(UNIT, passport=Passport(("A", None), ("C", "D"))))
    seen(later, 17, 9.0)
    later.finish()
    later.begin_unit(UNIT)
    again = FreezeFrameStore(tmp_path, History(), lambda: 19.0)
    again.begin_unit(UNIT)
    assert [each.code for each in again.frames] == [each.code for each in later.frames] == [17, 13]
    assert len(list(tmp_path.iterdir())) == 1
    assert said == []


def test_a_frame_whose_file_can_not_be_deleted_is_not_said_to_be_gone(store, tmp_path):
    """It was, and came back in the next session."""
    store.begin_unit(UNIT)
    seen(store, 13, 8.0)
    store.finish()
    (frame,) = store.frames
    (file,) = tmp_path.rglob("*.json")
    file.unlink()
    file.mkdir()
    for _ in range(2):
        with pytest.raises(UsageError, match=re.escape(file.name)):
            store.delete(frame.id)
        assert store.frames == [frame]
    file.rmdir()
    assert store.delete(frame.id)
    assert store.frames == []


def test_of_many_frames_the_latest_thirty_are_read(store, tmp_path):
    store.begin_unit(UNIT)
    seen(store, 13, 8.0)
    (frame,) = store.frames
    folder = unit_file(tmp_path, UNIT.version_code, UNIT.passport.pieces).with_suffix("")
    folder.mkdir(exist_ok=True)
    for number in range(50):
        about = frame.as_json() | {"seen": 100.0 + number}
        (folder / f"{100.0 + number:.3f}-13.json").write_text(json.dumps(about), "utf-8")
    far = frame.as_json() | {"without": 1e300, "seen": 1e300}
    (folder / "999.000-13.json").write_text(json.dumps(far), "utf-8")  # no such time
    again = FreezeFrameStore(tmp_path, History(), lambda: 19.0)
    again.begin_unit(UNIT)
    assert [each.seen for each in again.frames] == [149.0 - number for number in range(29)]


RESULT = TestResult("idle", Text("a", "а"), 1.0, 2.0, VerdictKind.GOOD, (), (), (), (), ())


def kept_results(folder, unit, *, virtual_units=True):
    """The results of `unit`, with one in its file."""
    file = unit_file(folder, unit.version_code, unit.passport.pieces)
    kept = [{"id": "idle-2000\u202e", "in_report": False} | RESULT.as_json()]
    file.write_text(json.dumps(kept), "utf-8")
    settings = SimpleNamespace(in_state=lambda _: folder, virtual_units=virtual_units)
    connection = SimpleNamespace(later=0.0, monitor=SimpleNamespace(unit=unit))
    tests = GuidedTests(settings, connection, None, None, None, None)
    return tests, file


def test_of_two_results_kept_at_once_the_later_stays(tmp_path, monkeypatch):
    started = []

    class Thread:
        def __init__(self, target, args, **_):
            self._run = lambda: target(*args)

        def start(self):
            started.append(self._run)

    tests, file = kept_results(tmp_path, UNIT)
    (read,) = tests.results
    assert read.identity.isprintable()
    with monkeypatch.context() as patched:
        patched.setattr(guided_tests.threading, "Thread", Thread)
        for wanted in (True, False, True):
            tests.put_in_report(read.identity, wanted=wanted)
    for run in reversed(started):  # the system runs threads in any order
        run()
    assert json.loads(file.read_text("utf-8"))[0]["in_report"] is True


def test_results_that_can_not_be_saved_stay_and_are_said_once(tmp_path, said):
    tests, file = kept_results(tmp_path, UNIT)
    (read,) = tests.results
    file.with_name(f"{file.name}.new").mkdir()
    for wanted in (True, False, True):
        tests.put_in_report(read.identity, wanted=wanted)
    for thread in threading.enumerate():
        if thread.name == "mikas test result":
            thread.join()
    (sentence,) = said
    assert f"can't be saved in {tmp_path} (" in sentence.en
    assert "Результаты проверок не сохраняются" in sentence.ru
    assert [kept.in_report for kept in tests.results] == [True]


def test_results_that_can_not_be_used_are_kept_aside(tmp_path):
    tests, file = kept_results(tmp_path, UNIT)
    file.write_text("{}", "utf-8")
    assert tests.results == []
    assert "damaged" in tests.file.problem.en
    tests.file.save([])
    assert file.with_name(f"{file.name}.broken").read_text("utf-8") == "{}"
    assert tests.file.problem is None


@pytest.mark.parametrize("pieces", [("", ""), (VIRTUAL_PASSPORT, "")])
def test_a_unit_that_is_not_one_car_has_no_results_of_another_day(tmp_path, pieces):
    unit = UnitFound(0.0, 0x71, Passport(pieces, ()))
    tests, _ = kept_results(tmp_path, unit, virtual_units=False)
    assert tests.results == []
