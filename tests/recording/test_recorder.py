"""The recorder: when it writes, what it notes, and that nothing stops the session."""

from __future__ import annotations

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st
from recorder_harness import (
    OTHER,
    PASSPORT,
    RECEIVED,
    SENT,
    SmallDisk,
    begin_session,
    gap,
    kinds,
    notes,
    sampled,
    state,
    take,
    unit,
    wire,
)

from mikas.catalog import AlarmLimits
from mikas.client import Limits
from mikas.errors import CaptureError
from mikas.i18n import Text
from mikas.recording.recorder import Recorder
from mikas.sampling.alarms import Alarms
from mikas.sampling.events import LineState, MethodChosen, ParameterDropped
from mikas.sampling.session import SamplingSession
from protocol_codes import with_limits


def test_it_writes_between_start_and_stop(recorder, tmp_path):
    file = tmp_path / "a.pcapng"
    recorder.record(SENT, b"\x01\xff\x0d", 1.0)
    assert recorder.status is None
    assert recorder.stop() is None
    recorder.start(file, url="sim:")
    assert recorder.status.since == 1.0
    recorder.record(SENT, b"\x02\xfe\x0d", 2.0)
    recorder.record(RECEIVED, b"\x02\xfe\x0d", 2.1)
    take(recorder, sampled(2.0))
    status = recorder.stop()
    recorder.record(SENT, b"\x01\xff\x0d", 3.0)
    assert wire(file) == {SENT: b"\x02\xfe\x0d", RECEIVED: b"\x02\xfe\x0d"}
    assert (status.path, status.samples, status.gaps, status.failure) == (file, 1, 0, None)
    assert status.bytes <= file.stat().st_size
    assert recorder.status is None


chunks = st.lists(
    st.tuples(
        st.sampled_from([SENT, RECEIVED]), st.binary(min_size=1, max_size=40),
        st.floats(0.0, 2.0),
    ),
    max_size=40,
)  # fmt: skip


@given(chunks=chunks, joined=st.booleans())
def test_what_was_recorded_is_what_passed(tmp_path_factory, chunks, joined):
    file = tmp_path_factory.mktemp("r") / "a.pcapng"
    recorder = Recorder(joined=joined)
    recorder.start(file, url="sim:")
    time, passed = 1.0, {SENT: b"", RECEIVED: b""}
    for direction, data, pause in chunks:
        time += pause
        recorder.record(direction, data, time)
        take(recorder, sampled(time))
        passed[direction] += data
    recorder.stop()
    assert wire(file) == passed


def test_a_file_that_is_there_is_refused_and_what_runs_goes_on(recorder, tmp_path):
    (tmp_path / "b.pcapng").write_bytes(b"precious")
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    for path in (tmp_path / "b.pcapng", tmp_path / "nosuch" / "c.pcapng", tmp_path):
        with pytest.raises(CaptureError):
            recorder.start(path, url="sim:")
    recorder.record(SENT, b"\x01\xff\x0d", 1.0)
    recorder.stop()
    assert (tmp_path / "b.pcapng").read_bytes() == b"precious"
    assert wire(tmp_path / "a.pcapng")[SENT] == b"\x01\xff\x0d"


def test_a_second_start_ends_the_first(recorder, tmp_path):
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    recorder.record(SENT, b"\x01\xff\x0d", 1.0)
    recorder.start(tmp_path / "b.pcapng", url="sim:")
    recorder.record(SENT, b"\x02\xfe\x0d", 2.0)
    recorder.stop()
    assert wire(tmp_path / "a.pcapng")[SENT] == b"\x01\xff\x0d"
    assert wire(tmp_path / "b.pcapng")[SENT] == b"\x02\xfe\x0d"


# What is noted


def test_the_head_comes_as_the_session_begins(recorder, tmp_path):
    file = tmp_path / "a.pcapng"
    recorder.start(file, url="sim:")
    begin_session(recorder)
    recorder.stop()
    assert kinds(file) == ["state", "unit", "catalog", "plan", "state"]
    reported = notes(file)
    assert reported[1].data["passports"] == [*PASSPORT.program, *PASSPORT.data]
    assert (reported[1].data["adapter"], reported[1].data["echo"]) == ("an adapter", True)
    assert reported[3].data["names"] == ["TWAT", "FREQ"]
    assert reported[3].data["every"] == [1, 10]


def test_a_start_in_mid_session_writes_the_head_at_once(recorder, tmp_path):
    begin_session(recorder)
    take(recorder, sampled(5.0))
    file = tmp_path / "a.pcapng"
    recorder.start(file, url="sim:")
    assert kinds(file) == ["unit", "catalog", "plan", "state"]
    assert {note.time for note in notes(file)} == {5.0}
    recorder.stop()


def test_the_same_unit_again_is_not_noted_again(recorder, tmp_path):
    file = tmp_path / "a.pcapng"
    recorder.start(file, url="sim:")
    begin_session(recorder)
    take(recorder, unit(9.0))
    recorder.stop()
    assert kinds(file).count("unit") == 1


