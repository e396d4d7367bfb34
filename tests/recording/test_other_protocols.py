"""Bytes at another baud rate in a capture: kept, shown as they are, and no damage of the unit's."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import shipped
from mikas.framing import encode
from mikas.link import CaptureTee
from mikas.link.base import Direction
from mikas.link.virtual import VirtualLink
from mikas.recording import CaptureReader, CaptureWriter
from mikas.recording.capture.reader import Packet, Problem
from mikas.recording.inspect import decode, to_json, to_text
from mikas.recording.recording import Recording
from mikas.virtual.build import build_bus
from virtual_harness import make_bus

SENT, RECEIVED = Direction.SENT, Direction.RECEIVED
EXCHANGE = ((SENT, encode(b"\x61\x1a")), (RECEIVED, encode(b"\x61\x1a") + encode(b"\x7d")))
FOREIGN = st.lists(
    st.tuples(
        st.integers(0, 9),  # after how many exchanges
        st.sampled_from([4800, 10_400, 38_400]),
        st.sampled_from([SENT, RECEIVED]),
        st.binary(min_size=1, max_size=20),
    ),
    max_size=12,
)


def recorded(path, foreign=()):
    with CaptureWriter(path, url="/dev/ttyUSB0") as writer:
        time = 100.0
        for number in range(10):
            for direction, data in EXCHANGE:
                writer.record(direction, data, time)
                time += 0.02
            for after, baud, direction, data in foreign:
                if after == number:
                    writer.change_baud(baud)
                    writer.record(direction, data, time)
                    writer.change_baud(None)
    return path


@given(foreign=FOREIGN)
def test_nothing_that_is_read_of_the_unit_depends_on_them(foreign, tmp_path_factory):
    folder = tmp_path_factory.mktemp("captures")
    plain = recorded(folder / "a.pcapng")
    mixed = recorded(folder / "b.pcapng", foreign)
    without = [to_json(item) for item in decode(CaptureReader(plain))]
    assert all(line["type"] == "frame" for line in without)
    for each in without:
        each.pop("offset")
    for reader in (CaptureReader(mixed), CaptureReader(mixed).with_other_protocols()):
        items = [item for item in decode(reader) if not isinstance(item, Packet)]
        lines = [to_json(item) for item in items]
        for line in lines:
            line.pop("offset")
        assert lines == without
    assert Recording(mixed, shipped()).row_count == Recording(plain, shipped()).row_count == 10
    assert not Recording(mixed, shipped()).problems
    packets = [
        item for item in decode(CaptureReader(mixed).with_other_protocols())
        if isinstance(item, Packet)
    ]  # fmt: skip
    expected = sorted(foreign, key=lambda each: each[0])
    assert [(it.source.baud, it.direction, it.data) for it in packets] == [
        each[1:] for each in expected
    ]
    assert all(it.source.foreign and it.source.url == "/dev/ttyUSB0" for it in packets)


@pytest.mark.parametrize("language", ["en", "ru"])
def test_they_are_shown_with_their_rate(tmp_path, language):
    path = recorded(tmp_path / "a.pcapng", [(3, 10_400, SENT, b"\x81\x10\xf1\x81\x03")])
    (shown,) = [
        to_text(item, language, zero=100.0)
        for item in decode(CaptureReader(path).with_other_protocols())
        if isinstance(item, Packet)
    ]
    assert shown.startswith("    0.160000 > 81 10 F1 81 03  (10400 ")


def test_a_tee_tells_its_sink_when_the_rate_changes(tmp_path):
    link = VirtualLink(make_bus())
    with CaptureWriter(tmp_path / "a.pcapng", url=link.url) as writer:
        tee = CaptureTee(link, writer)
        for baud in (9600, 10_400, 9600):
            assert tee.set_baud(baud)
            tee.write(b"\x01\xff\x0d")
            while tee.read(tee.now() + 0.1).data:
                pass
        assert tee.failure is None
    items = list(decode(CaptureReader(writer.path).with_other_protocols()))
    assert not any(isinstance(item, Problem) for item in items)
    rates = [item.source.baud for item in items]
    assert set(rates) == {9600, 10_400}
    assert all(isinstance(item, Packet) == (item.source.baud == 10_400) for item in items)
    sent = [it.data for it in items if isinstance(it, Packet) and it.direction is SENT]
    assert sent == [b"\x01\xff\x0d"]


def test_the_units_rate_is_the_links_own_and_need_not_be_9600(tmp_path):
    """A capture says 9600 of every port."""
    link = VirtualLink(build_bus({"baud": "19200"}))
    with CaptureWriter(tmp_path / "a.pcapng", url=link.url) as writer:
        tee = CaptureTee(link, writer)
        for baud in (10_400, 19_200):
            assert tee.set_baud(baud)
            tee.write(b"\x01\xff\x0d")
            while tee.read(tee.now() + 0.1).data:
                pass
    packets = list(CaptureReader(writer.path).with_other_protocols())
    assert {it.source.baud for it in packets if it.source.foreign} == {10_400}
    frames = list(decode(CaptureReader(writer.path)))
    assert [it.frame.body for it in frames] == [b"\x01", b"\x01", b"\x0a"]


def test_a_time_before_the_clocks_zero_has_its_own_port_too(tmp_path):
    with CaptureWriter(tmp_path / "a.pcapng", url="sim:") as writer:
        writer.change_baud(10_400)
        for time in (5.0, -3.25, 2.0):
            writer.record(RECEIVED, b"\x55", time)
        writer.change_baud(None)
        writer.record(RECEIVED, b"\x01", -4.0)
    items = list(CaptureReader(writer.path).with_other_protocols())
    assert [(it.time, it.source.foreign) for it in items] == [
        (5.0, True), (-3.25, True), (2.0, True), (-4.0, False),
    ]  # fmt: skip
