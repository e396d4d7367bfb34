"""USB sockets of the browser's computer, for WebUSB: chip models with the virtual unit behind them.

The browser finds a device as on any Linux: a record in sysfs, one of udev, a message when it comes
or goes, and its file in `/dev/bus/usb` (`usb.transports.usbfs_rig`).
"""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue
from typing import TypeVar

from browser.rig import CAR
from mikas.catalog import shipped
from mikas.virtual.build import build_bus
from usb.chips.device import Device
from usb.chips.named import plugged
from usb.chips.uart import Settings, Uart
from usb.transports import fuse_rig
from usb.transports.usbfs_rig import Plugged, Usbfs
from usb.wire_rig import Lines, Wire

from .computer_rig import Computer

T = TypeVar("T")
_FIRST = 2  # 1 is the root hub's
_PIECE = 64  # bytes that arrive at once
_LOOKS = 1000  # at a chip that is not read; then it overflows


def missing() -> str:
    """What keeps this rig from working here, beside what the computer needs; empty: nothing."""
    return fuse_rig.missing()


class UsbSockets:
    """The USB sockets of a computer, empty at first."""

    def __init__(self, computer: Computer) -> None:
        self._computer = computer
        self.lines = Lines()
        self.usbfs = self.lines.call(Usbfs)
        self.lines.call(lambda: self.usbfs.files.mount("/dev/bus/usb", computer.pid))
        (computer.root / "sys/bus/usb/devices").mkdir(parents=True, exist_ok=True)
        self._records: dict[int, list[str]] = {}

    def plug(self, entry: Plugged) -> int:
        """Plug a device in; return the number of its socket."""
        number = next(it for it in range(_FIRST, 128) if it not in self._records)
        self.lines.call(lambda: self.usbfs.plug(number, entry))
        self._records[number] = self._record(number, entry.device)
        self._computer.tell("add", "usb", "usb_device", self._records[number])
        return number

    def pull(self, number: int) -> None:
        root = self._computer.root
        (root / f"sys/bus/usb/devices/1-{number}").unlink()
        (root / f"run/udev/data/c189:{number - 1}").unlink()
        shutil.rmtree(root / f"sys/devices/pci0000:00/usb1/1-{number}")
        self.lines.call(lambda: self.usbfs.pull(number))
        self._computer.tell("remove", "usb", "usb_device", self._records.pop(number))

    def _record(self, number: int, device: Device) -> list[str]:
        """Write what the kernel and udev keep of a device; return the lines of udev's message."""
        it, root = device.identity, self._computer.root
        folder = root / f"sys/devices/pci0000:00/usb1/1-{number}"
        folder.mkdir(parents=True)
        (folder / "subsystem").symlink_to("/sys/bus/usb")
        lines = [
            "MAJOR=189", f"MINOR={number - 1}", f"DEVNAME=bus/usb/001/{number:03}",
            "DEVTYPE=usb_device", f"PRODUCT={it.vid:x}/{it.pid:x}/{it.release:x}",
            f"TYPE={'/'.join(map(str, it.classes))}", "BUSNUM=001", f"DEVNUM={number:03}",
        ]  # fmt: skip
        (folder / "uevent").write_text("".join(f"{line}\n" for line in lines), "ascii")
        (folder / "dev").write_text(f"189:{number - 1}\n", "ascii")
        descriptors = device.device_descriptor() + device.configuration()
        (folder / "descriptors").write_bytes(descriptors)
        texts = {
            "manufacturer": it.maker, "product": it.product, "serial": it.serial,
            "bConfigurationValue": "1", "busnum": "1", "devnum": str(number),
        }  # fmt: skip
        for name, text in texts.items():
            if text:
                (folder / name).write_text(f"{text}\n", "utf-8")
        shown = root / f"sys/bus/usb/devices/1-{number}"
        shown.symlink_to(f"../../../devices/pci0000:00/usb1/1-{number}")
        (root / f"run/udev/data/c189:{number - 1}").write_text("I:1\n", "ascii")
        place = f"DEVPATH=/devices/pci0000:00/usb1/1-{number}"
        return [place, *(it.replace("=bus/", "=/dev/bus/") for it in lines), f"SEQNUM={number}"]

    def close(self) -> None:
        self.lines.call(self.usbfs.close)
        self.lines.close()


async def fed(uart: Uart, data: bytes) -> None:
    """Let `uart` receive `data` as fast as the page takes them; one that is not read overflows."""
    for at in range(0, len(data), _PIECE):
        for _ in range(_LOOKS):
            if len(uart) < _PIECE:
                break
            await asyncio.sleep(0.001)
        uart.hear(data[at : at + _PIECE], uart.settings)


