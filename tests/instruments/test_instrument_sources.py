"""Ports of instruments: their speed, and that an adapter is found by what it is."""

from __future__ import annotations

import pytest

from mikas.catalog import shipped
from mikas.errors import AnotherAdapter, LinkLost, PortNotFound, ReadingSuspended
from mikas.i18n import Text
from mikas.instruments.choosing import chosen_instruments
from mikas.instruments.reading import InstrumentChange, InstrumentReader, InstrumentState
from mikas.instruments.sources import LinkSource
from mikas.link import Chunk, Link
from mikas.link.ports import Port
from mikas.recording.capture.instruments import CONNECTED, LOST, instrument_port, loss

GONE = Text("it is gone", "его нет")


class Meter(Link):
    def __init__(self, url: str) -> None:
        self.url = url
        self.sent = b""
        self.pulled = False

    def write(self, data: bytes) -> None:
        self.sent += data

    def read(self, deadline: float) -> Chunk:
        if self.pulled:
            raise LinkLost(url=self.url, problem=GONE)
        return Chunk(b"1.02\r\n", 7.0)

    def gather(self, until: float) -> None:
        pass

    def now(self) -> float:
        return 7.5

    def send_break(self, seconds: float) -> None:
        pass

    def close(self) -> None:
        pass


class Desk:
    def __init__(self, *ports: Port) -> None:
        self.ports = list(ports)
        self.links: list[Meter] = []

    def open(self, url: str) -> Meter:
        self.links.append(Meter(url))
        return self.links[-1]

    def source(self, text: str) -> LinkSource:
        (chosen,) = chosen_instruments([text], shipped())
        return LinkSource(chosen, lambda: 100.0, self.open, lambda: self.ports)


def adapter(url: str, serial: str) -> Port:
    return Port(
        url, "FT232R", chip="FT232R", likely=True, vid=0x0403, pid=0x6001, serial_number=serial
    )


@pytest.mark.parametrize(
    ("text", "opened"),
    [
        ("aem=/dev/ttyUSB1", "/dev/ttyUSB1?baud=9600"),
        ("innovate=COM4", "COM4?baud=19200"),
        ("nmea=/dev/ttyUSB1?baud=4800", "/dev/ttyUSB1?baud=4800"),
        ("aem=socket://box:2000", "socket://box:2000?baud=9600"),
        ("gpsd=gpsd:", "socket://localhost:2947?baud=1000000"),
    ],
)
def test_a_port_has_the_speed_of_the_definition_unless_it_says_another(text, opened) -> None:
    desk = Desk()
    source = desk.source(text)
    source.open()
    assert [link.url for link in desk.links] == [opened]
    assert (desk.links[0].sent != b"") == text.startswith("gpsd")


def test_bytes_have_the_time_of_the_sessions_clock() -> None:
    source = Desk().source("aem=/dev/ttyUSB1")
    assert source.read() == []
    source.open()
    (chunk,) = source.read()
    assert (chunk.data, chunk.time) == (b"1.02\r\n", 99.5)


def test_after_a_pulled_hub_no_other_adapter_is_opened_under_its_name() -> None:
    desk = Desk(adapter("/dev/ttyUSB0", "unit"), adapter("/dev/ttyUSB1", "meter"))
    source = desk.source("aem=/dev/ttyUSB1")
    source.open()
    source.reset()
    desk.ports = [adapter("/dev/ttyUSB1", "unit")]
    with pytest.raises((AnotherAdapter, PortNotFound)):
        source.open()
    assert len(desk.links) == 1
    desk.ports.append(adapter("/dev/ttyUSB0", "meter"))
    source.open()
    assert desk.links[-1].url == "/dev/ttyUSB0?baud=9600"


def test_what_is_lost_gives_nothing_until_it_is_opened_again() -> None:
    desk = Desk()
    source = desk.source("aem=/dev/ttyUSB1")
    source.open()
    desk.links[0].pulled = True
    with pytest.raises(LinkLost):
        source.read()
    source.reset()
    assert source.read() == []
    source.open()
    assert source.read()


class OneChunk:
    """A source that gives all bytes at once, and a sink that keeps nothing."""

    def __init__(self, data: bytes) -> None:
        self.data = data

    def open(self) -> None:
        pass

    def read(self) -> list[Chunk]:
        return [Chunk(self.data, 100.0)]

    def reset(self) -> None:
        pass

    def close(self) -> None:
        pass

    def record_instrument(self, number: int, data: bytes, time: float, comment: str = "") -> None:
        pass


POSITION = b'{"class":"TPV","mode":2,"lat":56.2,"lon":43.9}\r\n'
SATELLITES = b'{"class":"SKY","satellites":[' + b" " * 900 + b"]}\r\n"


