"""usbredir as QEMU speaks it, to a model behind it."""

from __future__ import annotations

import asyncio
import struct

import pytest

from usb.book_rig import Far
from usb.chips.named import plugged
from usb.chips.uart import BREAK, Form, Settings
from usb.transports import redir_rig
from usb.transports.redir_rig import BABBLE, CANCELLED, OK, STALL, UsbRedir

IN_END, OUT_END = 0x81, 0x01  # of a CP2102


class Qemu(asyncio.WriteTransport):
    """The other end: writes packets, reads those that came."""

    def __init__(self, redir: UsbRedir, capabilities: int) -> None:
        self.redir, self.form = redir, "<III"
        self.data = b""
        self.came = asyncio.Event()
        redir.connection_made(self)
        hello = b"qemu".ljust(64, b"\0") + struct.pack("<I", capabilities)
        self.send(redir_rig.HELLO, 0, hello)
        if capabilities & 1 << 5:
            size = 12 + 68  # the greeting itself has narrow numbers
            assert struct.unpack_from("<II", self.data) == (redir_rig.HELLO, 68)
            self.data, self.form = self.data[size:], "<IIQ"

    def write(self, data: bytes) -> None:
        self.data += data
        self.came.set()

    def send(self, kind: int, number: int, body: bytes = b"") -> None:
        packet = struct.pack(self.form, kind, len(body), number) + body
        for at in range(0, len(packet), 7):  # in any pieces
            self.redir.data_received(packet[at : at + 7])

    def bulk(self, number: int, end: int, length: int, data: bytes = b"") -> None:
        body = struct.pack("<BBHIH", end, 0, length & 0xFFFF, 0, length >> 16)
        self.send(redir_rig.BULK_PACKET, number, body + data)

    def control(self, number, kind, request, value=0, index=0, data=b"", length=0) -> None:
        end = kind & 0x80
        body = struct.pack("<BBBBHHH", end, request, kind, 0, value, index, length or len(data))
        self.send(redir_rig.CONTROL_PACKET, number, body + data)

    def packets(self):
        """Return all that came, as kind, number and body."""
        found = []
        size = struct.calcsize(self.form)
        while self.data:
            kind, length, number = struct.unpack_from(self.form, self.data)
            found.append((kind, number, self.data[size : size + length]))
            self.data = self.data[size + length :]
        return found

    def bulks(self):
        """Return number, status and data of the bulk packets that came."""
        bulks = [it for it in self.packets() if it[0] == redir_rig.BULK_PACKET]
        return [(number, body[1], body[10:]) for _, number, body in bulks]


@pytest.fixture
def far():
    return Far()


@pytest.fixture
def cp2102(far):
    device = plugged("CP2102", far, serial="0001")
    device.ports[0].enabled = True
    device.uart.set(9600, Form())
    return device


def with_qemu(test):
    """Run `test` on a loop, which the transport wants."""

    async def run() -> None:
        test()

    asyncio.run(run())


ALL = redir_rig.CAPABILITIES


def test_a_device_is_announced_with_its_interfaces_and_endpoints(cp2102):
    def test():
        qemu = Qemu(redir := UsbRedir(), ALL)
        redir.plug(cp2102)
        (_, _, interfaces), (_, _, ends), (kind, _, connect) = qemu.packets()
        assert kind == redir_rig.CONNECT
        assert struct.unpack("<BBBBHHH", connect) == (1, 0, 0, 0, 0x10C4, 0xEA60, 0x0100)
        assert interfaces[:4] == b"\x01\0\0\0"
        assert interfaces[4 + 32] == 0xFF
        assert (ends[1], ends[17], ends[2], ends[0]) == (2, 2, 0xFF, 0)
        assert struct.unpack_from("<H", ends, 96 + 2 * 17) == (64,)

    with_qemu(test)


def test_a_device_that_was_plugged_before_the_greeting_is_announced_after_it(cp2102):
    def test():
        redir = UsbRedir()
        redir.plug(cp2102)
        qemu = Qemu(redir, ALL & ~(1 << 5))  # narrow numbers
        assert [kind for kind, _, _ in qemu.packets()] == [
            redir_rig.HELLO, redir_rig.INTERFACES, redir_rig.ENDPOINTS, redir_rig.CONNECT,
        ]  # fmt: skip

    with_qemu(test)


