"""What only POSIX has: limits on a file's size, named pipes, files deleted while open."""

from __future__ import annotations

import os
import resource
import threading

import pytest

from mikas.errors import CaptureError
from mikas.link.base import Direction
from mikas.recording.capture.reader import CaptureReader
from mikas.recording.capture.writer import CaptureWriter
from mikas.recording.summary import summarise

SENT = Direction.SENT


def test_a_file_that_may_not_grow_stays_whole(tmp_path):
    path = tmp_path / "line.pcapng"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    with CaptureWriter(path, url="sim:") as writer:
        try:
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
            kept = 0
            with pytest.raises(CaptureError, match="no room left"):  # noqa: PT012  (at some record)
                while True:
                    writer.record(SENT, b"0123456789", kept)
                    kept += 1
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
        assert kept > 5
        assert [packet.time for packet in CaptureReader(path)] == list(range(kept))


def test_a_file_deleted_while_being_recorded_is_an_error(tmp_path):
    path = tmp_path / "line.pcapng"
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(SENT, b"x", 100.0)
        path.unlink()
        with pytest.raises(CaptureError, match="deleted"):  # noqa: PT012  (at some record)
            for tenth in range(20):
                writer.record(SENT, b"x", 100 + tenth / 10)
        assert tenth == 10  # looked for once a second
        with pytest.raises(CaptureError, match="over"):
            writer.record(SENT, b"x", 102.0)


def test_a_file_renamed_while_being_recorded_is_recorded_on(tmp_path):
    path = tmp_path / "line.pcapng"
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(SENT, b"x", 100.0)
        path.rename(tmp_path / "renamed")
        writer.record(SENT, b"x", 200.0)
    assert len(list(CaptureReader(tmp_path / "renamed"))) == 2


def test_a_named_pipe_can_be_watched_through(tmp_path):
    pipe, copy = tmp_path / "pipe", tmp_path / "copy.pcapng"
    os.mkfifo(pipe)
    watcher = threading.Thread(target=lambda: copy.write_bytes(pipe.read_bytes()), daemon=True)
    watcher.start()
    with CaptureWriter(pipe, url="sim:") as writer:
        writer.record(SENT, b"\x01\xff\x0d", 1.5)
    watcher.join()
    (packet,) = CaptureReader(copy)
    assert (packet.data, packet.time) == (b"\x01\xff\x0d", 1.5)


def test_a_folder_that_may_not_be_written_is_an_error(tmp_path):
    # Root may write anywhere, so the folder is one where no user can.
    with pytest.raises(CaptureError):
        CaptureWriter("/proc/line.pcapng", url="sim:")


def test_a_device_without_room_is_an_error():
    with pytest.raises(CaptureError):
        CaptureWriter("/dev/full", url="sim:")


def test_a_pipe_is_not_read():
    reading, writing = os.pipe()
    try:
        with pytest.raises(CaptureError, match="this is a pipe"):
            CaptureReader(f"/dev/fd/{reading}")
    finally:
        os.close(reading)
        os.close(writing)


def test_a_pipe_without_a_writer_is_not_waited_for(tmp_path):
    """Nor one that takes the place of a recording between the look and the opening."""
    pipe = tmp_path / "a.pcapng"
    os.mkfifo(pipe)
    with pytest.raises(CaptureError, match="this is a pipe"):
        CaptureReader(pipe)
    assert "канал" in summarise(pipe).problem.ru
    with pytest.raises(CaptureError, match="exists"):
        CaptureWriter(pipe, url="sim:", pipe=False)