@pytest.mark.parametrize(
    ("text", "data", "behind", "byte_time"),
    [
        ("aem=/dev/ttyUSB1", b"\r\n14.7\r\n" + b"x" * 96, 97, 10 / 9600),
        ("aem=/dev/ttyUSB1?baud=4800", b"\r\n14.7\r\n" + b"x" * 96, 97, 10 / 4800),
        ("aem=socket://box:2000?baud=38400", b"\r\n14.7\r\n" + b"x" * 96, 97, 10 / 38400),
        ("aem=sim:", b"\r\n14.7\r\n" + b"x" * 96, 97, 10 / 9600),
        ("gpsd=gpsd:localhost", POSITION + SATELLITES, 512, 10 / 1_000_000),
    ],
)
def test_a_value_has_the_time_of_its_own_last_byte_at_the_ports_speed(
    text, data, behind, byte_time
) -> None:
    """Its chunk brought more, at least its own line feed."""
    (chosen,) = chosen_instruments([text], shipped())
    source, changes = OneChunk(data), list[InstrumentChange]()
    reader = InstrumentReader(
        0,
        chosen,
        source,
        source,
        clock=lambda: 100.0,
        report=changes.append,
        comments=(CONNECTED, loss),
    )
    reader.poll()
    times = [it.time for it in reader.fresh(100.0).values()]
    assert times == pytest.approx([100.0 - behind * byte_time] * 2)
    port = instrument_port(chosen.definition, chosen.url)
    assert 10 / port.speed == pytest.approx(byte_time)


class Stopped(OneChunk):
    """A port whose reader is stopped for a while in the middle of a message. Keeps what is
    recorded.
    """

    def __init__(self) -> None:
        super().__init__(b"")
        self.coming = [b"\r\n14.7\r\n1", ReadingSuspended(seconds=0.6), b"2.9\r\n13.1\r\n"]
        self.opened, self.recorded = 0, list[tuple[bytes, str]]()

    def open(self) -> None:
        self.opened += 1

    def read(self) -> list[Chunk]:
        came = self.coming.pop(0)
        if isinstance(came, bytes):
            return [Chunk(came, 100.0)]
        raise came

    def record_instrument(self, number: int, data: bytes, time: float, comment: str = "") -> None:
        self.recorded.append((data, comment.partition("\n")[0]))


def test_a_reader_that_was_stopped_loses_bytes_and_no_connection() -> None:
    (chosen,) = chosen_instruments(["aem=/dev/meter"], shipped())
    source, changes = Stopped(), list[InstrumentChange]()
    reader = InstrumentReader(
        0,
        chosen,
        source,
        source,
        clock=lambda: 100.0,
        report=changes.append,
        comments=(CONNECTED, loss),
    )
    assert reader.poll()
    assert reader.fresh(100.0)["AFR"].value == 14.7
    assert reader.poll()
    assert reader.fresh(100.0) == {}
    assert reader.poll()
    assert reader.fresh(100.0)["AFR"].value == 13.1  # and 12.9 was never sent
    assert source.opened == 1
    assert [each.state for each in changes] == [InstrumentState.CONNECTED, InstrumentState.VALUES]
    before, after = b"\r\n14.7\r\n1", b"2.9\r\n13.1\r\n"
    assert source.recorded == [
        (b"", CONNECTED), (before, ""), (b"", LOST), (b"", CONNECTED), (after, ""),
    ]  # fmt: skip


class Flapping(OneChunk):
    """A port that is lost `lasts` seconds after each opening, with a value in between."""

    def __init__(self, lasts: float) -> None:
        super().__init__(b"\r\n14.7\r\n")
        self.lasts, self.time = lasts, 100.0
        self.opened: list[float] = []

    def open(self) -> None:
        self.opened.append(self.time)

    def read(self) -> list[Chunk]:
        if self.time - self.opened[-1] >= self.lasts:
            raise LinkLost(url="/dev/meter", problem=GONE)
        return [Chunk(self.data, self.time)]


@pytest.mark.parametrize(
    ("lasts", "pauses"), [(0.25, [1, 2, 4, 5, 5]), (6.0, [1, 1, 1])], ids=["flapping", "lasting"]
)
def test_one_that_is_lost_again_at_once_is_tried_less_and_less_often(lasts, pauses) -> None:
    """A line that floods gives values before it is given up: three messages each second, else."""
    (chosen,) = chosen_instruments(["aem=/dev/meter"], shipped())
    source, changes = Flapping(lasts), list[InstrumentChange]()
    reader = InstrumentReader(
        0,
        chosen,
        source,
        source,
        clock=lambda: source.time,
        report=changes.append,
        comments=(CONNECTED, loss),
    )
    while len(source.opened) <= len(pauses):
        reader.poll()
        source.time += 0.125
    between = [b - a - lasts for a, b in zip(source.opened, source.opened[1:], strict=False)]
    assert between == pytest.approx(pauses, abs=0.13)
