"""A port that comes and goes is found again by what it is, not by its name."""

from __future__ import annotations

import os
from collections.abc import Callable

import pytest

from mikas.errors import AnotherAdapter, PortNotFound
from mikas.link import CaptureTee, Chunk, Link
from mikas.link.clocks import WallClock
from mikas.link.ports import Port
from mikas.link.reconnecting import ReconnectingPort


class QuietLink(Link):
    """Opened when the computer's date was `date`; `ago()` seconds have passed since."""

    def __init__(self, url: str, date: float, ago: Callable[[], float]) -> None:
        self.url = url
        self._date = date
        self._ago = ago
        self.written: list[bytes] = []
        self.broken = 0.0
        self.closed = False

    def write(self, data: bytes) -> None:
        self.written.append(data)

    def read(self, deadline: float) -> Chunk:
        return Chunk(b"", max(deadline, self.now()))

    def gather(self, until: float) -> None:
        self.gathered = until

    def now(self) -> float:
        return self._date + self._ago()

    def send_break(self, seconds: float) -> None:
        self.broken += seconds

    def close(self) -> None:
        self.closed = True


class Desk:
    """A computer with ports, and what was opened on it."""

    def __init__(self, *ports: Port) -> None:
        self.ports = list(ports)
        self.opened: list[str] = []
        self.slept = 0.0
        self.date_set = 0.0  # by how much somebody has set the computer's date
        self.links: list[QuietLink] = []
        self.on_open: Callable[[], object] = lambda: None

    def open(self, url: str) -> QuietLink:
        if url.partition("?")[0] not in [port.url for port in self.ports] and ":" not in url:
            raise PortNotFound(url=url, found="")
        self.opened.append(url)
        began = self.slept
        self.links.append(QuietLink(url, began + self.date_set, lambda: self.slept - began))
        self.on_open()
        return self.links[-1]

    def nap(self, seconds: float) -> None:
        self.slept += seconds

    def plug(self, url: str, **settings: object) -> ReconnectingPort:
        return ReconnectingPort(
            url,
            find=lambda: self.ports,
            open_port=self.open,
            clock=lambda: self.slept,
            wait=self.nap,
            **settings,
        )


def ftdi(url: str, serial: str = "A1") -> Port:
    return Port(
        url, "FT232R", chip="FT232R", likely=True, vid=0x0403, pid=0x6001, serial_number=serial
    )


def test_it_is_found_under_another_name():
    desk = Desk(ftdi("/dev/ttyUSB0"), ftdi("/dev/ttyUSB7", "other"))
    plug = desk.plug("/dev/ttyUSB0?baud=9600")
    plug.open()
    desk.ports = [ftdi("/dev/ttyUSB1"), ftdi("/dev/ttyUSB0", "other")]
    plug.open()
    assert desk.opened == ["/dev/ttyUSB0?baud=9600", "/dev/ttyUSB1?baud=9600"]
    assert plug.url == "/dev/ttyUSB1?baud=9600"


def test_a_stranger_on_its_name_is_never_opened():
    desk = Desk(ftdi("/dev/ttyUSB0"))
    plug = desk.plug("/dev/ttyUSB0")
    plug.open()
    desk.ports = [ftdi("/dev/ttyUSB0", "other")]
    with pytest.raises(AnotherAdapter):
        plug.open()
    desk.ports.append(ftdi("/dev/ttyUSB1"))
    plug.open()
    assert desk.opened == ["/dev/ttyUSB0", "/dev/ttyUSB1"]


@pytest.mark.parametrize("opened_before", [False, True])
@pytest.mark.parametrize("then", [[], [ftdi("/dev/ttyUSB0", "other")]])
def test_an_adapter_exchanged_while_it_is_opened_is_let_go(opened_before, then):
    desk = Desk(ftdi("/dev/ttyUSB0"))
    plug = desk.plug("/dev/ttyUSB0")
    if opened_before:
        plug.open()
    desk.on_open = lambda: setattr(desk, "ports", then)
    with pytest.raises(PortNotFound):
        plug.open()
    assert desk.links[-1].closed
    assert not desk.links[-1].written


def ch340(url: str, location: str) -> Port:
    return Port(url, "CH340", vid=0x1A86, pid=0x7523, location=location)


def test_a_like_adapter_of_another_socket_is_let_go_too():
    desk = Desk(ch340("/dev/ttyUSB0", "1-1"))
    plug = desk.plug("/dev/ttyUSB0")
    desk.on_open = lambda: setattr(desk, "ports", [ch340("/dev/ttyUSB0", "1-2")])
    with pytest.raises(AnotherAdapter):
        plug.open()


def test_two_of_a_kind_once_seen_are_remembered():
    desk = Desk(ch340("/dev/ttyUSB0", "1-1"), ch340("/dev/ttyUSB1", "1-2"))
    plug = desk.plug("/dev/ttyUSB0")
    plug.open()
    desk.ports.pop()
    plug.open()
    for desk.ports in ([], [ch340("/dev/ttyUSB0", "1-2")]):
        with pytest.raises(PortNotFound):
            plug.open()
    assert desk.opened == ["/dev/ttyUSB0"] * 2