def test_a_run_of_lost_cycles_is_one_gap_with_its_reason(recorder, tmp_path):
    file = tmp_path / "a.pcapng"
    recorder.start(file, url="sim:")
    begin_session(recorder)
    take(recorder, sampled(5.0))
    for event in (gap(5.5), gap(6.0), state(7.0, LineState.ECHO_ONLY), gap(8.0), gap(9.0)):
        take(recorder, event)
    assert recorder.status.gaps == 1
    take(recorder, state(20.0, LineState.SAMPLING))
    take(recorder, sampled(21.0))
    take(recorder, sampled(22.0))
    take(recorder, gap(23.0))
    take(recorder, sampled(24.0))
    assert recorder.stop().gaps == 2
    first, second = (note.data for note in notes(file) if note.kind == "gap")
    assert (first["began"], first["ended"]) == (5.0, 21.0)
    assert "the ECU does not answer" in first["reason"]["en"]  # what the state showed, not a cycle
    assert (second["began"], second["ended"]) == (22.0, 24.0)
    assert "0.5 s" in second["reason"]["en"]


def test_an_adapter_that_goes_away_begins_a_gap_without_a_lost_cycle(recorder, tmp_path):
    file = tmp_path / "a.pcapng"
    recorder.start(file, url="sim:")
    begin_session(recorder)
    take(recorder, sampled(5.0))
    take(recorder, state(6.0, LineState.NO_PORT))
    recorder.stop()
    (reported,) = (note.data for note in notes(file) if note.kind == "gap")
    assert (reported["began"], reported["ended"]) == (5.0, None)
    assert reported["reason"] == {"en": "no adapter", "ru": "нет адаптера"}


def test_waiting_for_the_first_answer_is_no_gap(recorder, tmp_path):
    file = tmp_path / "a.pcapng"
    recorder.start(file, url="sim:")
    take(recorder, state(1.0, LineState.NO_PORT))
    take(recorder, state(5.0, LineState.ECHO_ONLY))
    begin_session(recorder, 8.0)
    take(recorder, sampled(9.0))
    recorder.stop()
    assert "gap" not in kinds(file)


def gaps_of(file):
    return [(n.data["began"], n.data["ended"]) for n in notes(file) if n.kind == "gap"]


def test_a_recording_that_begins_in_a_gap_has_it_from_its_own_begin(recorder, tmp_path):
    begin_session(recorder)
    take(recorder, sampled(5.0))
    take(recorder, gap(6.0))
    recorder.record(SENT, b"\x01\xff\x0d", 7.0)
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    assert recorder.status.gaps == 1
    take(recorder, sampled(8.0))
    recorder.stop()
    assert gaps_of(tmp_path / "a.pcapng") == [(7.0, 8.0)]


def test_a_recording_that_ends_in_a_gap_has_its_latest_reason(recorder, tmp_path):
    file = tmp_path / "a.pcapng"
    recorder.start(file, url="sim:")
    begin_session(recorder)
    for event in (sampled(5.0), gap(6.0), state(7.0, LineState.NO_PORT)):
        take(recorder, event)
    recorder.stop()
    (note,) = (note for note in notes(file) if note.kind == "gap")
    assert note.data["reason"]["en"] == "no adapter"


def test_a_connection_that_is_left_is_one_gap_that_is_open_until_values_come(recorder, tmp_path):
    session, left = SamplingSession(recorder.record_event), Text("left", "закрыто")
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    for event in (state(1.0, LineState.SAMPLING), sampled(5.0)):
        list(session.events_of(event))
    session.leave(6.0, left)
    recorder.interrupt(6.0, left)
    assert recorder.status.gaps == 1
    list(session.events_of(sampled(9.0)))
    assert recorder.stop().gaps == 1
    assert gaps_of(tmp_path / "a.pcapng") == [(5.0, 9.0)]


def test_a_connection_that_was_left_before_a_recording_is_no_gap_in_it(recorder, tmp_path):
    session = SamplingSession(recorder.record_event)
    list(session.events_of(sampled(5.0)))
    session.leave(6.0, Text("left", "закрыто"))
    list(session.events_of(unit(9.0)))
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    list(session.events_of(sampled(9.5)))
    assert recorder.stop().gaps == 0
    assert gaps_of(tmp_path / "a.pcapng") == []


