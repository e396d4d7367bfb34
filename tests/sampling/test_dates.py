"""A recording has its true dates, whatever the computer's date does while it is made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from computer_harness import BEGAN, NIGHT, YEARS, Computer, record
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.recording.annotations.events import events_of, note_of
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.reader import CaptureReader, Packet
from mikas.recording.capture.scan import RawBlock, scan
from mikas.recording.capture.writer import append_note
from mikas.recording.summary import summarise
from mikas.recording.table.raw_recording import RawRecording
from mikas.sampling.events import SLEPT, ClockChanged, Gap, Marker, UnitFound
from protocol_codes import SECTION_4


def another_unit(time: float) -> UnitFound:
    return UnitFound(time, 0x0B, None, another=True)


def packets(path: Path) -> list[Packet]:
    return [item for item in CaptureReader(path) if isinstance(item, Packet)]


def raw_times(path: Path) -> list[float]:
    """The packets' times as another program reads them."""
    with path.open("rb", buffering=0) as file:
        raw = [item for item in scan(file) if isinstance(item, RawBlock)]
    read = [pcapng.parse(item.kind, item.body, item.order) for item in raw]
    return [block.ticks / 1e6 for block in read if isinstance(block, pcapng.EnhancedPacket)]


def row_times(path: Path) -> list[float]:
    raw = RawRecording(path, SECTION_4.size_of)
    return [time for rows in raw.stretches() for time in rows.times.tolist()]


def clock_notes(path: Path) -> list[ClockChanged]:
    found = events_of(CaptureReader(path).notes(), SECTION_4)
    return [event for event in found if isinstance(event, ClockChanged)]


