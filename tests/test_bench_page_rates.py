"""How much of the wire a page used, by what it has recorded."""

from __future__ import annotations

import pytest
from bench.themes.page_rates import of_the_wire

from mikas.link.base import Direction
from mikas.recording.capture.reader import Packet

BYTE = 10 / 9600


def packet(time: float, length: int, direction: Direction = Direction.RECEIVED) -> Packet:
    return Packet(time=time, direction=direction, data=bytes(length), offset=0)


def test_a_stream_without_a_pause_is_the_whole_wire():
    packets = [packet(100 + number * 27 * BYTE, 27) for number in range(50)]
    assert of_the_wire(packets, 100.0, 110.0) == pytest.approx(100.0)


def test_what_passes_before_and_after_does_not_count():
    packets = [packet(100 + number * 27 * BYTE, 27) for number in range(50)]
    around = [packet(90.0, 3), *packets, packet(115.0, 3, Direction.SENT), packet(116.0, 3)]
    assert of_the_wire(around, 100.0, 110.0) == pytest.approx(100.0)


def test_a_request_takes_the_time_of_its_turn():
    exchange = 8 * BYTE + 0.002
    packets = [
        each
        for number in range(50)
        for each in (
            packet(100 + number * exchange, 4, Direction.SENT),
            packet(100 + (number + 1) * exchange - 1e-9, 8),
        )
    ]
    assert of_the_wire(packets, 100.0, 110.0) == pytest.approx(100.0, abs=0.1)
