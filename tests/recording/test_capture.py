"""What is recorded is read back: whole files, other programs' files, damaged files."""

from __future__ import annotations

import struct
import tempfile
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mikas.errors import CaptureError
from mikas.link.tee import Direction
from mikas.recording import pcapng
from mikas.recording.capture import CaptureReader, CaptureWriter, Packet, Problem, Source
from mikas.recording.pcapng import Custom, EnhancedPacket, Interface, Section, SimplePacket

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED
MICRO = 1_000_000

chunks = st.lists(
    st.tuples(
        st.sampled_from(Direction),
        st.binary(min_size=1, max_size=30),
        st.integers(-(2**50), 2**50).map(lambda ticks: ticks / MICRO),
    ),
    max_size=12,
)
words = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=40)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "line.pcapng"


def read(path):
    items = list(CaptureReader(path))
    return (
        [item for item in items if isinstance(item, Packet)],
        [item for item in items if isinstance(item, Problem)],
    )


def contents(packets):
    return [(packet.direction, packet.data, packet.time) for packet in packets]


def write_blocks(path, *blocks, order="<"):
    path.write_bytes(b"".join(pcapng.encode(block, order) for block in blocks))


@given(chunks, words, words)
@example([(SENT, b"\x01\xff\x0d", 0.0)], "", "")
@example([(RECEIVED, b"\r", -0.000001)], "sim:?имя=Волга", "K-Line №1")
def test_what_was_recorded_is_read_back(recorded, url, description):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "запись.pcapng"
        with CaptureWriter(path, url=url, description=description, baud=10400) as writer:
            for chunk in recorded:
                writer.record(*chunk)
        packets, problems = read(path)
    assert not problems
    assert contents(packets) == recorded
    for packet in packets:
        assert (packet.source.url, packet.source.description) == (url, description)
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
    with CaptureWriter(path, url="/dev/ttyUSB0", hardware="FT232", application="test 1") as writer:
        writer.record(SENT, b"\x01\xff\x0d", 1)
    (packet,), _ = read(path)
    assert packet.source == Source(0, "/dev/ttyUSB0", "", 9600, "test 1", "FT232")


def test_the_program_names_itself(path):
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(SENT, b"\x01\xff\x0d", 1)
    assert read(path)[0][0].source.application.startswith("mikas ")


def test_the_same_session_gives_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        with CaptureWriter(tmp_path / name, url="sim:") as writer:
            writer.record(SENT, b"\x01\xff\x0d", 0.25)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_time_that_dives_below_its_start_more_than_once(path):
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


def test_appending_begins_a_new_recording(path):
    for number in range(3):
        with CaptureWriter(path, url=f"sim:{number}", append=True) as writer:
            writer.record(SENT, bytes([number]), 10 - number)
            assert writer.removed == 0
    packets, problems = read(path)
    assert not problems
    assert contents(packets) == [(SENT, b"\0", 10.0), (SENT, b"\1", 9.0), (SENT, b"\2", 8.0)]
    assert [(it.source.recording, it.source.url) for it in packets] == [
        (0, "sim:0"),
        (1, "sim:1"),
        (2, "sim:2"),
    ]


def test_appending_to_an_empty_file(path):
    path.touch()
    with CaptureWriter(path, url="sim:", append=True) as writer:
        writer.record(SENT, b"\1", 1)
    assert contents(read(path)[0]) == [(SENT, b"\1", 1.0)]


def test_appending_behind_an_interrupted_recording(path):
    whole = small_capture(path)
    for length in range(1, len(whole)):
        path.write_bytes(whole[:length])
        before, problems = read(path)
        with CaptureWriter(path, url="sim:", append=True) as writer:
            writer.record(SENT, b"new", 99)
            assert bool(writer.removed) == bool(problems)
        after, problems = read(path)
        assert not problems
        assert contents(after) == [*contents(before), (SENT, b"new", 99.0)]


