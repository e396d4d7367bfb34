"""Opening serial links by URL, and what is special about each kind. A pty is in `posix`."""

from __future__ import annotations

import math
import socket
from types import SimpleNamespace

import pytest
import serial

from mikas.errors import BadPortUrl, LinkLost, PortDenied, PortFailed, PortNotFound
from mikas.link import Port, open_link
from mikas.link import serial as serial_link
from mikas.link.base import AT_ONCE, LATENCY_TIMER
from mikas.link.serial import TICK, SerialLink
from mikas.testing.links import FAR, meanwhile, write_until_lost

from .rigs import asked_rig, port_of, rfc2217_rig, tcp_rig


@pytest.fixture
def native(monkeypatch):
    """Stands in for the system's port: what would be opened, and how."""
    opened = []

    class Native(serial.Serial):
        set_low_latency_mode = None

        def open(self):
            opened.append(self)

        def fileno(self):
            return 0

        def close(self):
            """Nothing is open."""

    monkeypatch.setattr(serial_link.serial, "Serial", Native)
    return opened


def test_a_port_is_opened_at_9600_8n1_without_flow_control_and_for_this_program_alone(native):
    link = open_link("/dev/ttyUSB0")
    (port,) = native
    assert port.port == "/dev/ttyUSB0"
    assert port.get_settings() == {
        "baudrate": 9600, "bytesize": 8, "parity": "N", "stopbits": 1,
        "xonxoff": False, "dsrdtr": False, "rtscts": False,
        "timeout": port.timeout, "write_timeout": port.write_timeout, "inter_byte_timeout": None,
    }  # fmt: skip
    assert port.exclusive is True
    assert 0 < port.write_timeout < 5
    assert (link.baud, link.url) == (9600, "/dev/ttyUSB0")


def test_lines_are_set_before_opening(native):
    open_link("COM3")
    open_link("COM3?dtr=0&rts=on")
    assert [(port.dtr, port.rts) for port in native] == [(True, False), (False, True)]


def test_the_baud_rate_of_the_url_is_set(native):
    link = open_link("serial:COM3", baud=10400)
    assert (link.baud, native[0].baudrate, native[0].port) == (10400, 10400, "COM3")
    assert link.url == "serial:COM3?baud=10400"


@pytest.mark.parametrize("agreed", [True, False])
def test_low_latency_is_set_where_the_driver_agrees(native, monkeypatch, agreed):
    def ask(port, on):
        if not agreed:
            raise ValueError("Failed to update ASYNC_LOW_LATENCY flag to True")

    monkeypatch.setattr(serial_link.serial.Serial, "set_low_latency_mode", ask)
    adapter = Port("/dev/ttyUSB0", "FT232R USB UART (FTDI)", "FT232R")
    monkeypatch.setattr(serial_link, "find_ports", lambda: [adapter])
    link = open_link("/dev/ttyUSB0")
    assert (link.granularity == AT_ONCE) is agreed
    assert link.description == "FT232R USB UART (FTDI)" + ", low latency" * agreed


def test_a_chip_without_a_timer_is_not_called_of_low_latency(native, monkeypatch):
    monkeypatch.setattr(serial_link.serial.Serial, "set_low_latency_mode", lambda port, on: None)
    adapter = Port("/dev/ttyUSB0", "CP2102 USB to UART Bridge (Silicon Labs)", "CP210x")
    monkeypatch.setattr(serial_link, "find_ports", lambda: [adapter])
    link = open_link("/dev/ttyUSB0")
    assert link.description == "CP2102 USB to UART Bridge (Silicon Labs)"
    assert link.chip == "CP210x"


def test_without_a_low_latency_mode_the_latency_timer_counts(native):
    assert open_link("COM3").granularity == LATENCY_TIMER


@pytest.mark.parametrize(
    "url",
    [
        "/dev/ttyUSB0?baud=0",
        "/dev/ttyUSB0?baud=fast",
        "/dev/ttyUSB0?parity=E",
        "socket://host:4001?dtr=1",
        "socket://host",
        "socket://:4001",
        "socket://host:0",
        "socket://host:65536",
        "socket://host:port",
        "socket://host:1/path",
        "socket://user@host:1",
        "socket://[::1:4001",
        "rfc2217://host",
        "rfc2217://host:1?rts=maybe",
    ],
)
def test_wrong_urls_are_refused_before_anything_is_opened(url):
    with pytest.raises(BadPortUrl) as caught:
        open_link(url)
    assert f"Invalid port “{url.replace('user@', '…@')}”" in str(caught.value)


def test_a_port_that_does_not_exist_is_not_found():
    with pytest.raises(PortNotFound, match="mikas-no-such-port"):
        open_link("/dev/mikas-no-such-port")