@pytest.fixture(scope="module")
def steady(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("steady") / "steady.pcapng"
    record(path, Computer())
    return path


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Callable[..., Path]:
    """Recordings without a jump, each made once."""
    folder = tmp_path_factory.mktemp("undisturbed")

    def made(seconds: float, method: str, *silent: float) -> Path:
        path = folder / f"{method}-{seconds}-{silent}.pcapng"
        if not path.exists():
            computer = Computer()
            if silent:
                computer.silent(*silent)
            record(path, computer, seconds, method=method)
        return path

    return made


def spaced(times: list[float]) -> list[float]:
    return [round(after - before, 5) for before, after in pairwise(times)]


@pytest.mark.parametrize(
    ("seconds", "method"),
    [(it, "batch") for it in (YEARS, NIGHT, 1.5, -1.5, -YEARS)] + [(-60, "stream")],
)
def test_a_date_that_is_set_while_values_come_dates_all_of_the_recording(
    undisturbed, tmp_path, seconds, method
):
    alone, path = undisturbed(9.0, method), tmp_path / "a.pcapng"
    computer = Computer()
    computer.at(3.5, lambda: computer.jump(seconds))
    events = record(path, computer, 9.0, method=method)
    assert not [event for event in events if isinstance(event, Gap)]
    [change] = clock_notes(path)
    assert (change.seconds, change.slept) == (pytest.approx(seconds, abs=0.01), False)
    assert change.after - change.before == pytest.approx(seconds, abs=0.01)
    assert computer.session.later == change.seconds
    assert spaced(raw_times(path)) == spaced(raw_times(alone))  # in order for other programs
    times = [packet.time for packet in packets(path)]
    assert times == pytest.approx([packet.time + seconds for packet in packets(alone)], abs=0.01)
    assert row_times(path) == pytest.approx([t + seconds for t in row_times(alone)], abs=0.01)
    assert spaced(row_times(path)) == spaced(row_times(alone))
    assert summarise(path).date == pytest.approx(summarise(alone).date + seconds, abs=0.01)


@pytest.mark.parametrize("method", ["batch", "stream"])
@pytest.mark.parametrize("jumped_at", [3.5, 5.5])
def test_a_sleep_is_a_gap_of_its_true_length_and_all_values_have_true_dates(
    undisturbed, tmp_path, method, jumped_at
):
    alone, path = undisturbed(13.0, method, 4.0, 7.0), tmp_path / "a.pcapng"
    computer = Computer()
    computer.silent(4.0, 7.0)
    computer.at(jumped_at, lambda: computer.jump(NIGHT))
    record(path, computer, 13.0, method=method)
    [change] = clock_notes(path)
    assert (change.seconds, change.slept) == (pytest.approx(NIGHT, abs=0.01), True)
    expected = [e for e in events_of(CaptureReader(alone).notes(), SECTION_4) if type(e) is Gap]
    gaps = [e for e in events_of(CaptureReader(path).notes(), SECTION_4) if type(e) is Gap]
    [gap], [shorter] = gaps, expected
    assert gap.reason == SLEPT
    assert gap.began == pytest.approx(shorter.began, abs=0.5)
    assert gap.ended - gap.began == pytest.approx(NIGHT + shorter.ended - shorter.began, abs=5)
    times = row_times(path)
    assert times == sorted(times)
    before = [time for time in times if time < gap.began + 1]
    assert before == pytest.approx(row_times(alone)[: len(before)], abs=0.01)
    assert len(before) < len(times)
    assert all(time >= gap.ended - 1 for time in times[len(before) :])
    assert min(times[len(before) :]) - max(before) > NIGHT


@pytest.mark.parametrize("method", ["batch", "stream"])
def test_a_virtual_car_that_stood_still_in_a_sleep_goes_on_with_true_dates(
    undisturbed, tmp_path, method
):
    alone, path, later = undisturbed(9.0, method), tmp_path / "a.pcapng", tmp_path / "b.pcapng"
    computer = Computer()
    computer.at(4.0, lambda: computer.suspend(NIGHT))
    computer.at(7.0, lambda: computer.recorder.start(later, url="sim:"))
    record(path, computer, 9.0, method=method)
    [change] = clock_notes(path)
    assert (change.seconds, change.slept) == (pytest.approx(NIGHT, abs=0.5), True)
    [gap] = [e for e in events_of(CaptureReader(path).notes(), SECTION_4) if type(e) is Gap]
    assert (gap.reason, gap.ended - gap.began) == (SLEPT, pytest.approx(NIGHT, abs=2))
    times = row_times(path)
    assert times[0] == pytest.approx(row_times(alone)[0], abs=0.01)
    assert max(spaced(times)) == pytest.approx(NIGHT, abs=2)
    assert packets(later)[0].time == pytest.approx(BEGAN + 7 + NIGHT, abs=1)
    assert clock_notes(later) == []


@pytest.mark.parametrize("seconds", [YEARS, NIGHT, -NIGHT])
def test_a_recording_begun_next_morning_in_the_same_connection_has_its_true_date(tmp_path, seconds):
    computer, path = Computer(), tmp_path / "next.pcapng"
    computer.at(5.0, lambda: computer.jump(seconds))
    computer.at(10.0, lambda: computer.recorder.start(path, url="sim:"))
    computer.run(12.0)
    computer.recorder.stop()
    assert clock_notes(path) == []
    for time in (raw_times(path)[0], packets(path)[0].time, next(CaptureReader(path).notes()).time):
        assert time == pytest.approx(BEGAN + 10 + seconds, abs=1)


@pytest.mark.parametrize("seconds", [YEARS, -NIGHT])
def test_a_date_that_was_set_between_the_program_and_its_first_connection_is_noted(
    tmp_path, seconds
):
    computer, path = Computer(), tmp_path / "a.pcapng"
    computer.jump(seconds)
    record(path, computer)
    [change] = clock_notes(path)
    assert change.seconds == pytest.approx(seconds, abs=0.01)
    assert packets(path)[0].time == pytest.approx(BEGAN + seconds, abs=5)


def test_an_edit_of_a_recording_whose_date_was_set_hits_its_marker(tmp_path):
    computer, path = Computer(), tmp_path / "a.pcapng"
    computer.at(3.5, lambda: computer.recorder.marker(label="hill"))
    computer.at(4.0, lambda: computer.jump(YEARS + 0.123))
    record(path, computer)

    def markers() -> list[Marker]:
        found = events_of(CaptureReader(path).notes(), SECTION_4)
        return [event for event in found if isinstance(event, Marker)]

    [marker] = markers()
    append_note(path, note_of(replace(marker, label="bridge", renamed=True)))
    assert markers() == [replace(marker, label="bridge")]
    append_note(path, note_of(replace(marker, removed=True)))
    assert markers() == []


@pytest.mark.parametrize("seconds", [NIGHT, -NIGHT, YEARS])
@pytest.mark.parametrize("end", ["session", "stop", "start", "next file", "another unit"])
def test_the_date_that_was_set_just_before_the_end_of_a_file_is_noted_in_it(tmp_path, seconds, end):
    computer, path, later = Computer(), tmp_path / "a.pcapng", tmp_path / "a-2.pcapng"
    ends = {
        "stop": computer.recorder.stop,
        "start": lambda: computer.recorder.start(later, url="sim:"),
        "next file": computer.recorder.next_file,
        "another unit": lambda: computer.recorder.record_event(another_unit(computer.now())),
    }
    computer.at(4.0, lambda: computer.jump(seconds))
    if end in ends:
        computer.at(6.0, ends[end])
    events = record(path, computer, 7.0 if end in ends else 6.0)
    [change] = clock_notes(path)
    assert (change.seconds, change.slept) == (pytest.approx(seconds, abs=0.01), False)
    assert packets(path)[0].time == pytest.approx(BEGAN + seconds, abs=5)
    if end in ends:
        assert [it.seconds for it in events if isinstance(it, ClockChanged)] == [change.seconds]
    if later.exists():
        assert clock_notes(later) == []
        assert packets(later)[0].time == pytest.approx(BEGAN + 6 + seconds, abs=1)


def test_a_sleep_that_no_values_followed_moves_no_recording_that_ends_with_it(tmp_path):
    computer, path = Computer(), tmp_path / "a.pcapng"
    computer.silent(4.0, 9.0)

    def wake_and_stop() -> None:
        computer.jump(NIGHT)
        computer.recorder.stop()

    computer.at(4.1, wake_and_stop)
    computer.recorder.start(path, url="sim:")
    [change] = [it for it in computer.run(9.0) if isinstance(it, ClockChanged)]
    assert change.slept
    assert clock_notes(path) == []
    assert packets(path)[0].time == pytest.approx(BEGAN, abs=5)


def test_a_file_of_an_unknown_writer_is_read_with_any_note_of_a_clock(steady, tmp_path):
    for seconds in ("1e400", "-1e300", '"x"', "true", "null", "[]", "9" * 30):
        path = tmp_path / "a.pcapng"
        data = f'{{"kind":"clock","time":1,"data":{{"seconds":{seconds}}}}}'.encode()
        block = pcapng.encode(pcapng.Custom(32473, b"mikas/1\n" + data))
        path.write_bytes(steady.read_bytes() + block)
        assert packets(path) == packets(steady)


jumps = st.lists(
    st.tuples(st.floats(2.5, 8), st.floats(-YEARS, YEARS).filter(lambda it: abs(it) > 2)),
    min_size=1,
    max_size=3,
)


@settings(max_examples=10, deadline=None)
@given(jumps)
def test_random_jumps_move_no_value_against_its_neighbours(steady, jumped):
    computer = Computer()
    for moment, seconds in jumped:
        computer.at(moment, lambda seconds=seconds: computer.jump(seconds))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.pcapng"
        record(path, computer)
        assert spaced(raw_times(path)) == spaced(raw_times(steady))
        assert spaced(row_times(path)) == spaced(row_times(steady))
        assert [it.data for it in packets(path)] == [it.data for it in packets(steady)]
        noted = sum(change.seconds for change in clock_notes(path))
        assert noted == pytest.approx(computer.jumped, abs=1.1)
        assert row_times(path) == pytest.approx([it + noted for it in row_times(steady)], abs=0.01)