@pytest.mark.parametrize("content", [b"time;rpm\n0;850\n", bytes(100)])
def test_appending_to_a_foreign_file_leaves_it_alone(path, content):
    path.write_bytes(content)
    with pytest.raises(CaptureError, match="not a capture"):
        CaptureWriter(path, url="sim:", append=True)
    assert path.read_bytes() == content


def test_overwriting_and_appending_contradict_each_other(path):
    with pytest.raises(ValueError, match="either"):
        CaptureWriter(path, url="sim:", append=True, overwrite=True)


# A file that can't be written


@pytest.mark.parametrize("name", ["no/such/folder.pcapng", "."])
def test_a_file_that_can_not_be_made(tmp_path, name):
    with pytest.raises(CaptureError) as caught:
        CaptureWriter(tmp_path / name, url="sim:")
    assert str(tmp_path / name) in str(caught.value)


class FullDisk:
    """A file with room for so many bytes more; `stuck`: it can't be shortened either."""

    def __init__(self, file, room, *, stuck=False):
        self.file, self.room, self.stuck = file, room, stuck

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
def test_a_full_disk_takes_back_what_is_half_written(path, room):
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(SENT, b"first", 1)
        writer._file = disk = FullDisk(writer._file, room)
        kept = 1
        with pytest.raises(CaptureError, match="no room left"):  # noqa: PT012
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


def test_a_broken_medium_is_left_alone_after_the_first_failure(path):
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(SENT, b"first", 1)
        writer._file = disk = FullDisk(writer._file, 10, stuck=True)
        with pytest.raises(CaptureError, match="no room left"):
            writer.record(SENT, b"more", 2)
        disk.room = 1000
        with pytest.raises(CaptureError, match="over"):
            writer.record(SENT, b"more", 3)
    packets, (problem,) = read(path)
    assert contents(packets) == [(SENT, b"first", 1.0)]
    assert "interrupted" in problem.text.en


def test_ctrl_c_in_the_middle_of_a_packet(path):
    class Interrupted(FullDisk):
        def write(self, data):
            self.file.write(data[:10])
            raise KeyboardInterrupt

    with CaptureWriter(path, url="sim:") as writer:
        writer._file = Interrupted(writer._file, 0)
        with pytest.raises(KeyboardInterrupt):
            writer.record(SENT, b"more", 2)
    assert read(path) == ([], [])


def test_closing_twice_and_recording_after_it(path):
    writer = CaptureWriter(path, url="sim:")
    writer.close()
    writer.close()
    with pytest.raises(CaptureError, match="over"):
        writer.record(SENT, b"x", 1)


# A file that is no capture


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"time;rpm\n0;850\n", "not a capture"),
        (b"x", "not a capture"),
        (bytes(64), "not a capture"),
        (b"\x0a\x0d\x0d\x0a" + bytes(60), "not a capture"),
        (bytes.fromhex("d4c3b2a1020004000000000000000000ffff000093000000"), "old pcap"),
        (b"\x1f\x8b\x08" + bytes(20), "compressed"),
    ],
)
def test_a_foreign_file(path, content, words):
    path.write_bytes(content)
    with pytest.raises(CaptureError, match=words) as caught:
        CaptureReader(path)
    assert caught.value.offset == 0
    assert caught.value.text.ru != caught.value.text.en


@pytest.mark.parametrize("name", ["absent.pcapng", "."])
def test_a_file_that_can_not_be_opened(tmp_path, name):
    with pytest.raises(CaptureError):
        CaptureReader(tmp_path / name)


def test_a_file_that_vanished_after_a_first_look(path):
    small_capture(path)
    reader = CaptureReader(path)
    path.unlink()
    with pytest.raises(CaptureError, match="no such file"):
        list(reader)


def test_a_capture_of_something_else(path):
    write_blocks(path, Section(), Interface(link_type=1), EnhancedPacket(0, 0, b"x" * 60))
    with pytest.raises(CaptureError, match="link type 1"):
        CaptureReader(path)


