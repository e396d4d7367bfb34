"""What the tee records, and that nothing in it touches the line."""

from __future__ import annotations

import pytest

from mikas.errors import LinkLost
from mikas.i18n import Text
from mikas.link import CaptureTee, Chunk, Direction, Link
from mikas.link.base import WireCount


class ScriptedLink(Link):
    """A link whose reads are given beforehand, and whose clock moves by one at each use."""

    url = "test:"
    baud = 10400

    def __init__(self, *reads: bytes) -> None:
        self.reads = list(reads)
        self.done: list[object] = []
        self.time = 100.0

    @property
    def description(self) -> str:
        return "scripted"

    @property
    def can_break(self) -> bool:
        return False

    def write(self, data: bytes) -> None:
        self.time += 1
        if data == b"lost":
            raise LinkLost(url=self.url, problem=Text("gone", "пропал"))
        self.done.append(data)

    def read(self, deadline: float) -> Chunk:
        self.time += 1
        return Chunk(self.reads.pop(0), self.time - 0.5)

    def now(self) -> float:
        return self.time

    def gather(self, until: float) -> None:
        self.done.append(("gather", until))

    def send_break(self, seconds: float) -> None:
        self.done.append(seconds)

    def close(self) -> None:
        self.done.append("closed")


class ListSink:
    def __init__(self, capacity: int = 1000) -> None:
        self.records: list[tuple[Direction, bytes, float]] = []
        self.capacity = capacity
        self.attempts = 0

    def record(self, direction: Direction, data: bytes, time: float) -> None:
        self.attempts += 1
        if len(self.records) == self.capacity:
            raise OSError(28, "No space left on device")
        self.records.append((direction, data, time))


def test_what_passes_is_recorded_in_order_with_its_times():
    sink = ListSink()
    tee = CaptureTee(ScriptedLink(b"\x01\xff\r", b"\x09\xf7\r"), sink)
    tee.write(b"\x01\xff\r")
    assert tee.read(200.0) == Chunk(b"\x01\xff\r", 101.5)
    assert tee.read(200.0) == Chunk(b"\x09\xf7\r", 102.5)
    assert sink.records == [
        (Direction.SENT, b"\x01\xff\r", 101.0),
        (Direction.RECEIVED, b"\x01\xff\r", 101.5),
        (Direction.RECEIVED, b"\x09\xf7\r", 102.5),
    ]


def test_nothing_is_recorded_of_nothing():
    sink = ListSink()
    tee = CaptureTee(ScriptedLink(b""), sink)
    tee.write(b"")
    tee.read(200.0)
    assert sink.records == []


def test_what_the_link_refused_was_not_sent():
    sink = ListSink()
    with pytest.raises(LinkLost):
        CaptureTee(ScriptedLink(), sink).write(b"lost")
    assert sink.records == []


def test_a_failing_sink_is_kept_and_left_alone_and_the_line_goes_on():
    sink = ListSink(capacity=1)
    link = ScriptedLink(b"one", b"two")
    tee = CaptureTee(link, sink)
    assert tee.failure is None
    tee.write(b"first")
    assert tee.read(200.0).data == b"one"
    tee.write(b"second")
    assert tee.read(200.0).data == b"two"
    assert isinstance(tee.failure, OSError)
    assert (len(sink.records), sink.attempts) == (1, 2)
    assert link.done == [b"first", b"second"]


def test_everything_else_is_the_links():
    link = ScriptedLink()
    tee = CaptureTee(link, ListSink())
    assert (tee.url, tee.baud, tee.description) == ("test:", 10400, "scripted")
    assert tee.byte_time == pytest.approx(10 / 10400)
    assert not tee.can_break
    assert tee.now() == 100.0
    with tee:
        tee.gather(200.0)
        tee.send_break(0.3)
    assert link.done == [("gather", 200.0), 0.3, "closed"]


@pytest.mark.parametrize(("echoes", "carried"), [(True, 6), (False, 9)])
def test_an_echo_is_not_counted_twice(echoes, carried):
    wire = WireCount()
    wire.echoes = echoes
    tee = CaptureTee(ScriptedLink(b"\x01\xff\x0d\x0a\xf6\x0d"), ListSink(), wire)
    tee.write(b"\x01\xff\x0d")
    tee.read(200.0)
    assert wire.bytes == carried
