"""The freeze frames of a file are those that were taken live while it was recorded."""

from __future__ import annotations

from contextlib import closing
from math import isfinite, nan
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.client.connecting import ConnectionOptions
from mikas.dashboard.session.history import History
from mikas.link.base import CaptureTee
from mikas.recording.annotations.events import events_of
from mikas.recording.capture.notes import Note
from mikas.recording.freeze_frames import FreezeFrame, frame_of, new_faults
from mikas.recording.recorded_faults import FrameCollector, faults_in
from mikas.recording.recorder import Recorder
from mikas.recording.recording import Recording
from mikas.recording.table.channels import Rows, joined_rows
from mikas.sampling.acquisition import Acquisition
from mikas.sampling.events import FaultReading, Sampled, UnitFound
from mikas.sampling.fault_watch import FaultWatch
from mikas.virtual.build import build_bus
from sampling.sampling_harness import SimulatedPlug

OPTIONS = ConnectionOptions()
NAMES = ("FREQ", "TWAT", "UACC", "MINERR")


class _Taped(SimulatedPlug):
    """A plug whose bytes are recorded."""

    def __init__(self, bus, sink):
        super().__init__(bus)
        self._sink = sink

    def open(self):
        return CaptureTee(super().open(), self._sink)


def drive(path: Path, method: str, seconds: float, changes) -> list[FreezeFrame | None]:
    """Record a drive; return the live frames of the faults that appeared. `changes`: (s, codes)."""
    recorder = Recorder()
    recorder.start(path, url="sim:")
    plug = _Taped(build_bus({"scenario": "city", "model": "7.1"}), recorder)
    car = plug.bus.ecu.responder.car
    for time, codes in changes:
        plug.at(time, lambda codes=codes: setattr(car, "faults", list(codes)))
    watch, history, readings = FaultWatch(), History(), []
    made = Acquisition(plug, OPTIONS.create_ecu, OPTIONS.catalog, NAMES, method=method, rate=5.0)

    def read(ecu):
        reading = watch.read(ecu)
        recorder.record_event(reading)
        readings.append(reading)

    with closing(made.run()) as events:
        for event in events:
            recorder.record_event(event)
            if isinstance(event, Sampled):
                row = [event.fresh[n].value if n in event.fresh else nan for n in NAMES]
                history.add(event.time, NAMES, list(map(float, row)))
            if watch.is_due(event):
                made.call(read)
            if event.time > seconds:
                break
    recorder.stop()
    rows = history.rows(1e9)
    return [frame_of(*new, rows) for new in new_faults(readings)]


@settings(max_examples=3, deadline=None)
@given(
    st.sampled_from(["batch", "list"]),
    st.lists(
        st.tuples(st.floats(1.0, 8.0), st.lists(st.sampled_from([13, 53, 71]), unique=True)),
        max_size=3,
    ),
)
def test_the_frames_of_a_file_are_those_taken_live(method, changes):
    with TemporaryDirectory() as folder:
        path = Path(folder) / "drive.pcapng"
        live = drive(path, method, 14.0, sorted(changes))
        found = faults_in(Recording(path, shipped()))
    recorded = [each.frame for each in reversed(found.appeared)]
    assert len(recorded) == len(live)
    for ours, theirs in zip(recorded, live, strict=True):
        assert ours is not None
        assert ours.code == theirs.code
        assert ours.without == pytest.approx(theirs.without, abs=0.1)
        assert ours.seen == pytest.approx(theirs.seen, abs=0.1)
        for name in NAMES:
            # The file has the begin of the answer to 02, live it is known at its end.
            column = [
                value
                for time, value in zip(theirs.times, theirs.values[name], strict=True)
                if abs(time - theirs.seen) < 0.5 and isfinite(value)
            ]
            assert min(column) <= ours.then[name].value <= max(column)
            assert ours.then[name].low <= ours.then[name].value <= ours.then[name].high
        if ours.seen == theirs.seen and ours.without == theirs.without:
            assert {name: ours.then[name] for name in NAMES} == theirs.then
            assert ours.times == pytest.approx(theirs.times)