def test_other_interfaces_beside_ours_are_passed_over(path):
    write_blocks(
        path,
        Section(),
        Interface(link_type=1),
        Interface(name="ours"),
        EnhancedPacket(0, 1, b"ethernet", pcapng.INBOUND),
        SimplePacket(b"ethernet"),
        EnhancedPacket(1, 2, b"line", pcapng.INBOUND),
    )
    (packet,), (problem,) = read(path)
    assert (packet.data, packet.source.url) == (b"line", "ours")
    assert "link type 1" in problem.text.en


# Files of other programs


@pytest.mark.parametrize("order", ["<", ">"])
def test_other_resolutions_interfaces_and_sections(path, order):
    write_blocks(
        path,
        Section(),
        Interface(name="a", tsresol=9),
        Interface(name="b", tsresol=0x80 | 20),
        EnhancedPacket(0, 1_700_000_000 * 10**9, b"1", pcapng.OUTBOUND),
        EnhancedPacket(1, 3 << 19, b"2", pcapng.INBOUND | 0x1F0),
        Section(),
        Interface(name="c", tsresol=0, tsoffset=-10),
        EnhancedPacket(0, 3, b"3", pcapng.INBOUND, comment="gear"),
        order=order,
    )
    packets, problems = read(path)
    assert not problems
    assert [(it.source.url, it.direction, it.data, it.time, it.comment) for it in packets] == [
        ("a", SENT, b"1", 1.7e9, ""),
        ("b", RECEIVED, b"2", 1.5, ""),
        ("c", RECEIVED, b"3", -7.0, "gear"),
    ]


def test_byte_orders_may_change_from_section_to_section(path):
    parts = [Section(), Interface(), EnhancedPacket(0, MICRO, b"x", pcapng.INBOUND)]
    write_blocks(path, *parts)
    little = path.read_bytes()
    write_blocks(path, *parts, order=">")
    path.write_bytes(little + path.read_bytes() + little)
    packets, problems = read(path)
    assert (len(packets), problems) == (3, [])


def test_unknown_and_custom_blocks_are_passed_over(path):
    unknown = struct.pack("<II", 0x80000005, 200_000) + bytes(199_988) + struct.pack("<I", 200_000)
    with CaptureWriter(path, url="sim:") as writer:
        writer.record(SENT, b"1", 1)
    with path.open("ab") as file:
        file.write(unknown + pcapng.encode(Custom(32473, b"later work")))
        file.write(pcapng.encode(EnhancedPacket(0, 2 * MICRO, b"2", pcapng.INBOUND)))
    packets, problems = read(path)
    assert contents(packets) == [(SENT, b"1", 1.0), (RECEIVED, b"2", 2.0)]
    assert not problems


@pytest.mark.parametrize(
    ("block", "words"),
    [
        (SimplePacket(b"x"), "sent or received"),
        (EnhancedPacket(0, 0, b"x"), "sent or received"),
        (EnhancedPacket(7, 0, b"x", pcapng.INBOUND), "not described"),
        (Section(version=(2, 0)), "version 2"),
    ],
)
def test_what_can_not_be_used_is_a_problem(path, block, words):
    write_blocks(path, Section(), Interface(), block)
    packets, (problem,) = read(path)
    assert not packets
    assert words in problem.text.en
    assert problem.offset == len(pcapng.encode(Section()) + pcapng.encode(Interface()))


def test_a_section_of_an_unknown_version_ends_with_the_next(path):
    packet = EnhancedPacket(0, 0, b"x", pcapng.INBOUND)
    future = (Section(version=(2, 0)), Interface(), packet)
    write_blocks(path, *future, Section(), Interface(), packet)
    assert [len(it) for it in read(path)] == [1, 1]


