"""The serial link over a pty: the contract, and what a real adapter does at its worst moments."""

from __future__ import annotations

import errno
import os
import pty
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
import serial

from mikas.errors import LinkLost, PortBusy, PortDenied, PortFailed, PortNotFound
from mikas.link import CaptureTee, open_link
from mikas.link import serial as serial_link
from mikas.link.base import LATENCY_TIMER
from mikas.testing.links import FAR, RealTimeContract, Rig, meanwhile, write_until_lost

from ..closing import close_at_each_line
from ..rigs import port_of
from ..test_closing import USES
from ..test_contract import teed

pytestmark = pytest.mark.realtime

HOLD = """
import sys, serial
port = serial.Serial(sys.argv[1], exclusive=True)
print("open", flush=True)
sys.stdin.read()
"""


class PtyPeer:
    """The master's side."""

    def __init__(self, master: int) -> None:
        self.master = master
        self.open = True

    def send(self, data: bytes) -> None:
        os.write(self.master, data)

    def received(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            ready, _, _ = select.select([self.master], [], [], FAR)
            assert ready, f"only {data!r} came"
            data += os.read(self.master, 4096)
        return data

    def vanish(self) -> None:
        if self.open:
            self.open = False
            os.close(self.master)


@contextmanager
def a_pty() -> Iterator[tuple[str, PtyPeer]]:
    master, slave = pty.openpty()
    peer = PtyPeer(master)
    try:
        yield os.ttyname(slave), peer
    finally:
        peer.vanish()
        os.close(slave)


@contextmanager
def pty_rig(options: str = "") -> Iterator[Rig]:
    with a_pty() as (name, peer), open_link(f"{name}{options}") as link:
        yield Rig(link, peer)


@pytest.fixture
def rig():
    with pty_rig() as rig:
        yield rig


@pytest.fixture
def about_to_wait(monkeypatch):
    """Set when a link enters its wait."""
    event, real = threading.Event(), select.select

    def select_and_tell(*args):
        event.set()
        return real(*args)

    monkeypatch.setattr(serial_link.select, "select", select_and_tell)
    return event


def is_raw(rig: Rig) -> bool:
    """Whether the terminal layer leaves the bytes alone."""
    rig.peer.send(b"\x03\x04\x11\x13\x1a\r\n\x7f\xff")
    return rig.link.read(rig.link.now() + FAR).data == b"\x03\x04\x11\x13\x1a\r\n\x7f\xff"


class TestPty(RealTimeContract):
    can_set_baud = True

    @pytest.fixture
    def rig(self):
        with pty_rig() as rig:
            yield rig

    @pytest.fixture(autouse=True)
    def look_often(self, monkeypatch):
        monkeypatch.setattr(serial_link, "LONGEST_WAIT", 0.05)


class TestTeeOverPty(RealTimeContract):
    can_set_baud = True

    @pytest.fixture
    def rig(self):
        with pty_rig() as rig:
            yield teed(rig)

    @pytest.fixture(autouse=True)
    def look_often(self, monkeypatch):
        monkeypatch.setattr(serial_link, "LONGEST_WAIT", 0.05)


def test_control_characters_are_bytes_like_any_other(rig):
    assert is_raw(rig)


def test_a_pty_has_no_low_latency_and_is_named_by_its_path(rig):
    assert rig.link.granularity == LATENCY_TIMER
    assert rig.link.description == rig.link.url


def test_the_baud_rate_comes_from_the_url():
    with pty_rig("?baud=10400&dtr=0&rts=1") as rig:
        assert rig.link.baud == 10400
        assert rig.link.byte_time == pytest.approx(0.9615e-3, rel=1e-3)
        assert is_raw(rig)


def test_unplugged_in_the_middle_of_a_wait_it_is_lost(rig, about_to_wait):
    def unplug():
        about_to_wait.wait(FAR)
        rig.peer.vanish()

    began = rig.link.now()
    with meanwhile(unplug), pytest.raises(LinkLost, match="unplugged"):
        rig.link.read(began + FAR)
    assert rig.link.now() < began + FAR / 2


def test_unplugged_while_it_takes_no_bytes_it_is_lost(rig):
    with (
        meanwhile(lambda: (rig.peer.received(1), rig.peer.vanish())),
        pytest.raises(LinkLost, match="unplugged") as caught,
    ):
        write_until_lost(rig.link, bytes(100_000))
    assert caught.value.request == bytes(100_000)


def test_an_end_that_never_reads_can_not_hang_a_write(monkeypatch):
    monkeypatch.setattr(serial_link, "PATIENCE", 0.02)
    monkeypatch.setattr(serial_link, "LONGEST_REQUEST", 0)
    with pty_rig() as rig, pytest.raises(LinkLost, match="takes no more bytes"):
        rig.link.write(bytes(100_000))


def test_a_lost_port_is_let_go_so_that_the_adapter_can_come_back(rig):
    rig.peer.vanish()
    with pytest.raises(LinkLost):
        rig.link.read(rig.link.now() + FAR)
    assert not port_of(rig.link).is_open


def test_ctrl_c_interrupts_a_wait(rig, about_to_wait):
    def press():
        about_to_wait.wait(FAR)
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

    with meanwhile(press), pytest.raises(KeyboardInterrupt):
        rig.link.read(rig.link.now() + FAR)
    assert is_raw(rig)  # and the link is as good as before


def test_ctrl_c_in_a_break_ends_the_break(rig, monkeypatch):
    def interrupted(seconds):
        assert port_of(rig.link).break_condition
        raise KeyboardInterrupt

    monkeypatch.setattr(serial_link, "time", SimpleNamespace(sleep=interrupted))
    with pytest.raises(KeyboardInterrupt):
        rig.link.send_break(FAR)
    assert not port_of(rig.link).break_condition


def test_a_port_without_a_break_says_so_and_stays_usable(rig, monkeypatch):
    def refuse(port):
        raise OSError(errno.ENOTTY, "Inappropriate ioctl for device")

    monkeypatch.setattr(serial.Serial, "_update_break_state", refuse)
    rig.link.send_break(0.0)
    assert not rig.link.can_break
    rig.link.send_break(0.0)
    assert is_raw(rig)


def test_unplugged_in_a_break_it_is_lost(rig, monkeypatch):
    def fail(port):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(serial.Serial, "_update_break_state", fail)
    with pytest.raises(LinkLost, match="unplugged"):
        rig.link.send_break(0.0)
    assert CaptureTee(rig.link, None).can_break  # it is gone, not unable


def test_a_second_program_finds_the_port_busy(rig):
    with pytest.raises(PortBusy) as caught:
        open_link(rig.link.url)
    assert "занят" in caught.value.text.ru
    rig.link.close()
    with open_link(rig.link.url) as again:
        assert is_raw(Rig(again, rig.peer))


def test_the_program_that_has_the_port_open_is_named():
    with (
        a_pty() as (name, _),
        subprocess.Popen(
            [sys.executable, "-c", HOLD, name], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        ) as other,
    ):
        assert other.stdout.readline() == b"open\n"
        with pytest.raises(PortBusy, match=rf"in use by \S+ \(process {other.pid}\)"):
            open_link(name)
        other.stdin.close()


def test_a_device_that_does_not_exist_is_not_found():
    with pytest.raises(PortNotFound) as caught:
        open_link("/dev/ttyMIKAS0")
    assert "/dev/ttyMIKAS0" in str(caught.value)


@pytest.mark.parametrize("place", ["/dev/null", "{tmp}/file", "{tmp}"])
def test_a_file_is_refused_as_no_serial_port(place, tmp_path):
    (tmp_path / "file").write_bytes(b"not a tty")
    with pytest.raises(PortFailed) as caught:
        open_link(place.format(tmp=tmp_path))
    assert "not a serial port" in str(caught.value)


@pytest.mark.parametrize(
    ("number", "raised"),
    [(errno.EACCES, PortDenied), (errno.EBUSY, PortBusy), (errno.ENXIO, PortNotFound)],
)
def test_a_refusal_by_the_system_is_the_error_of_its_kind(number, raised, monkeypatch):
    def refuse(path, flags):
        raise OSError(number, os.strerror(number), path)

    with a_pty() as (name, _), monkeypatch.context() as patch:
        patch.setattr(serial.serialposix.os, "open", refuse)
        with pytest.raises(raised) as caught:
            serial_link.open_serial(name, {})
    assert name in str(caught.value)


def test_opening_leaves_nothing_behind_when_it_fails(tmp_path):
    (tmp_path / "file").write_bytes(b"not a tty")
    before = set(Path("/dev/fd").iterdir())
    with pytest.raises(PortFailed):
        open_link(str(tmp_path / "file"))
    assert set(Path("/dev/fd").iterdir()) == before


@pytest.mark.parametrize("use", USES)
def test_closing_by_another_thread_at_any_moment_ends_the_call(use):
    assert close_at_each_line(pty_rig, USES[use]) > 1