def test_a_cable_moved_to_another_socket_is_known_by_that_one():
    desk = Desk(ch340("/dev/ttyUSB0", "1-1"))
    plug = desk.plug("/dev/ttyUSB0")
    plug.open()
    desk.ports = []
    with pytest.raises(PortNotFound):
        plug.open()
    desk.ports = [ch340("/dev/ttyUSB0", "1-2")]
    plug.open()
    desk.ports = [ch340("/dev/ttyUSB0", "1-1"), ch340("/dev/ttyUSB1", "1-2")]
    assert plug.open().url == "/dev/ttyUSB1"


def test_a_link_to_its_name_is_kept_while_it_leads_to_it(monkeypatch):
    alias, links = "/dev/serial/by-id/FTDI", {"/dev/serial/by-id/FTDI": "/dev/ttyUSB0"}
    monkeypatch.setattr(os.path, "realpath", lambda path: links.get(path, path))
    desk = Desk(ftdi("/dev/ttyUSB0"))
    desk.open = lambda url: QuietLink(url, 0.0, lambda: 0.0)
    plug = desk.plug(alias)
    assert [plug.open().url, plug.open().url] == [alias] * 2
    desk.ports = [ftdi("/dev/ttyUSB1"), ftdi("/dev/ttyUSB0", "other")]
    assert plug.open().url == "/dev/ttyUSB1"


def test_its_own_name_is_kept_while_it_has_it():
    desk = Desk(ftdi("/dev/ttyUSB1"), ftdi("/dev/ttyUSB0"))
    plug = desk.plug("/dev/ttyUSB0")
    plug.open()
    plug.open()
    assert desk.opened == ["/dev/ttyUSB0", "/dev/ttyUSB0"]


def test_while_it_is_nowhere_the_error_says_so_and_it_may_come_back():
    desk = Desk(ftdi("/dev/ttyUSB0"))
    plug = desk.plug("/dev/ttyUSB0")
    plug.open()
    desk.ports = []
    with pytest.raises(PortNotFound):
        plug.open()
    plug.wait(1.0)
    assert plug.now() == 1.0
    desk.ports = [ftdi("/dev/ttyUSB3")]
    plug.open()
    assert desk.opened[-1] == "/dev/ttyUSB3"


def test_what_has_no_identity_is_opened_by_its_name():
    desk = Desk(Port("/dev/ttyS0", "ttyS0"))
    plug = desk.plug("/dev/ttyS0")
    plug.open()
    plug.open()
    network = desk.plug("socket://car:2000")
    network.open()
    network.open()
    assert desk.opened == ["/dev/ttyS0"] * 2 + ["socket://car:2000"] * 2


def test_a_sink_gets_what_passes_on_every_link():
    desk = Desk(ftdi("/dev/ttyUSB0"))
    came = []

    class Sink:
        def record(self, direction, data, time):
            came.append((direction.value, data))

    plug = desk.plug("/dev/ttyUSB0", sink=Sink())
    for data in (b"one", b"two"):
        link = plug.open()
        assert isinstance(link, CaptureTee)
        link.write(data)
    assert came == [("sent", b"one"), ("sent", b"two")]


@pytest.mark.parametrize("hours", [-1, 0, 1])
def test_time_goes_on_though_the_date_is_set_between_two_links(hours):
    desk = Desk(ftdi("/dev/ttyUSB0"))
    plug = desk.plug("/dev/ttyUSB0")
    observed = [plug.now()]
    for _ in range(3):
        link = plug.open()
        desk.nap(5)
        observed += [link.now(), plug.now(), link.read(link.now()).time]
        desk.date_set += hours * 3600
        desk.nap(1)
        observed.append(plug.now())
    assert observed == sorted(observed)
    assert observed[-1] == desk.slept  # and none of it was lost or made up


def test_a_link_whose_clock_was_put_ahead_is_the_link_in_all_else():
    desk = Desk(ftdi("/dev/ttyUSB0"))
    plug = desk.plug("/dev/ttyUSB0")
    plug.open()
    desk.nap(5)
    desk.date_set = -3600
    link, behind = plug.open(), desk.links[-1]
    assert link is not behind
    link.write(b"data")
    link.send_break(0.5)
    assert (behind.written, behind.broken) == ([b"data"], 0.5)
    assert link.read(12.0) == Chunk(b"", 12.0)
    link.gather(link.now() + 1)
    assert behind.gathered == behind.now() + 1
    assert (link.url, link.baud, link.can_break) == (behind.url, behind.baud, behind.can_break)
    assert link.description == behind.description
    link.close()
    assert behind.closed


def test_a_sleep_in_which_the_clock_stood_still_is_added_to_the_clock_and_its_link():
    desk = Desk(ftdi("/dev/ttyUSB0"))
    wall = WallClock(lambda: desk.slept, lambda: desk.slept + desk.date_set)
    plug = ReconnectingPort(
        "/dev/ttyUSB0", find=lambda: desk.ports, open_port=desk.open, wall=wall, wait=desk.nap
    )
    link = plug.open()
    desk.nap(5)
    desk.date_set = 3600
    assert (link.now(), plug.dated()) == (5, (5, 3605))
    plug.slept(3600)
    assert (link.now(), link.read(3607.0).time, plug.dated()) == (3605, 3607, (3605, 3605))
    assert plug.open().now() == 3605


def test_a_simulated_links_clock_is_followed():
    times = iter([100.0, 150.0])
    link = QuietLink("sim:", 0.0, lambda: 7.0)
    link.is_simulated = True
    plug = ReconnectingPort("sim:", open_port=lambda url: link, clock=times.__next__)
    plug.open()
    assert plug.now() == 57.0