def test_requests_are_answered_stall_or_wait_until_they_are_cancelled(cp2102):
    def test():
        qemu = Qemu(redir := UsbRedir(), ALL)
        redir.plug(cp2102)
        cp2102.faults.hang(0x05)
        qemu.packets()
        qemu.control(1, 0xC0, 0xFF, 0x370B, length=1)
        qemu.control(2, 0x40, 0x77)
        qemu.control(3, 0x41, 0x05, 1)
        found = [(number, body[3], body[10:]) for _, number, body in qemu.packets()]
        assert found == [(1, OK, b"\x02"), (2, STALL, b"")]
        qemu.send(redir_rig.CANCEL, 3)
        [(_, number, body)] = qemu.packets()
        assert (number, body[3]) == (3, CANCELLED)

    with_qemu(test)


def test_a_transfer_ends_with_a_short_packet_or_when_it_is_full(cp2102):
    def test():
        qemu = Qemu(redir := UsbRedir(), ALL)
        redir.plug(cp2102)
        qemu.bulk(1, IN_END, 512)
        qemu.bulk(2, IN_END, 64)
        cp2102.uart.hear(bytes(70), Settings())
        cp2102.uart.hear(bytes(64), Settings())
        assert [(n, status, len(data)) for n, status, data in qemu.bulks()] == [
            (1, OK, 70), (2, OK, 64),
        ]  # fmt: skip

    with_qemu(test)


def test_data_go_out_and_a_cancelled_transfer_has_what_had_come(cp2102, far):
    def test():
        qemu = Qemu(redir := UsbRedir(), ALL)
        redir.plug(cp2102)
        qemu.bulk(1, OUT_END, 3, b"\x01\xff\x0d")
        assert (far.data, qemu.bulks()) == (b"\x01\xff\x0d", [(1, OK, b"")])
        qemu.bulk(2, IN_END, 512)
        cp2102.uart.hear(bytes(64), Settings())
        qemu.send(redir_rig.CANCEL, 2)
        assert qemu.bulks() == [(2, CANCELLED, bytes(64))]

    with_qemu(test)


def test_a_halted_endpoint_and_a_babbling_one_fail_the_transfer(cp2102):
    def test():
        qemu = Qemu(redir := UsbRedir(), ALL)
        redir.plug(cp2102)
        cp2102.faults.babble()
        qemu.bulk(1, IN_END, 64)
        cp2102.uart.hear(b"1", Settings())
        assert [it[:2] for it in qemu.bulks()] == [(1, BABBLE)]
        cp2102.faults.stall_in()
        qemu.bulk(2, IN_END, 64)
        assert [it[:2] for it in qemu.bulks()] == [(2, STALL)]
        qemu.control(3, 0x02, 1, 0, IN_END)
        qemu.bulk(4, IN_END, 64)
        qemu.packets()
        cp2102.uart.hear(b"2", Settings())
        assert qemu.bulks() == [(4, OK, b"2")]

    with_qemu(test)


def test_notices_come_once_the_host_listens_for_them(far):
    def test():
        device = plugged("PL2303HX", far)
        qemu = Qemu(redir := UsbRedir(), ALL)
        redir.plug(device)
        qemu.packets()
        device.uart.receive([BREAK])
        assert qemu.packets() == []
        qemu.send(redir_rig.START_INTERRUPT, 1, b"\x81")
        notice, (kind, _, body) = sorted(qemu.packets(), reverse=True)
        assert (kind, body) == (redir_rig.INTERRUPT_STATUS, b"\x00\x81")
        assert notice[2] == b"\x81\x00\x0a\x00" + b"\xa1\x20\0\0\0\0\x02\0\x84\0"

    with_qemu(test)


@pytest.mark.realtime
def test_a_timer_of_the_chip_brings_a_packet_by_itself(far):
    async def test() -> None:
        device = plugged("FT232R", far)
        qemu = Qemu(redir := UsbRedir(), ALL)
        redir.plug(device)
        qemu.bulk(1, IN_END, 512)
        assert [(number, data) for number, _, data in qemu.bulks()] == [(1, b"\x11\x60")]
        qemu.came = asyncio.Event()
        qemu.bulk(2, IN_END, 512)
        assert qemu.bulks() == []
        await asyncio.wait_for(qemu.came.wait(), 60)
        assert [(number, data) for number, _, data in qemu.bulks()] == [(2, b"\x11\x60")]

    asyncio.run(test())


def test_pulled_out_nothing_comes_any_more(cp2102):
    async def test() -> None:
        qemu = Qemu(redir := UsbRedir(), ALL)
        redir.plug(cp2102)
        qemu.bulk(1, IN_END, 64)
        qemu.packets()
        pulling = asyncio.create_task(redir.pull())
        await asyncio.sleep(0)
        cp2102.uart.hear(b"1", Settings())
        assert [kind for kind, _, _ in qemu.packets()] == [redir_rig.DISCONNECT]
        assert not pulling.done()
        qemu.send(redir_rig.DISCONNECTED, 0)
        await pulling

    asyncio.run(test())
