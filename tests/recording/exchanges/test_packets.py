"""The packets of a capture as arrays: the same as `CaptureReader` gives, over damage too."""

from __future__ import annotations

import struct
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import CaptureError
from mikas.link.base import Direction
from mikas.recording.capture import blocks as pcapng
from mikas.recording.capture.reader import CaptureReader, Packet, Problem
from mikas.recording.exchanges.columns.packets import read, seconds

SECTION = pcapng.Section(application="mikas test")
LINE = pcapng.Interface(name="sim:", speed=9600)

packets = st.builds(
    pcapng.EnhancedPacket,
    interface=st.sampled_from([0, 0, 0, 0, 1, 2]),
    ticks=st.one_of(st.integers(0, 2**40), st.integers(0, 2**64 - 1), st.just(6 << 32 | 6)),
    data=st.one_of(st.binary(max_size=9), st.sampled_from([b"\x06\0\0\0\x20\0\0\0", bytes(40)])),
    flags=st.sampled_from([1, 2, 1, 2, 0x101, 0, 3]),
    comment=st.sampled_from(["", "", "", "why"]),
    cut=st.sampled_from([0, 0, 0, 3]),
)
plain = st.builds(
    pcapng.EnhancedPacket,
    interface=st.just(0),
    ticks=st.integers(0, 2**51),
    data=st.binary(max_size=40),
    flags=st.sampled_from([1, 2]),
)
others = st.one_of(
    st.builds(
        pcapng.Interface,
        link_type=st.sampled_from([147, 147, 1]),
        name=st.sampled_from(["sim:", "b"]),
        speed=st.sampled_from([9600, 0]),
        tsresol=st.sampled_from([6, 9, 3, 0x8A, 19, 0xFF]),
        tsoffset=st.sampled_from([0, -5, 1_700_000_000, 2**40]),
    ),
    st.just(SECTION),
    st.just(pcapng.Section(version=(2, 0))),
    st.builds(pcapng.Custom, st.just(1), st.binary(max_size=9)),
    st.just(pcapng.SimplePacket(b"\x01")),
)
bodies = st.lists(st.one_of(plain, plain, plain, packets, others), max_size=25)
wounds = st.lists(st.tuples(st.floats(0, 1), st.sampled_from(["flip", "drop", "add"])), max_size=3)


def spoilt(data, injuries):
    for place, kind in injuries:
        at = 28 + int(place * (len(data) - 28))
        if kind == "flip":
            data = data[:at] + bytes([data[at] ^ 0x41]) + data[at + 1 :] if at < len(data) else data
        else:
            data = data[:at] + (data[at + 3 :] if kind == "drop" else b"\x06\0\0" + data[at:])
    return data


def shown(path, window):
    """As `CaptureReader` gives them; ports that took turns are put back in order."""
    items, stretch = [], []
    for it in read(path, window):
        if isinstance(it, Problem):
            items += [*sorted(stretch, key=lambda packet: packet.offset), it]
            stretch = []
            continue
        for n in range(it.times.size):
            start, length = it.at[n], it.lengths[n]
            stretch.append(
                Packet(
                    Direction.SENT if it.sent[n] else Direction.RECEIVED,
                    it.buffer[start : start + length].tobytes(),
                    float(it.times[n]),
                    int(it.offsets[n]),
                    source=it.source,
                )
            )
    return [*items, *sorted(stretch, key=lambda packet: packet.offset)]


def expected(path):
    return [
        item
        if isinstance(item, Problem)
        else Packet(item.direction, item.data, item.time, item.offset, source=item.source)
        for item in CaptureReader(path)
    ]


@given(
    blocks=bodies,
    order=st.sampled_from("<<<>"),
    window=st.sampled_from([16, 64, 100, 256, 1 << 16]),
    injuries=wounds,
    head=st.one_of(st.just((0, 0)), st.tuples(st.integers(0, 300), st.integers(0, 300))),
)
def test_the_same_packets_and_problems(tmp_path_factory, blocks, order, window, injuries, head):
    path = tmp_path_factory.mktemp("capture") / "line.pcapng"
    data = b"".join(pcapng.encode(block, order) for block in [SECTION, LINE, *blocks])
    zeros, lost = head
    path.write_bytes(bytes(zeros) + spoilt(data, injuries)[lost:])
    try:
        wanted = expected(path)
    except CaptureError as error:
        with pytest.raises(CaptureError) as caught:
            shown(path, window)
        assert str(caught.value) == str(error)
        return
    assert shown(path, window) == wanted


@given(
    ticks=st.one_of(st.integers(0, 2**64 - 1), st.integers(2**52 - 9, 2**53 + 9)),
    tsresol=st.sampled_from([0, 6, 9, 15, 16, 0xB4, 0xB6, 0xFF]),
    tsoffset=st.sampled_from([0, -1, 1_700_000_000, -(2**50), 2**62]),
)
def test_times_are_rounded_once(ticks, tsresol, tsoffset):
    interface = pcapng.Interface(tsresol=tsresol, tsoffset=tsoffset)
    high, low = divmod(ticks, 1 << 32)
    (time,) = seconds(interface, np.array([high]), np.array([low])).tolist()
    assert time == interface.time(ticks)
    assert time == float(tsoffset + Fraction(ticks, interface.ticks_per_second))


def test_a_block_too_short_for_a_packet_at_the_end_is_the_same_problem(tmp_path):
    path = tmp_path / "line.pcapng"
    whole = b"".join(pcapng.encode(block) for block in [SECTION, LINE])
    path.write_bytes(whole + struct.pack("<3I", pcapng.ENHANCED, 12, 12))
    (problem,) = shown(path, 1 << 16)
    assert [problem] == list(CaptureReader(path))


def test_what_is_no_capture_is_refused(tmp_path):
    path = tmp_path / "values.csv"
    path.write_text("a,b\n1,2\n3,4\n")
    with pytest.raises(CaptureError):
        next(read(path))
    with pytest.raises(CaptureError):
        next(read(tmp_path / "nowhere.pcapng"))
