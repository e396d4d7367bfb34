"""The box: a guest under QEMU with USB ports, in which the program runs as on an owner's laptop.

    Box ── QMP ── QEMU ─┬─ Debian's kernel: xhci, usbserial, ftdi_sio ── /dev/ttyUSB0 ── mikas
     │                  └─ emulated FT232 ─┐
     └─ Lines ── Wire: the virtual unit ───┘ (a socket)

Software emulation (tcg) everywhere, so that the box is the same on every machine.
"""

from __future__ import annotations

import json
import re
import socket
import subprocess
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from cable.guest_agent import NAME, PAUSES
from cable.guest_rig import Command, Done, Guest
from cable.image_rig import QEMU, find_kernel, initramfs
from cable.wire_rig import PATIENCE, Condition, Lines, Wire
from mikas.virtual.build import build_bus, wired
from mikas.virtual.bus import Bus
from mikas.virtual.responder import Responder

SOCKETS = 3
"""USB ports of the box, each with a wire behind it."""
# Requests to a USB device and to an FT232, and bits in their values.
_SET_ADDRESS, _SET_MODEM, _SET_DATA = 0x0005, 0x4001, 0x4004
_DTR, _BREAK = 1, 1 << 14
STILL_CAR = Path(__file__).with_name("still.toml")
CONFIG = Path(__file__).with_name("config.toml")
_NAME_OF = """
while true; do
  for port in /sys/bus/usb-serial/devices/*; do
    name=$(basename $port)
    [ "$(cat $port/../../serial)" = "$1" ] && [ -c /dev/$name ] && echo $name && exit
  done
  sleep 0.1
done 2>/dev/null
"""
"""Waits for the port of the cable with a serial number."""

# -- booting ---------------------------------------------------------------------------------------


def boot(folder: Path, sockets: dict[str, socket.socket]) -> subprocess.Popen[bytes]:
    """Start QEMU. `folder` has the console's log, and is what the guest can write.

    `sockets`: QEMU's ends of `qmp`, `agent` and `wire0` …
    """
    kernel = find_kernel()
    assert kernel
    (image := folder / "kernel").write_bytes(kernel.unpacked())
    (files := folder / "initramfs").write_bytes(initramfs(kernel, folder))
    command = [
        QEMU, "-nodefaults", "-no-reboot", "-display", "none", "-accel", "tcg", "-cpu", "Nehalem",
        "-m", "768", "-kernel", str(image), "-initrd", str(files),
        "-append", "console=ttyS0 quiet panic=-1",
        "-serial", f"file:{folder / 'console'}",
        "-virtfs", "local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap",
        "-virtfs", f"local,path={folder},mount_tag=shared,security_model=none",
        "-mon", "chardev=qmp,mode=control",
        "-device", "virtio-serial-pci",
        "-device", f"virtserialport,chardev=agent,name={NAME}",
        "-device", "qemu-xhci,id=usb",
        "-trace", "usb_serial_handle_control",
    ]  # fmt: skip
    for name, end in sockets.items():
        command += ["-chardev", f"socket,id={name},fd={end.fileno()}"]
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        pass_fds=[end.fileno() for end in sockets.values()],
    )


# -- QMP: pulling and plugging ---------------------------------------------------------------------


class Qmp:
    """QEMU's monitor."""

    def __init__(self, end: socket.socket) -> None:
        end.settimeout(PATIENCE)
        self._file = end.makefile("rw", encoding="utf-8")
        self._events: list[dict[str, Any]] = []
        self._read()  # the greeting
        self("qmp_capabilities")

    def __call__(self, command: str, **arguments: object) -> Any:
        """Execute `command`; return its result."""
        self._file.write(json.dumps({"execute": command, "arguments": arguments}) + "\n")
        self._file.flush()
        while "event" in (reply := self._read()):
            self._events.append(reply)
        assert "return" in reply, reply
        return reply["return"]

    def remove(self, device: str) -> None:
        """Pull `device` out; return when QEMU has forgotten it."""
        self("device_del", id=device)
        while not any(
            event["event"] == "DEVICE_DELETED" and event["data"].get("device") == device
            for event in self._events
        ):
            self._events.append(self._read())
        self._events.clear()

    def _read(self) -> dict[str, Any]:
        line = self._file.readline()
        assert line, "QEMU has ended"
        return json.loads(line)


# -- the box ---------------------------------------------------------------------------------------


@dataclass(slots=True)
class Cable:
    """A cable with a unit behind it, for one test.

    `port`: its USB socket, from 0; `name`: its latest name in the guest.
    """

    box: Box
    port: int
    serial: str
    wire: Wire
    name: str = ""

    def plug(self) -> str:
        """Plug the cable in; return its name in the guest once it has one: `ttyUSB0`."""
        self.box.qmp(
            "device_add", driver="usb-serial", id=f"cable{self.port}", bus="usb.0",
            port=str(self.port + 1), chardev=f"wire{self.port}", serial=self.serial,
        )  # fmt: skip
        self.box.lines.call(self.wire.carry)
        self.name = self.box.run("sh", "-c", _NAME_OF, "sh", self.serial).out.strip()
        return self.name

    def pull(self) -> None:
        self.box.lines.call(self.wire.drop)
        self.box.qmp.remove(f"cable{self.port}")

    def cut_when(self, condition: Condition) -> Callable[[], bytes | None]:
        """Cut as `Wire.cut_when`; the function returned waits for that and pulls the cable.

        A slow guest first takes what had arrived, so that the cut is at the same byte for it; if it
        is too slow for that, None is returned instead of the bytes.
        """
        cut = self.box.lines.call(lambda: self.wire.cut_when(condition))

        def pull_when_cut() -> bytes | None:
            try:
                seen = cut.result(PATIENCE)
            except TimeoutError:
                raise AssertionError(f"not cut; sent: {self.wire.sent.hex(' ')}") from None
            is_taken = self.box.guest.drain(f"/dev/{self.name}")
            self.pull()
            return seen if is_taken else None

        return pull_when_cut