def test_a_fault_from_the_start_has_none_and_one_that_comes_back_has_another(tmp_path):
    path = tmp_path / "drive.pcapng"
    changes = [(0.0, [71]), (5.5, [71, 13]), (9.0, []), (11.0, [13])]
    drive(path, "batch", 17.0, changes)
    found = faults_in(Recording(path, shipped()))
    assert found.readings[0].codes == (71,)
    assert [each.code for each in found.appeared] == [13, 13]
    late, early = (each.frame for each in found.appeared)
    assert early.without <= 5.5 <= early.seen < 6.0
    assert late.without <= 11.0 <= late.seen < 11.5
    assert (late.seen - late.without, late.then["MINERR"].value) == (
        pytest.approx(0.2, abs=0.1),
        13,
    )
    assert late.times[0] == pytest.approx(late.without - 5, abs=0.3)
    assert "FUEL_FLOW" not in late.values  # its inputs were not sampled

    damaged = tmp_path / "damaged.pcapng"
    whole = path.read_bytes()
    damaged.write_bytes(whole[: len(whole) * 3 // 5] + bytes(200) + whole[len(whole) * 4 // 5 :])
    (other, *_) = faults_in(Recording(damaged, shipped())).appeared[::-1]
    assert other.frame.then == early.then
    damaged.write_bytes(whole[:400])
    assert faults_in(Recording(damaged, shipped())).appeared == ()


def rows(begin, end, rate=10.0, **columns):
    times = np.arange(round((end - begin) * rate)) / rate + begin
    return Rows(times, {name: make(times) for name, make in columns.items()})


def stored_at(moment, code=13):
    return lambda times: np.where(times < moment, 0.0, code)


def collected(readings, stretches, events=()):
    collector = FrameCollector(readings, events)
    for stretch in stretches:
        collector.add(stretch)
    return collector


HOUR = [FaultReading(0.0, ()), FaultReading(3600.0, (13,))]


@pytest.mark.parametrize("size", [7.0, 300.0, 3600.0])
def test_of_a_long_file_only_the_rows_around_the_moment_are_held(size):
    columns = {"MINERR": stored_at(2000.05), "FREQ": lambda times: times}
    stretches = [rows(begin, begin + size, **columns) for begin in np.arange(0.0, 3600.0, size)]
    held = collected(HOUR, stretches)
    (appeared,) = held.appeared
    assert appeared.frame == frame_of(13, 0.0, 3600.0, joined_rows(stretches))
    assert (appeared.frame.without, appeared.frame.seen) == pytest.approx((2000.0, 2000.1))
    assert len(appeared.frame.times) == 102
    assert sum(len(it.times) for window in held._windows for it in window._pieces) == 102  # noqa: SLF001


def test_there_is_none_without_minerr_or_where_the_clock_was_set_back_or_the_unit_changed():
    slow = [rows(0.0, 3600.0, 1.0, FREQ=lambda times: times)]
    (appeared,) = collected(HOUR, slow).appeared
    assert (appeared.frame, appeared.before, appeared.read) == (None, 0.0, 3600.0)
    short = [FaultReading(20.0, ()), FaultReading(22.0, (13,))]
    one = rows(0.0, 40.0, FREQ=lambda times: times)
    assert collected(short, [one]).appeared[0].frame is not None
    assert collected(short, [one, one]).appeared[0].frame is None
    other = UnitFound(21.0, 0x0A, None, another=True)
    assert collected(short, [one], [other]).appeared == ()


def test_a_fault_is_the_same_units_when_a_piece_of_its_passport_was_lost_at_first():
    passports = ["A", "B", "C", *["D"] * 5]
    notes = [
        Note("unit", time, {"version_code": "0A", "passports": pieces})
        for time, pieces in ((1.0, ["A", None, *passports[2:]]), (21.0, passports))
    ]
    short = [FaultReading(20.0, ()), FaultReading(22.0, (13,))]
    one = rows(0.0, 40.0, FREQ=lambda times: times)
    (appeared,) = collected(short, [one], events_of(notes, shipped())).appeared
    assert appeared.frame is not None


def test_a_fault_that_comes_and_goes_leaves_room_for_the_others():
    flips = [FaultReading(3.0 + n, (13, 53) if n % 2 else (13,)) for n in range(200)]
    appeared = collected([FaultReading(1.0, ()), *flips], []).appeared
    assert len(appeared) == 30
    assert {each.code for each in appeared} == {13, 53}
