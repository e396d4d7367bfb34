"""The recorder on a disk that is full at any byte: the file stays whole, the error is reported."""

from __future__ import annotations

import pytest
from recorder_harness import (
    RECEIVED,
    SENT,
    SmallDisk,
    begin_session,
    gap,
    kinds,
    sampled,
    take,
    wire,
)

from mikas.errors import CaptureError, DiskFull
from mikas.recording.recorder import Recorder


def _session(recorder) -> None:
    """A bit of everything."""
    recorder.record(SENT, b"\x01\xff\x0d", 1.0)
    recorder.record(RECEIVED, b"\x01\xff\x0d\x0a\xf6\x0d", 1.1)
    begin_session(recorder, 1.2)
    recorder.record(RECEIVED, b"\x0a", 2.0)
    take(recorder, sampled(2.0))
    take(recorder, gap(3.0))
    take(recorder, sampled(4.0))


def test_a_disk_that_is_full_at_any_byte_hurts_nothing_written(tmp_path, monkeypatch):
    disk = SmallDisk(monkeypatch)
    recorder = Recorder()
    recorder.start(tmp_path / "whole.pcapng", url="sim:")
    first = recorder.status.bytes
    _session(recorder)
    whole = recorder.stop().bytes
    passed = wire(tmp_path / "whole.pcapng")
    reported = kinds(tmp_path / "whole.pcapng")
    for room in range(first, whole, 3):  # odd: each place in a word of four bytes
        file = tmp_path / f"{room}.pcapng"
        disk.room = room
        recorder = Recorder()
        recorder.start(file, url="sim:")
        _session(recorder)
        status = recorder.status
        assert isinstance(recorder.failure, CaptureError)
        assert "full" in status.failure.reason.en
        assert status.bytes == file.stat().st_size <= room
        kept, notes = wire(file), kinds(file)
        assert passed[SENT].startswith(kept[SENT])
        assert passed[RECEIVED].startswith(kept[RECEIVED])
        assert reported[: len(notes)] == notes
        assert recorder.stop().failure is status.failure
    disk.room = 1 << 30
    recorder.start(tmp_path / "again.pcapng", url="sim:")
    recorder.record(SENT, b"\x01\xff\x0d", 9.0)
    assert recorder.stop().failure is None
    assert kinds(tmp_path / "again.pcapng") == ["unit", "catalog", "plan", "state"]


def test_samples_that_are_not_in_the_file_are_counted_apart(recorder, tmp_path, monkeypatch):
    disk = SmallDisk(monkeypatch)
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    begin_session(recorder)

    def cycle(time: float) -> None:
        recorder.record(SENT, b"\x01\xff\x0d", time)
        recorder.record(RECEIVED, b"\x0a\xf6\x0d", time + 0.01)
        take(recorder, sampled(time))

    for turn in range(3):
        cycle(10.0 + turn)
    assert (recorder.status.samples, recorder.status.lost) == (3, 0)
    disk.room = 60  # for the request, but not for the response
    for turn in range(4):
        cycle(20.0 + turn)
    assert recorder.failure is not None
    assert (recorder.status.samples, recorder.status.lost) == (3, 4)
    status = recorder.stop()
    assert (status.samples, status.lost) == (3, 4)
    assert wire(tmp_path / "a.pcapng")[RECEIVED] == 3 * b"\x0a\xf6\x0d"
    disk.room = 1 << 30
    recorder.start(tmp_path / "b.pcapng", url="sim:")
    cycle(30.0)
    status = recorder.stop()
    assert (status.samples, status.lost) == (1, 0)


def test_a_disk_that_is_full_at_the_start_is_an_error_at_the_start(tmp_path, monkeypatch):
    disk = SmallDisk(monkeypatch)
    disk.room = 10
    recorder = Recorder()
    with pytest.raises(DiskFull, match="there is no room left"):
        recorder.start(tmp_path / "a.pcapng", url="sim:")
    assert recorder.status is None
    assert not list(tmp_path.iterdir())  # the same command works once there is room
    disk.room = 1 << 30
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    recorder.stop()


def test_the_reason_of_the_break_off_is_kept_to_the_end(recorder, tmp_path, monkeypatch):
    disk = SmallDisk(monkeypatch)
    recorder.start(tmp_path / "a.pcapng", url="sim:")
    begin_session(recorder)
    disk.room = 100
    for at in range(40):
        recorder.record(SENT, b"\x01\xff\x0d", 2.0 + at)
        recorder.record(RECEIVED, b"\x01\xff", 2.1 + at)
        take(recorder, sampled(2.2 + at))
        take(recorder, gap(2.9 + at))
        if recorder.failure is not None:
            why = recorder.failure
            disk.room = 1 << 20
            break
    for at in range(100, 110):
        recorder.record(RECEIVED, b"\x01\xff", at)
        take(recorder, sampled(at + 5.0))
    assert recorder.failure is why
    assert recorder.stop().failure is why
