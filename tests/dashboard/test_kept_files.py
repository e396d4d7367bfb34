"""What is kept of each unit in the state folder: written aside, bounded, never older than shown."""

from __future__ import annotations

import json
import threading
from types import SimpleNamespace

import pytest

from mikas.client import Passport
from mikas.client.limits import unit_file
from mikas.dashboard.session import freeze_frames, guided_tests
from mikas.dashboard.session.freeze_frames import FreezeFrameStore
from mikas.dashboard.session.guided_tests import GuidedTests
from mikas.dashboard.session.history import History
from mikas.guided.definition import VerdictKind
from mikas.guided.result import TestResult
from mikas.i18n import Text
from mikas.sampling.events import FaultReading, UnitFound
from mikas.virtual import VIRTUAL_PASSPORT

UNIT = UnitFound(0.0, 0x71, Passport(("A", "B"), ("C", "D")))


@pytest.fixture
def store(tmp_path):
    history = History()
    for second in range(20):
        history.add(float(second), ("FREQ",), [800.0 + second])
    return FreezeFrameStore(tmp_path, history, lambda: 19.0)


def seen(store, code, time):
    store.take(FaultReading(time, (code,)), FaultReading(time - 1, ()))


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


def test_of_many_files_the_latest_thirty_are_read(store, tmp_path):
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
    settings = SimpleNamespace(test_results=folder, virtual_units=virtual_units)
    monitor = SimpleNamespace(unit=unit)
    tests = GuidedTests(settings, None, monitor, None, recorder=None, catalog=None)
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


@pytest.mark.parametrize("pieces", [("", ""), (VIRTUAL_PASSPORT, "")])
def test_a_unit_that_is_not_one_car_has_no_results_of_another_day(tmp_path, pieces):
    unit = UnitFound(0.0, 0x71, Passport(pieces, ()))
    tests, _ = kept_results(tmp_path, unit, virtual_units=False)
    assert tests.results == []