def test_a_port_without_the_right_to_it_is_denied_with_the_group(native, monkeypatch):
    def refuse(port):
        raise serial.SerialException(13, "could not open port: Permission denied")

    monkeypatch.setattr(serial_link.serial.Serial, "open", refuse)
    with pytest.raises(PortDenied, match="dialout"):
        open_link("/dev/ttyUSB0")


@pytest.mark.parametrize("scheme", ["socket", "rfc2217"])
def test_a_refused_connection_says_that_no_program_listens(scheme):
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(PortFailed, match="no program listens there"):
        open_link(f"{scheme}://127.0.0.1:{port}")


@pytest.mark.realtime
class TestSocket:
    def test_requests_are_not_held_back(self):
        with tcp_rig() as rig:
            sock = port_of(rig.link)._socket  # noqa: SLF001
            assert sock.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)

    def test_is_named_by_its_place_and_has_the_baud_rate_behind_it(self):
        with socket.create_server(("127.0.0.1", 0)) as server:
            place = f"127.0.0.1:{server.getsockname()[1]}"
            with open_link(f"socket://{place}", baud=10400) as link:
                assert (link.description, link.baud) == (f"TCP {place}", 10400)

    def test_an_end_that_never_reads_can_not_hang_a_write(self, monkeypatch):
        monkeypatch.setattr(serial_link, "PATIENCE", 0.05)
        monkeypatch.setattr(serial_link, "LONGEST_REQUEST", 0)
        with tcp_rig() as rig, pytest.raises(LinkLost, match="takes no more bytes"):
            write_until_lost(rig.link, bytes(1_000_000))

    def test_bytes_received_before_the_end_are_read_first(self):
        with tcp_rig() as rig:
            rig.peer.send(b"\x09\xf7\r")
            rig.peer.vanish()
            assert rig.link.read(rig.link.now() + FAR).data == b"\x09\xf7\r"
            with pytest.raises(LinkLost, match="closed by the other end"):
                rig.link.read(rig.link.now() + FAR)

    def test_a_reset_connection_is_lost_and_leaves_nothing_open(self):
        with tcp_rig() as rig:
            rig.link.write(b"unread: closing now resets the connection")
            rig.peer.received(1)
            rig.link.write(b"and this too")
            sock = port_of(rig.link)._socket  # noqa: SLF001
            rig.peer.vanish()
            with pytest.raises(LinkLost):
                write_until_lost(rig.link, b"x")
            assert sock.fileno() == -1


@pytest.mark.realtime
class TestRfc2217:
    def test_the_far_port_gets_the_settings_of_the_url(self):
        with rfc2217_rig("?baud=10400&rts=1&dtr=0") as rig:
            line = rig.peer.line
            assert (line.baudrate, line.bytesize, line.parity) == (10400, 8, "N")
            rig.peer.wait_for_line(rts=True, dtr=False)
            assert rig.link.description.startswith("RFC 2217 127.0.0.1:")

    def test_a_break_reaches_the_far_port(self, monkeypatch):
        with rfc2217_rig() as rig:

            def look(seconds):
                rig.peer.wait_for_line(break_condition=True)

            monkeypatch.setattr(serial_link, "time", SimpleNamespace(sleep=look))
            rig.link.send_break(0.25)
            rig.peer.wait_for_line(break_condition=False)


class TestPortThatTheSystemCanNotWaitOn:
    """As on Windows, where a port has no file number."""

    def test_its_settings_are_never_touched_after_opening(self, monkeypatch):
        def touched(port):
            raise AssertionError("reconfigured")

        with asked_rig() as rig:
            monkeypatch.setattr(type(rig.link.port), "_reconfigure_port", touched)
            rig.peer.send(b"x")
            rig.link.read(rig.link.now() + FAR)
            rig.link.read(rig.link.now() + 3 * TICK)

    def test_all_that_has_arrived_comes_in_one_chunk(self):
        with asked_rig() as rig:
            rig.peer.send(b"\x1a\x7d\x69\r")
            assert rig.link.read(rig.link.now() + FAR).data == b"\x1a\x7d\x69\r"

    def test_a_short_count_is_a_loss(self, monkeypatch):
        with asked_rig() as rig:
            monkeypatch.setattr(type(rig.link.port), "write", lambda *_: 1)
            with pytest.raises(LinkLost, match="takes no more bytes"):
                rig.link.write(b"\x01\xff\r")


@pytest.mark.realtime
def test_a_wait_without_end_is_a_wait():
    with asked_rig() as rig, meanwhile(lambda: rig.peer.send(b"x")):
        assert rig.link.read(math.inf).data == b"x"


def test_a_link_can_be_made_of_an_open_port():
    port = serial.serial_for_url("loop://", timeout=TICK)
    with SerialLink("loop://", port, about="a loop") as link:
        link.write(b"abc")
        assert link.read(link.now() + FAR).data == b"abc"
        assert link.description == "a loop"
