"""What is not as we write it: foreign files, other programs' captures, damage."""

from __future__ import annotations

import struct
import tempfile
from pathlib import Path

import pytest
from capture_harness import MICRO, RECEIVED, SENT, contents, read, small_capture
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import CaptureError
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.blocks import Custom, EnhancedPacket, Interface, Section, SimplePacket
from mikas.recording.capture.notes import Kind, Note
from mikas.recording.capture.reader import CaptureReader, Packet, Problem
from mikas.recording.capture.scan import LARGEST
from mikas.recording.capture.writer import CaptureWriter
from mikas.recording.summary import summarise


def write_blocks(path, *blocks, order="<"):
    path.write_bytes(b"".join(pcapng.encode(block, order) for block in blocks))


LINE = (Section(application="mikas 1"), Interface(), EnhancedPacket(0, 1, b"x", pcapng.INBOUND))

# A file that is no capture


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "empty"),
        (b"time;rpm\n0;850\n", "not a recording"),
        (b"x", "not a recording"),
        (bytes(64), "not a recording"),
        (b"\x0a\x0d\x0d\x0a" + bytes(60), "not a recording"),
        (bytes.fromhex("d4c3b2a1020004000000000000000000ffff000093000000"), "old pcap"),
        (b"\x1f\x8b\x08" + bytes(20), "no recording of the line is packed"),
        (b"PK\x03\x04" + b"x" * 26 + b"".join(map(pcapng.encode, LINE)), "packed"),
        (b"x" * 99 + 2 * pcapng.encode(LINE[-1]), "not a recording"),
    ],
)
def test_a_foreign_file_is_refused_at_its_beginning(path, content, words):
    path.write_bytes(content)
    with pytest.raises(CaptureError, match=words) as caught:
        CaptureReader(path)
    assert caught.value.offset == (None if "packed" in words else 0)
    assert caught.value.text.ru != caught.value.text.en


def test_a_beginning_is_not_looked_for_in_a_whole_disk(path):
    with path.open("wb") as file:
        file.seek(LARGEST)
        file.write(b"".join(map(pcapng.encode, LINE)))
    with pytest.raises(CaptureError, match="not a recording"):
        CaptureReader(path)


@pytest.mark.parametrize("name", ["absent.pcapng", "."])
def test_a_file_that_can_not_be_opened_is_an_error(tmp_path, name):
    with pytest.raises(CaptureError):
        CaptureReader(tmp_path / name)


def test_a_file_that_vanished_after_a_first_look_is_an_error(path):
    small_capture(path)
    reader = CaptureReader(path)
    path.unlink()
    with pytest.raises(CaptureError, match="no such file"):
        list(reader)


def test_a_capture_of_another_link_type_is_refused(path):
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
def test_other_resolutions_interfaces_and_sections_are_read(path, order):
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


def test_a_packet_recorded_in_part_is_read_with_a_problem(path):
    write_blocks(path, Section(), Interface(), EnhancedPacket(0, 0, b"x", pcapng.INBOUND, cut=5))
    problem, packet = CaptureReader(path)
    assert packet.data == b"x"
    assert "last bytes (5)" in problem.text.en


# Damaged files


def test_a_capture_cut_at_any_byte_yields_everything_before_the_cut(path):
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


@pytest.mark.parametrize("lost", [range(4, 160), range(160, 400, 3)])
def test_a_recording_without_its_beginning_gives_the_packets_behind_it(path, lost):
    whole = small_capture(path)
    everything = list(CaptureReader(path))
    for length in lost:
        behind = [packet for packet in everything if packet.offset >= length]
        for content in (bytes(length) + whole[length:], whole[length:]):
            path.write_bytes(content)
            if len(behind) < 3:
                with pytest.raises(CaptureError, match="not a recording"):
                    CaptureReader(path)
                continue
            packets, problems = read(path)
            assert contents(packets) == contents(behind)
            assert {packet.source.recording for packet in packets} == {0}
            assert [problem.offset for problem in problems][:1] in ([], [0])
            described = packets[0].source.url == "sim:"
            assert any("describes its port" in it.text.en for it in problems) != described


def test_recordings_behind_damage_are_whole(path):
    whole = small_capture(path)
    everything = contents(CaptureReader(path))
    path.write_bytes(bytes(5000) + whole + whole)
    packets, (problem,) = read(path)
    assert contents(packets) == 2 * everything
    assert [packets[0].source.recording, packets[-1].source.recording] == [0, 1]
    assert (problem.offset, problem.text.en) == (
        0,
        "damaged bytes of the file (5000) are passed over",
    )


def test_notes_count_a_recording_without_its_beginning_too(path):
    with CaptureWriter(path, url="sim:") as writer:
        for time in range(9):
            writer.record(SENT, b"1", time)
        writer.note(Note(Kind.MARKER, 9.0))
    whole = path.read_bytes()
    path.write_bytes(bytes(200) + whole[200:] + whole)
    packets, _ = read(path)
    assert [note.recording for note in CaptureReader(path).notes()] == [0, 1]
    assert [packets[0].source.recording, packets[-1].source.recording] == [0, 1]
    summary = summarise(path)
    assert (summary.recordings, summary.markers) == (2, 2)
    path.write_bytes(bytes(200) + whole[200:])
    assert (summarise(path).recordings, summarise(path).problem) == (1, None)


@pytest.mark.parametrize(
    "packet",
    [
        EnhancedPacket(0, 1, b"x"),
        EnhancedPacket(1, 1, b"x", pcapng.INBOUND),
        EnhancedPacket(0, 1_700_000_000 * 10**9, b"x", pcapng.INBOUND),
        EnhancedPacket(0, 1, b"x", pcapng.INBOUND | 0x1F0),
        EnhancedPacket(0, 1, b"x", pcapng.INBOUND, comment="gear"),
    ],
)
def test_what_may_be_anothers_is_not_read_without_its_port(path, packet):
    path.write_bytes(bytes(60) + 4 * pcapng.encode(packet))
    packets, problems = read(path)
    assert not packets
    assert "not described" in problems[-1].text.en


@pytest.mark.parametrize(("application", "count"), [("mikas 1", 1), ("Wireshark", 0)])
def test_without_the_port_packets_count_only_in_a_file_of_mikas(path, application, count):
    packet = EnhancedPacket(0, MICRO, b"x", pcapng.INBOUND)
    path.write_bytes(
        pcapng.encode(Section(application=application)) + bytes(40) + pcapng.encode(packet)
    )
    packets, problems = read(path)
    assert contents(packets) == [(RECEIVED, b"x", 1.0)][:count]
    assert len(problems) == 2


def test_zeros_behind_the_end_cost_no_packet_and_are_one_problem(path):
    whole = small_capture(path)
    everything = list(CaptureReader(path))
    path.write_bytes(whole + bytes(100_000))
    packets, (problem,) = read(path)
    assert packets == everything
    assert problem.offset == len(whole)
    assert "damaged bytes of the file (100000)" in problem.text.en


def test_of_two_files_joined_the_first_one_cut_short_only_the_cut_is_lost(path):
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
        for number in range(5_000):
            writer.record(RECEIVED, bytes(32), number)
    tracemalloc.start()
    try:
        assert sum(1 for _ in CaptureReader(path)) == 5_000
        assert tracemalloc.get_traced_memory()[1] < 200_000
    finally:
        tracemalloc.stop()
