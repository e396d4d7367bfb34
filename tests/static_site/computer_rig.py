"""A computer of its own for the browser, in namespaces: its USB sockets are this rig's.

The browser sees tmpfs in the place of `/sys`, `/dev` and `/run`, with the records that the kernel
and udev would keep of each adapter; the adapter's `/dev/ttyUSB…` is a link to a pty. udev's
messages are broadcast in the network namespace, so nothing outside hears them; a page's host
listens on a socket that was made inside (`Computer.listen`). All of it ends with the process of
`_SETUP`, at the latest when the tests' process does.

The pty has no modem lines: a browser can't set DTR and RTS there, and a break is lost. Whole USB
devices, for WebUSB, are in `usb_sockets_rig`.
"""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import socket
import struct
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

PORT = 8000
ORIGIN = f"http://localhost:{PORT}"
"""Where a page may use every adapter unasked, by the browser's policy. The network is the rig's
own, so the port is always free.
"""
CHOOSING = f"http://127.0.0.2:{PORT}"
"""The same host, where a page may use an adapter once it was chosen (`Computer.choose`)."""
USB_VENDORS = (0x0403, 0x1A86, 0x4348, 0x10C4, 0x067B, 0x04D8, 0x16C0)
"""The makers of the models in `usb.chips`."""
_POLICIES = Path("/etc/chromium")
_SETUP = """\
set -e
mount -t tmpfs none /mnt
mkdir /mnt/pts /mnt/shm
for it in null zero full random urandom tty ptmx; do
    touch /mnt/$it && mount --bind /dev/$it /mnt/$it
done
mount --rbind /dev/pts /mnt/pts
mount -t tmpfs none /mnt/shm
ln -s /proc/self/fd /mnt/fd
mount --rbind /mnt /dev
for it in /sys /run /etc/chromium; do mount -t tmpfs none $it; done
mkdir -p /sys/bus /sys/class/tty /run/udev/data /etc/chromium/policies/managed
touch /run/udev/control
cat /proc/tty/drivers - > /run/drivers << END
usbserial            /dev/ttyUSB   188 0-511 serial
END
mount --bind /run/drivers /proc/tty/drivers
ip link set lo up
echo ready
cat
"""
"""Ends when its input does. `/run/udev/control` shows to libudev that udev is running."""
_CLONE_NEWNET = 0x40000000
_KOBJECT_UEVENT = 15
_UDEV = 2  # the multicast group in which udev tells what it has done


def missing() -> str:
    """What keeps this rig from working here; empty: nothing."""
    if not Path("/proc/self/ns/mnt").exists():
        return "not Linux"
    if os.geteuid():
        return "not root: the fake adapter needs a mount namespace"
    for tool in ("unshare", "nsenter", "mount", "ip"):
        if not shutil.which(tool):
            return f"{tool} is not installed"
    if not _POLICIES.is_dir():
        return f"{_POLICIES} is missing: the browser's policy has no place"
    command = ["unshare", "--mount", "--net", "mount", "-t", "tmpfs", "none", "/sys"]
    tried = subprocess.run(command, check=False, capture_output=True, text=True)
    return tried.stderr.strip() and f"no namespace: {tried.stderr.strip()}"


@dataclass(frozen=True)
class Adapter:
    """What the browser is told of an adapter on USB."""

    vid: str
    pid: str
    name: str
    serial_number: str = ""


FT232 = Adapter("0403", "6001", "FT232R_USB_UART", "A10KZ3YT")
CH340 = Adapter("1a86", "7523", "USB_Serial")


