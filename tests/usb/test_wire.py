"""The wire behind a chip: the virtual unit answers at its own rate only."""

from __future__ import annotations

import queue
import time
from pathlib import Path

import pytest

from mikas.virtual.build import build_bus
from usb.book_rig import opened, set_break
from usb.chips.named import plugged
from usb.chips.uart import Damage
from usb.wire_rig import Lines

UNTIL = 60.0  # s
CAR = Path(__file__).parents[1] / "cable" / "still.toml"
REQUEST, RESPONSE = bytes.fromhex("61 29 76 0D"), bytes.fromhex("48 B7 0D")

pytestmark = pytest.mark.realtime


@pytest.fixture(scope="module")
def lines():
    made = Lines()
    yield made
    made.close()


class AtTheWire:
    """A CP2102 at the wire, with a driver that takes every character as it comes."""

    def __init__(self, lines: Lines, rate: int, **settings: str) -> None:
        self._lines = lines
        self.wire = lines.put(lambda at: build_bus({"scenario": str(CAR)} | settings, start=at))
        self.chip = plugged("CP2102", self.wire)
        self.came: queue.SimpleQueue = queue.SimpleQueue()
        self.chip.ready = lambda: [
            self.came.put((each, time.monotonic())) for each in self.chip.uart.take(999)
        ]
        lines.call(lambda: self.wire.carry(self.chip.uart))
        self.host = lines.call(lambda: opened(self.chip, "CP2102", rate))

    def send(self, data: bytes) -> None:
        self._lines.call(lambda: self.host.write(data))

    def received(self, count: int):
        """Return the next `count` characters, and when the last one came."""
        found = [self.came.get(timeout=UNTIL) for _ in range(count)]
        return [it for it, _ in found], found[-1][1]


@pytest.fixture
def tester(lines):
    made = []

    def make(rate: int = 9600, **settings: str) -> AtTheWire:
        made.append(AtTheWire(lines, rate, **settings))
        return made[-1]

    yield make
    for each in made:
        lines.remove(each.wire)


def values(characters):
    return bytes(it.value for it in characters)


def test_at_the_right_rate_the_unit_answers_and_the_line_echoes(tester):
    it = tester()
    it.send(REQUEST)
    found, _ = it.received(len(REQUEST + RESPONSE))
    assert values(found)[:4] == REQUEST
    assert values(found)[-1:] == b"\r"
    assert it.wire.sent == REQUEST


def test_at_a_wrong_rate_the_echo_is_whole_and_its_time_alone_is_wrong(tester):
    it = tester(4800)
    begin = time.monotonic()
    it.send(b"\x61\x29" * 20)
    found, end = it.received(40)
    assert values(found) == b"\x61\x29" * 20
    assert end - begin > 40 * 9.9 / 4800  # at 9600 it would be half of that
    assert it.wire.bus.bytes_carried > 0  # garbage for the unit


def test_the_unit_reads_garbage_of_a_wrong_rate_and_the_tester_of_its_responses(tester, lines):
    it = tester(4800, echo="0")
    lines.call(lambda: it.wire.feed(REQUEST))  # as another tester on the line would
    found, _ = it.received(1)
    assert found[0] != (RESPONSE[0], Damage.NONE)


def test_the_rate_set_right_again_everything_is_as_before(tester, lines):
    it = tester(4800)
    it.send(b"\x61")
    it.received(1)
    it.host.set(0x41, 0x1E, data=(9600).to_bytes(4, "little"))
    it.send(b"\r\r" + REQUEST)
    found, _ = it.received(8)
    assert REQUEST in values(found)


def test_a_break_is_heard_by_the_chip_that_sent_it(tester, lines):
    it = tester()
    for on in (True, False):
        lines.call(lambda on=on: set_break(it.host, "CP2102", on))
    [found], _ = it.received(1)
    assert Damage.BREAK in found.damage
    assert it.wire.breaks == 1


def test_a_zero_at_a_much_lower_rate_is_a_break_for_the_unit(tester):
    it = tester(300)
    it.send(b"\x00")
    [found], _ = it.received(1)
    assert (found, it.wire.breaks) == ((0x00, Damage.NONE), 1)


def test_cut_at_a_byte_nothing_comes_after_it(tester, lines):
    it = tester()
    cut = lines.call(lambda: it.wire.cut_when(lambda seen: seen.endswith(b"\x76")))
    it.send(REQUEST)
    assert cut.result(UNTIL) == REQUEST[:3]
    assert values(it.received(3)[0]) == REQUEST[:3]
    assert not it.wire.plugged
    it.send(REQUEST)
    assert it.wire.sent == REQUEST