def test_alarms_what_was_learnt_markers_and_words(recorder, tmp_path):
    from recorder_harness import CATALOG

    file = tmp_path / "a.pcapng"
    recorder.start(file, url="sim:")
    begin_session(recorder)
    alarms = Alarms(with_limits(CATALOG, TWAT=AlarmLimits(warning_high=100)))
    for event in alarms.update({"TWAT": 120.0}, 3.0):
        take(recorder, event)
    take(recorder, MethodChosen(4.0, "stream", {"stream": 33.0, "list": 0.0}, Limits()))
    take(recorder, ParameterDropped(4.5, "DET", Limits()))
    assert recorder.marker(label="hill") == 4.5
    assert recorder.marker(5.0) == 5.0
    recorder.text("smoke")
    recorder.stop()
    reported = {str(note.kind): note.data for note in notes(file)}
    assert reported["alarm"]["channel"] == "TWAT"
    learnt = [note.data for note in notes(file) if note.kind == "learnt"]
    assert (learnt[0]["method"], learnt[0]["rates"]) == ("stream", {"stream": 33.0, "list": 0.0})
    assert learnt[1]["dropped"] == "DET"
    assert {"max_list", "refused"} <= set(learnt[0])
    assert [n.data["label"] for n in notes(file) if n.kind == "marker"] == ["hill", ""]
    assert reported["note"] == {"text": "smoke"}


def test_a_marker_before_the_first_event_has_no_time(recorder):
    assert recorder.marker(label="x") is None


# Files that follow one another


def test_another_car_gets_a_file_of_its_own(tmp_path):
    files = []
    recorder = Recorder(on_file=files.append)
    (tmp_path / "a-2.pcapng").write_bytes(b"somebody's")
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    begin_session(recorder)
    take(recorder, sampled(5.0))
    recorder.record(SENT, b"\x01\xff\x0d", 6.0)
    take(recorder, state(7.0, LineState.NO_PORT))
    take(recorder, state(8.0, LineState.ECU_ALIVE))
    take(recorder, unit(9.0, OTHER, another=True))
    recorder.record(SENT, b"\x02\xfe\x0d", 10.0)
    take(recorder, sampled(10.0))
    assert files == [tmp_path / "a-3.pcapng"]
    assert recorder.status.path == files[0]
    take(recorder, unit(11.0, PASSPORT, another=True))
    recorder.stop()
    assert files[1] == tmp_path / "a-4.pcapng"
    assert (tmp_path / "a-2.pcapng").read_bytes() == b"somebody's"
    assert wire(tmp_path / "a.pcapng")[SENT] == b"\x01\xff\x0d"
    assert wire(files[0])[SENT] == b"\x02\xfe\x0d"
    assert kinds(files[0])[:3] == ["unit", "catalog", "state"]  # not the other car's plan
    assert notes(files[0])[0].data["passports"][0] == "Z"
    gaps = [note.data["ended"] for note in notes(tmp_path / "a.pcapng") if note.kind == "gap"]
    assert gaps == [9.0]


def test_the_next_file_begins_with_a_head(tmp_path):
    files = []
    recorder = Recorder(on_file=files.append)
    recorder.next_file()  # nothing is recorded: nothing happens
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    begin_session(recorder)
    take(recorder, sampled(5.0))
    recorder.next_file()
    take(recorder, sampled(6.0))
    assert recorder.stop().samples == 1
    assert kinds(files[0]) == ["unit", "catalog", "plan", "state"]


def test_without_room_for_the_next_file_the_recording_fails(tmp_path, monkeypatch):
    disk = SmallDisk(monkeypatch)
    recorder = Recorder()
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    begin_session(recorder)
    disk.room = 10
    recorder.next_file()
    assert isinstance(recorder.failure, CaptureError)
    recorder.record(SENT, b"\x01\xff\x0d", 9.0)
    assert recorder.stop().failure is not None
    assert wire(tmp_path / "a.pcapng") == {SENT: b"", RECEIVED: b""}


def test_a_clock_that_jumps_loses_nothing(recorder, tmp_path):
    file = tmp_path / "a.pcapng"
    recorder.start(file, url="sim:")
    begin_session(recorder, 100.0)
    for time in (105.0, 50.0, 1e9, 51.0, -5.0, 52.0):
        recorder.record(SENT, b"\x01\xff\x0d", time)
        recorder.record(RECEIVED, b"\x0a\xf6\x0d", time + 0.01)
        take(recorder, sampled(time))
        take(recorder, gap(time + 0.1))
    assert recorder.stop().failure is None
    assert wire(file) == {SENT: b"\x01\xff\x0d" * 6, RECEIVED: b"\x0a\xf6\x0d" * 6}
    assert kinds(file).count("gap") == 6


def test_marking_starting_and_stopping_by_other_threads_lose_nothing(tmp_path):
    recorder = Recorder()
    begin_session(recorder)

    def others(number: int) -> None:
        for turn in range(10):
            recorder.start(tmp_path / f"{number}-{turn}.pcapng", url="sim:")
            recorder.marker(label="x")
            recorder.stop()

    threads = [threading.Thread(target=others, args=(number,)) for number in range(3)]
    for thread in threads:
        thread.start()
    for turn in range(300):
        recorder.record(SENT, b"\x01\xff\x0d", 2.0 + turn)
        take(recorder, sampled(2.0 + turn))
    for thread in threads:
        thread.join()
    assert recorder.status is None
    files = sorted(tmp_path.iterdir())
    assert len(files) == 30
    for file in files:
        wire(file)
        assert kinds(file)[:4] == ["unit", "catalog", "plan", "state"]