class Box:
    """A running guest with `SOCKETS` USB ports.

    `folder` can be written from both sides; `home`, in it, is where commands run. `pauses`: for how
    many seconds the emulated computer may stop, and the program not notice.
    """

    def __init__(self, folder: Path, pauses: float | None = None) -> None:
        self.home = self.folder = folder
        self._env = {PAUSES: str(pauses)} if pauses else {}
        names = ("qmp", "agent", *(f"wire{number}" for number in range(SOCKETS)))
        pairs = {name: socket.socketpair() for name in names}
        self._ends = {name: pair[0] for name, pair in pairs.items()}
        self._qemu = boot(folder, {name: pair[1] for name, pair in pairs.items()})
        for _, theirs in pairs.values():
            theirs.close()
        self.lines = Lines()
        self._wires: dict[int, Wire] = {}
        self._opened: set[tuple[int, int]] = set()  # by bus and address
        self.complaints = ""
        """What QEMU itself says, a reason why it ended."""
        self._tracer = threading.Thread(target=self._follow_trace)
        self._tracer.start()
        self.guest = Guest(self._ends["agent"])
        self.qmp = Qmp(self._ends["qmp"])
        if not self.guest.wait_until_ready():
            self.close()
            console = (folder / "console").read_text(errors="replace")
            raise AssertionError(f"the guest did not boot: {self.complaints}{console}")

    def cable(
        self,
        port: int = 0,
        *,
        serial: str = "A50285BI",
        unit: Responder | None = None,
        **settings: str,
    ) -> Cable:
        """Return a cable, not plugged in, with `unit` or one by `settings`
        (docs/reference/simulator.md).

        The latter's car is that of `still.toml`, if `settings` name no other.
        """

        def bus_from(start: float) -> Bus:
            if unit is not None:
                return wired(unit, settings)
            return build_bus({"scenario": str(STILL_CAR)} | settings, start=start)

        end = self._ends[f"wire{port}"]
        if old := self._wires.pop(port, None):
            self.lines.remove(old, end)
        wire = self._wires[port] = self.lines.put(end, bus_from)
        return Cable(self, port, serial, wire)

    def restore(self) -> None:
        """Leave the box as it was after the boot."""
        self.guest.kill_all()
        self.unplug_cables()
        for port, wire in self._wires.items():
            self.lines.remove(wire, self._ends[f"wire{port}"])
        self._wires.clear()

    def unplug_cables(self) -> None:
        for device in self.qmp("qom-list", path="/machine/peripheral"):
            if device["name"].startswith("cable"):
                self.qmp.remove(device["name"])

    def start(self, *words: str) -> Command:
        """Start a program of the guest in `home`; `mikas` is this repository's."""
        env = {
            "PATH": "/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin",
            "HOME": str(self.home),
            "TMPDIR": str(self.home),
            "LANG": "C.UTF-8",
            "MIKAS_CONFIG": str(CONFIG),
            **self._env,
        }
        return self.guest.start(words, env)

    def run(self, *words: str) -> Done:
        return self.start(*words).wait()

    def close(self) -> None:
        self._qemu.kill()
        self._qemu.wait()
        self.guest.close()
        self._tracer.join(PATIENCE)
        self.lines.close()
        for end in self._ends.values():
            end.close()
        assert self._qemu.stderr
        self._qemu.stderr.close()

    def was_opened(self, cable: Cable) -> bool:
        """Return whether a program has opened the plugged `cable`: then DTR is set."""
        ports = self.qmp("human-monitor-command", **{"command-line": "info usb"})
        address = re.search(rf"Device (\d+)\.(\d+), .* ID: cable{cable.port}\b", ports)
        assert address, ports
        return (int(address[1]), int(address[2])) in self._opened

    def _follow_trace(self) -> None:
        """Follow what the driver requests of the emulated adapters.

        A break is passed on to the line: QEMU's FT232 receives it and does nothing (D12). It is bit
        14 of the request that also sets parity and stop bits (SIO_SET_DATA, 4).
        """
        assert self._qemu.stderr
        for line in self._qemu.stderr:
            found = re.search(rb"dev (\d+):(\d+) got control (0x\w+), value (0x\w+)", line)
            if found is None:
                if b"usb_serial_" not in line:
                    self.complaints += line.decode(errors="replace")
                continue
            bus, device, request, value = (int(it, 0) for it in found.groups())
            if request == _SET_ADDRESS:
                self._opened.discard((bus, value))
            elif request == _SET_MODEM and value & _DTR:
                self._opened.add((bus, device))
            elif request == _SET_DATA:
                for wire in [it for it in self._wires.values() if it.plugged]:
                    self.lines.call(partial(wire.hold, low=bool(value & _BREAK)))