def test_a_packet_recorded_in_part(path):
    write_blocks(path, Section(), Interface(), EnhancedPacket(0, 0, b"x", pcapng.INBOUND, cut=5))
    problem, packet = CaptureReader(path)
    assert packet.data == b"x"
    assert "last 5 byte" in problem.text.en


# Damaged files


def small_capture(path):
    with CaptureWriter(path, url="sim:", overwrite=True) as writer:
        for number in range(4):
            writer.record(SENT, b"\x61\x1a\x85\x0d"[: number + 1], number)
            writer.record(RECEIVED, b"\x7d\x83\x0d", number + 0.5)
    return path.read_bytes()


def test_cut_at_every_byte_it_yields_what_came_before(path):
    whole = small_capture(path)
    everything = list(CaptureReader(path))
    ends = {item.offset for item in everything} | {len(whole)}
    path.write_bytes(b"")
    with pytest.raises(CaptureError):
        CaptureReader(path)
    for length in range(1, len(whole)):
        path.write_bytes(whole[:length])
        packets, problems = read(path)
        assert packets == everything[: len(packets)]
        if length in ends:
            assert not problems
        elif problems:
            assert len(problems) == 1
            assert "interrupted" in problems[0].text.en
            assert problems[0].offset < length
        assert len(packets) == sum(following <= length for following in sorted(ends)[1:])


def test_a_damaged_length_costs_one_packet(path):
    whole = bytearray(small_capture(path))
    everything = list(CaptureReader(path))
    at = everything[2].offset
    for value in (0, 4, 13, 14, 0x7FFFFFFC, 0xFFFFFFFF, 1 << 20):
        struct.pack_into("<I", whole, at + 4, value)
        path.write_bytes(whole)
        packets, (problem,) = read(path)
        assert packets == everything[:2] + everything[3:]
        assert problem.offset == at
        assert "damaged" in problem.text.en


def test_a_body_that_contradicts_itself_costs_one_packet(path):
    whole = bytearray(small_capture(path))
    everything = list(CaptureReader(path))
    at = everything[2].offset
    struct.pack_into("<I", whole, at + 20, 10_000)  # the captured length
    path.write_bytes(whole)
    packets, (problem,) = read(path)
    assert packets == everything[:2] + everything[3:]
    assert problem.offset == at


def test_zeros_behind_the_end_as_a_power_cut_leaves_them(path):
    whole = small_capture(path)
    everything = list(CaptureReader(path))
    path.write_bytes(whole + bytes(100_000))
    packets, (problem,) = read(path)
    assert packets == everything
    assert (problem.offset, "100000 damaged" in problem.text.en) == (len(whole), True)


def test_two_files_joined_end_to_end_the_first_one_cut_short(path):
    whole = small_capture(path)
    everything = contents(CaptureReader(path))
    path.write_bytes(whole[:-5] + whole)
    packets, (problem,) = read(path)
    assert contents(packets) == everything[:-1] + everything
    assert "damaged" in problem.text.en


@given(st.data())
def test_no_damage_makes_the_reader_raise(data):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "line.pcapng"
        whole = bytearray(small_capture(path))
        for _ in range(data.draw(st.integers(1, 4))):
            at = data.draw(st.integers(12, len(whole) - 1))
            whole[at : at + data.draw(st.integers(0, 6))] = data.draw(st.binary(max_size=6))
        path.write_bytes(whole)
        try:
            reader = CaptureReader(path)
        except CaptureError as error:  # the link type was hit
            assert "link type" in str(error)
        else:
            for item in reader:
                assert isinstance(item, Packet | Problem)


def test_memory_does_not_grow_with_the_file(path):
    import tracemalloc

    with CaptureWriter(path, url="sim:") as writer:
        for number in range(20_000):
            writer.record(RECEIVED, bytes(32), number)
    tracemalloc.start()
    try:
        assert sum(1 for _ in CaptureReader(path)) == 20_000
        assert tracemalloc.get_traced_memory()[1] < 200_000
    finally:
        tracemalloc.stop()
