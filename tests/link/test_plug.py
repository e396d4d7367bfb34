"""A port that comes and goes is found again by what it is, not by its name."""

from __future__ import annotations

import pytest

from mikas.errors import PortNotFound
from mikas.link.plug import Plug
from mikas.link.ports import Port


class Desk:
    """A computer with ports, and what was opened on it."""

    def __init__(self, *ports: Port) -> None:
        self.ports = list(ports)
        self.opened: list[str] = []
        self.slept = 0.0

    def open(self, url: str) -> str:
        if url.partition("?")[0] not in [port.url for port in self.ports] and ":" not in url:
            raise PortNotFound(url=url, found="")
        self.opened.append(url)
        return url

    def nap(self, seconds: float) -> None:
        self.slept += seconds

    def plug(self, url: str) -> Plug:
        return Plug(
            url,
            find=lambda: self.ports,
            open_port=self.open,
            clock=lambda: self.slept,
            nap=self.nap,
        )


def ftdi(url: str, serial: str | None = "A1") -> Port:
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
