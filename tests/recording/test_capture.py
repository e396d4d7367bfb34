"""What is recorded is read back, to the byte; what can't be recorded is said."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from capture_harness import MICRO, RECEIVED, SENT, contents, read
from hypothesis import example, given
from hypothesis import strategies as st

from capture_writing_harness import appending
from mikas.cleaning import clean_line
from mikas.errors import CaptureError
from mikas.link.base import Direction
from mikas.recording.capture.blocks import OUTBOUND, EnhancedPacket, Interface, Section, encode
from mikas.recording.capture.reader import Source
from mikas.recording.capture.writer import CaptureWriter

chunks = st.lists(
    st.tuples(
        st.sampled_from(Direction),
        st.binary(min_size=1, max_size=30),
        st.integers(-(2**50), 2**50).map(lambda ticks: ticks / MICRO),
    ),
    max_size=12,
)
words = st.text(st.characters(exclude_categories=["Cs"]), max_size=40).map(clean_line)


@given(chunks, words)
@example([(SENT, b"\x01\xff\x0d", 0.0)], "")
@example([(RECEIVED, b"\r", -0.000001)], "sim:?имя=Волга")
def test_what_was_recorded_is_read_back(recorded, url):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "запись.pcapng"
        with CaptureWriter(path, url=url, baud=10400) as writer:
            for chunk in recorded:
                writer.record(*chunk)
        packets, problems = read(path)
    assert not problems
    assert contents(packets) == recorded
    for packet in packets:
        assert packet.source.url == url
        assert packet.source.baud == 10400


def test_the_file_is_whole_before_it_is_closed(path):
    with CaptureWriter(path, url="sim:") as writer:
        assert read(path) == ([], [])
        for count in range(1, 5):
            writer.record(SENT, b"\x01\xff\x0d", count)
            packets, problems = read(path)
            assert (len(packets), problems) == (count, [])


def test_chunks_are_not_merged_and_empty_ones_not_kept(path):
    with CaptureWriter(path, url="sim:") as writer:
        for data in (b"\x0a", b"", b"\xf6\x0d"):
            writer.record(RECEIVED, data, 1.5)
    assert contents(read(path)[0]) == [(RECEIVED, b"\x0a", 1.5), (RECEIVED, b"\xf6\x0d", 1.5)]


def test_a_chunk_too_long_for_other_tools_is_split(path):
    data = bytes(range(256)) * 1500
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(RECEIVED, data, 1)
    packets, _ = read(path)
    assert b"".join(packet.data for packet in packets) == data
    assert max(len(packet.data) for packet in packets) <= 65_536


def test_the_source_says_who_recorded_and_where(path):
    blocks = (
        Section(hardware="FT232", application="test 1"),
        Interface(name="/dev/ttyUSB0", description="K-Line Волга", speed=9600),
        EnhancedPacket(0, 1, b"\x01\xff\x0d", OUTBOUND),
    )
    path.write_bytes(b"".join(map(encode, blocks)))
    (packet,), _ = read(path)
    assert packet.source == Source(0, "/dev/ttyUSB0", "K-Line Волга", 9600, "test 1", "FT232")


def test_the_program_names_itself(path):
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(SENT, b"\x01\xff\x0d", 1)
    assert read(path)[0][0].source.application.startswith("mikas ")


def test_the_same_session_gives_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        with CaptureWriter(tmp_path / name, url="sim:") as writer:
            writer.record(SENT, b"\x01\xff\x0d", 0.25)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_times_before_the_start_are_kept_more_than_once(path):
    times = [5.0, -0.5, -0.25, -1e6, 3.0, -2e6]
    with CaptureWriter(path, url="sim:") as writer:
        for time in times:
            writer.record(SENT, b"x", time)
    packets, problems = read(path)
    assert [packet.time for packet in packets] == times
    assert not problems


# An existing file


def test_an_existing_file_is_not_touched(path):
    path.write_bytes(b"precious")
    with pytest.raises(CaptureError, match="exists already"):
        CaptureWriter(path, url="sim:")
    assert path.read_bytes() == b"precious"


def test_an_existing_file_is_overwritten_if_asked(path):
    path.write_bytes(b"old")
    with CaptureWriter(path, url="sim:", overwrite=True) as writer:
        writer.record(SENT, b"\x01", 1)
    assert contents(read(path)[0]) == [(SENT, b"\x01", 1.0)]


def test_several_recordings_in_a_file_are_all_read(path):
    for number in range(3):
        with appending(path, url=f"sim:{number}") as writer:
            writer.record(SENT, bytes([number]), 10 - number)
    packets, problems = read(path)
    assert not problems
    assert contents(packets) == [(SENT, b"\0", 10.0), (SENT, b"\1", 9.0), (SENT, b"\2", 8.0)]
    assert [(it.source.recording, it.source.url) for it in packets] == [
        (0, "sim:0"),
        (1, "sim:1"),
        (2, "sim:2"),
    ]


# A file that can't be written


@pytest.mark.parametrize("name", ["no/such/folder.pcapng", "."])
def test_a_file_that_can_not_be_made_is_an_error_with_its_path(tmp_path, name):
    with pytest.raises(CaptureError) as caught:
        CaptureWriter(tmp_path / name, url="sim:")
    assert str(tmp_path / name) in str(caught.value)


class Disk:
    """The disk of the next file: `room` for so many bytes more; `stuck`: none can be shortened."""

    def __init__(self, monkeypatch, *, stuck=False):
        self.file, self.room, self.stuck = None, 1 << 30, stuck
        opened = Path.open

        def on_this(path, mode="r", *args, **more):
            file = opened(path, mode, *args, **more)
            if mode != "xb":
                return file
            self.file = file
            return self

        monkeypatch.setattr(Path, "open", on_this)

    def write(self, data):
        if not self.room:
            raise OSError(28, "No space left on device")
        written = self.file.write(data[: self.room])
        self.room -= written
        return written

    def truncate(self, size):
        if self.stuck:
            raise OSError(5, "Input/output error")
        return self.file.truncate(size)

    def __getattr__(self, name):
        return getattr(self.file, name)


@pytest.mark.parametrize("room", range(0, 100, 7))
def test_a_full_disk_takes_back_what_is_half_written(path, room, monkeypatch):
    disk = Disk(monkeypatch)
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(SENT, b"first", 1)
        disk.room = room
        kept = 1
        with pytest.raises(CaptureError, match="no room left"):  # noqa: PT012  (at some record)
            while True:
                writer.record(SENT, b"more", 2)
                kept += 1
        assert [len(it) for it in read(path)] == [kept, 0]
        disk.room = 1000  # somebody made room
        writer.record(RECEIVED, b"later", 3)
    packets, problems = read(path)
    assert not problems
    assert len(packets) == kept + 1
    assert packets[-1].data == b"later"


def test_a_broken_medium_is_left_alone_after_the_first_failure(path, monkeypatch):
    disk = Disk(monkeypatch, stuck=True)
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(SENT, b"first", 1)
        disk.room = 10
        with pytest.raises(CaptureError, match="no room left"):
            writer.record(SENT, b"more", 2)
        disk.room = 1000
        with pytest.raises(CaptureError, match="over"):
            writer.record(SENT, b"more", 3)
    packets, (problem,) = read(path)
    assert contents(packets) == [(SENT, b"first", 1.0)]
    assert "interrupted" in problem.text.en


def test_ctrl_c_in_the_middle_of_a_packet_leaves_no_part_of_it(path, monkeypatch):
    class Interrupted(Disk):
        def write(self, data):
            if self.room:
                return self.file.write(data)
            self.file.write(data[:10])
            raise KeyboardInterrupt

    disk = Interrupted(monkeypatch)

    with CaptureWriter(path, url="sim:") as writer:
        disk.room = 0
        with pytest.raises(KeyboardInterrupt):
            writer.record(SENT, b"more", 2)
    assert read(path) == ([], [])


def test_closing_twice_is_closing_once_and_recording_after_it_an_error(path):
    writer = CaptureWriter(path, url="sim:")
    writer.close()
    writer.close()
    with pytest.raises(CaptureError, match="over"):
        writer.record(SENT, b"x", 1)
