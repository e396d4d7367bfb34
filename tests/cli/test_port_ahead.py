"""A port that is opened before the program is loaded."""

from __future__ import annotations

import pytest

from mikas.cli.port_ahead import PortAhead
from mikas.errors import BadPortUrl, PortNotFound
from mikas.link.virtual import VirtualLink
from virtual_harness import make_bus

URL = "sim:?clock=simulated"


class Ports:
    """Opens virtual links; not while `absent`."""

    def __init__(self, *, absent: bool = False) -> None:
        self.absent = absent
        self.links: list[VirtualLink] = []

    def open(self, url: str) -> VirtualLink:
        if self.absent:
            raise PortNotFound(url=url, found="")
        self.links.append(VirtualLink(make_bus(), url=url))
        return self.links[-1]


def test_its_link_is_handed_over_once():
    ports = Ports()
    with PortAhead(URL, ports.open) as ahead:
        assert len(ports.links) == 1
        assert ahead.open(URL) is ports.links[0]
        assert ahead.open(URL) is ports.links[1]
    for link in ports.links:
        link.write(b"")  # still open


def test_another_port_is_opened_when_it_is_needed():
    ports = Ports()
    with PortAhead(URL, ports.open) as ahead:
        assert ahead.open("sim:other") is ports.links[1]


def test_a_link_that_is_not_needed_is_closed():
    ports = Ports()
    with PortAhead(URL, ports.open):
        pass
    with pytest.raises(ConnectionError):
        ports.links[0].write(b"\x01")


def test_a_port_that_is_absent_is_tried_again():
    ports = Ports(absent=True)
    with PortAhead(URL, ports.open) as ahead:
        with pytest.raises(PortNotFound):
            ahead.open(URL)
        ports.absent = False
        assert ahead.open(URL) is ports.links[0]


def test_an_invalid_address_is_refused_at_once():
    with pytest.raises(BadPortUrl):
        PortAhead("sim:?foo=1")


def test_a_link_knows_when_it_was_opened():
    ports = Ports()
    with PortAhead(URL, ports.open) as ahead:
        ports.links[0].gather(0.4)
        assert ahead.open(URL).opened == 0.0