class Computer:
    """USB sockets, a browser's start (`wrapper`), and a network of its own."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        """The process that its namespaces end with."""
        self.root = Path(f"/proc/{pid}/root")
        """Its files, from outside."""
        self._plugged: dict[int, Adapter] = {}
        self._numbers = cycle(range(512))
        self._messages = self._inside(
            lambda: socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, _KOBJECT_UEVENT)
        )
        self._grant(ORIGIN)

    def wrapper(self, program: str, folder: Path) -> str:
        """Write a program into `folder` that starts `program` in here; return its path."""
        file = folder / "in-the-computer"
        file.write_text(
            "#!/bin/sh\n"
            "export SYSTEMD_DEVICE_VERIFY_SYSFS=0\n"
            f'exec nsenter --target {self.pid} --mount --net {program} "$@"\n',
            "utf-8",
        )
        file.chmod(0o755)
        return str(file)

    def listen(self, port: int = PORT) -> socket.socket:
        """Make a socket that listens at `port` of this computer's network."""
        return self._inside(lambda: socket.create_server(("", port)))

    def choose(self) -> None:
        """Do as the user who chooses all adapters for `CHOOSING` in the browser's list.

        No test can click there. A browser notes it that is started afterwards; one that runs may or
        may not, after five seconds.
        """
        self._grant(ORIGIN, CHOOSING)

    def forget_choice(self) -> None:
        """Do as the user who takes that back in the browser's settings."""
        self._grant(ORIGIN)

    def _grant(self, *origins: str) -> None:
        devices = [{"vendor_id": vendor} for vendor in USB_VENDORS]
        policy = json.dumps(
            {
                "SerialAllowAllPortsForUrls": origins,
                "WebUsbAllowDevicesForUrls": [{"devices": devices, "urls": origins}],
            }
        )
        managed = self.root / "etc/chromium/policies/managed/adapters.json"
        if not managed.exists() or managed.read_text("ascii") != policy:
            managed.write_text(policy, "ascii")

    def plug(self, adapter: Adapter, pty: str) -> int:
        """Plug `adapter` in, whose line is `pty`; return the number of its ttyUSB.

        Another one each time: a browser that a busy machine lets hear of the unplugging late would
        find the new adapter at the old one's name, open it, and then hear that it is gone.
        """
        number = next(it for it in self._numbers if it not in self._plugged)
        device = f"devices/pci0000:00/usb1/1-{number + 1}/1-{number + 1}:1.0"
        name = f"ttyUSB{number}"
        folder = self.root / "sys" / device / name / "tty" / name
        folder.mkdir(parents=True)
        (folder / "subsystem").symlink_to("/sys/class/tty")
        (folder / "uevent").write_text(f"MAJOR=188\nMINOR={number}\nDEVNAME={name}\n", "ascii")
        (folder / "dev").write_text(f"188:{number}\n", "ascii")
        shown = self.root / "sys/class/tty" / name
        shown.symlink_to(f"../../{device}/{name}/tty/{name}")
        record = self.root / f"run/udev/data/c188:{number}"
        record.write_text("".join(f"E:{it}\n" for it in _properties(adapter)), "ascii")
        (self.root / "dev" / name).symlink_to(pty)
        self._plugged[number] = adapter
        self._tell("add", number)
        return number

    def unplug(self, number: int) -> None:
        """Pull it out."""
        name = f"ttyUSB{number}"
        (self.root / "dev" / name).unlink()
        (self.root / f"run/udev/data/c188:{number}").unlink()
        (self.root / "sys/class/tty" / name).unlink()
        shutil.rmtree(self.root / f"sys/devices/pci0000:00/usb1/1-{number + 1}")
        self._tell("remove", number)
        del self._plugged[number]

    def unplug_all(self) -> None:
        for number in list(self._plugged):
            self.unplug(number)

    def _tell(self, action: str, number: int) -> None:
        name = f"ttyUSB{number}"
        device = f"/devices/pci0000:00/usb1/1-{number + 1}/1-{number + 1}:1.0/{name}/tty/{name}"
        lines = [
            f"DEVPATH={device}", f"DEVNAME=/dev/{name}",
            "MAJOR=188", f"MINOR={number}", f"SEQNUM={number + 1}",
            *_properties(self._plugged[number]),
        ]  # fmt: skip
        self.tell(action, "tty", "", lines)

    def tell(self, action: str, subsystem: str, device_type: str, lines: list[str]) -> None:
        """Send udev's message, as libudev sends it to the programs that listen."""
        lines = [f"ACTION={action}", f"SUBSYSTEM={subsystem}", *lines]
        text = b"".join(f"{it}\0".encode() for it in lines)
        numbers = struct.pack("=III", 40, 40, len(text))
        kind = _murmur_hash(device_type.encode()) if device_type else 0
        filters = struct.pack(">IIII", _murmur_hash(subsystem.encode()), kind, 0, 0)
        message = b"libudev\0" + struct.pack(">I", 0xFEEDCAFE) + numbers + filters + text
        self._messages.sendto(message, (0, _UDEV))

    def _inside(self, make):
        """Return what `make()` makes in this computer's network: a thread of its own goes there."""

        def work():
            with Path(f"/proc/{self.pid}/ns/net").open("rb") as network:
                if ctypes.CDLL(None, use_errno=True).setns(network.fileno(), _CLONE_NEWNET):
                    raise OSError(ctypes.get_errno(), "setns")
            return make()

        with ThreadPoolExecutor(1) as threads:
            return threads.submit(work).result()

    def close(self) -> None:
        self._messages.close()


@contextmanager
def computer() -> Iterator[Computer]:
    command = ["unshare", "--mount", "--net", "sh", "-c", _SETUP]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as stay:
        assert stay.stdin is not None
        assert stay.stdout is not None
        assert stay.stdout.readline() == "ready\n", "the namespace was not made"
        made = Computer(stay.pid)
        try:
            yield made
        finally:
            made.close()
            stay.stdin.close()


def _properties(adapter: Adapter) -> list[str]:
    number = [f"ID_SERIAL_SHORT={adapter.serial_number}"] if adapter.serial_number else []
    return [
        "ID_BUS=usb", f"ID_VENDOR_ID={adapter.vid}", f"ID_MODEL_ID={adapter.pid}",
        f"ID_MODEL={adapter.name}", f"ID_MODEL_ENC={adapter.name}", *number,
    ]  # fmt: skip


def _murmur_hash(data: bytes) -> int:
    """Return MurmurHash2 of `data`, by which a program's socket is told the subsystem."""
    mix, most = 0x5BD1E995, 0xFFFFFFFF
    value = len(data)
    whole = len(data) // 4 * 4
    for (word,) in struct.iter_unpack("<I", data[:whole]):
        mixed = word * mix & most
        value = value * mix & most ^ (mixed ^ mixed >> 24) * mix & most
    if rest := data[whole:]:
        value = (value ^ int.from_bytes(rest, "little")) * mix & most
    value = (value ^ value >> 13) * mix & most
    return value ^ value >> 15