class UsbCable:
    """A chip with the virtual unit behind it, that can be pulled out and put back.

    `chip`: the model that is plugged in, a new one each time; `entry`: what the kernel knows of it
    (a bound driver, rights). `driver` and `is_detachable` are those of the next plugging-in. `set`,
    `car`, `memory` as `wire_rig.Cable`.
    """

    def __init__(
        self, sockets: UsbSockets, kind: str, serial: str, settings: dict[str, str]
    ) -> None:
        self._sockets, self._kind, self._serial = sockets, kind, serial
        self._settings = settings
        self.driver, self.is_detachable = "", True
        self.wire: Wire = self._new_wire()
        self.entry: Plugged | None = None
        self._number: int | None = None

    def _new_wire(self) -> Wire:
        return self._sockets.lines.put(lambda start: build_bus(self._settings, start=start))

    @property
    def chip(self) -> Device:
        assert self.entry is not None
        return self.entry.device

    def put_back(self) -> None:
        """Plug it in."""
        chip = plugged(self._kind, self.wire, self._serial)
        self.entry = Plugged(chip, driver=self.driver, is_detachable=self.is_detachable)
        self._there(lambda: self.wire.carry(chip.uart))
        self._number = self._sockets.plug(self.entry)

    def pull(self) -> None:
        """Unplug it; nothing happens if it is out."""
        if self._number is not None:
            self._there(self.wire.drop)
            self._sockets.pull(self._number)
            self._number = None

    def tune(self, **settings: str) -> None:
        """Another car and another wire, from the next time that it is plugged in."""
        self._settings |= settings
        self._sockets.lines.remove(self.wire)
        self.wire = self._new_wire()

    def set(self, name: str, raw: str) -> None:
        """The car's datum from now on: `set("UACC", "8A")`."""
        code, data = shipped().parameter(name).code, bytes.fromhex(raw)
        self._there(lambda: self.car.write(code, data))

    def hear(self, data: bytes) -> None:
        """Put `data` on the line for the tester, as fast as the page takes them."""
        self._sockets.lines.run(fed(self.chip.uart, data))

    def fault(self, act: Callable[[Device], T]) -> T:
        """Do something to the chip, as `lambda chip: chip.faults.stall_in()`; it may then serve."""

        def acting() -> T:
            done = act(self.chip)
            self.chip.ready()
            return done

        return self._there(acting)

    def _there(self, act: Callable[[], T]) -> T:
        return self._sockets.lines.call(act)

    @property
    def bus(self):
        return self.wire.bus

    @property
    def car(self):
        return self.bus.ecu.responder.car

    @property
    def memory(self):
        return self.bus.ecu.responder.memory

    def close(self) -> None:
        self.pull()
        self._sockets.lines.remove(self.wire)


class UsbByHand:
    """A chip whose other end is the test itself: what it sends, what it got; as `wire_rig.Wire`."""

    def __init__(self, sockets: UsbSockets, kind: str) -> None:
        self._sockets, self._kind = sockets, kind
        self._received: SimpleQueue[bytes] = SimpleQueue()
        self._number: int | None = None

    def put_back(self) -> None:
        """Plug it in; nothing happens if it is in."""
        if self._number is None:
            self._received = SimpleQueue()
            self._chip = plugged(self._kind, self)
            self._number = self._sockets.plug(Plugged(self._chip))

    def vanish(self) -> None:
        """Unplug it; nothing happens if it is out."""
        if self._number is not None:
            self._sockets.pull(self._number)
            self._number = None

    def send(self, data: bytes, settings: Settings | None = None) -> None:
        """Let `data` arrive, as fast as the chip takes them; with `settings`: the chip has sent."""
        if settings is None:
            self._sockets.lines.run(fed(self._chip.uart, data))
        else:
            self._received.put(data)

    def hold(self, low: bool) -> None:
        """Take a break of the chip."""

    def arrived(self) -> bytes:
        """Return what has come since the last call."""
        data = b""
        while not self._received.empty():
            data += self._received.get()
        return data


@contextmanager
def usb_cable(
    sockets: UsbSockets, folder: Path, kind: str, serial: str = "", **settings: str
) -> Iterator[UsbCable]:
    """Plug in a chip on the car of `browser.rig`, whose values stand still.

    `kind`: a name of `usb.chips.named`; `settings`: those of docs/reference/simulator.md.
    """
    file = folder / "car.toml"
    file.write_text(CAR, "utf-8")
    made = UsbCable(sockets, kind, serial, {"scenario": str(file)} | settings)
    try:
        made.put_back()
        yield made
    finally:
        made.close()
