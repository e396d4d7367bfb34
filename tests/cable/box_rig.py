"""The box: a guest under QEMU with USB ports, in which the program runs as on an owner's laptop.

    Box ── QEMU ─┬─ Debian's kernel: xhci, usbserial, ftdi_sio … ── /dev/ttyUSB0 ── mikas
     │           └─ usb-redir ── a socket ─┐
     └─ Lines ── Wire: the virtual unit ── a chip of `usb`

Software emulation (tcg) everywhere, so that the box is the same on every machine.
"""

from __future__ import annotations

import socket
import subprocess
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cable.guest_agent import NAME, PAUSES
from cable.guest_rig import Command, Done, Guest
from cable.image_rig import QEMU, find_kernel, initramfs
from mikas.virtual.build import build_bus, wired
from mikas.virtual.bus import Bus
from mikas.virtual.responder import Responder
from usb.chips.device import Device
from usb.chips.named import plugged
from usb.transports.redir_rig import UsbRedir
from usb.wire_rig import PATIENCE, Condition, Lines, Wire

SOCKETS = 3
"""USB ports of the box, unless more are asked for."""
SMALL = ("-accel", "tcg", "-m", "768")
STILL_CAR = Path(__file__).with_name("still.toml")
CONFIG = Path(__file__).with_name("config.toml")
_PLENTY = 1 << 16
"""Characters that a chip keeps in the box. A real one keeps 256, a quarter of a second: on a busy
computer the guest pauses longer, and a CH340 does not report what it lost.
"""
_LOOKS = 200  # at a chip that still holds bytes, each after the guest has taken its own
_EMPTY_LOOKS = 3  # in a row: bytes may be on their way through QEMU and the kernel

# -- booting ---------------------------------------------------------------------------------------


def boot(
    folder: Path, sockets: dict[str, socket.socket], hardware: tuple[str, ...]
) -> subprocess.Popen[bytes]:
    """Start QEMU. `folder` has the console's log, and is what the guest can write.

    `sockets`: QEMU's ends of `agent`, and of `usb0` … for each USB port.
    """
    kernel = find_kernel()
    assert kernel
    (image := folder / "kernel").write_bytes(kernel.unpacked())
    (files := folder / "initramfs").write_bytes(initramfs(kernel, folder))
    command = [
        QEMU, "-nodefaults", "-no-reboot", "-display", "none", "-cpu", "Nehalem", *hardware,
        "-kernel", str(image), "-initrd", str(files),
        "-append", "console=ttyS0 quiet panic=-1 no_timer_check",  # emulation is too slow for it
        "-serial", f"file:{folder / 'console'}",
        "-virtfs", "local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap",
        "-virtfs", f"local,path={folder},mount_tag=shared,security_model=none",
        "-device", "virtio-serial-pci",
        "-device", f"virtserialport,chardev=agent,name={NAME}",
        "-device", f"qemu-xhci,id=usb,p2={max(4, len(sockets) - 1)}",
    ]  # fmt: skip
    for name, end in sockets.items():
        command += ["-chardev", f"socket,id={name},fd={end.fileno()}"]
    for number in range(len(sockets) - 1):
        command += ["-device", f"usb-redir,chardev=usb{number},bus=usb.0,port={number + 1}"]
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        pass_fds=[end.fileno() for end in sockets.values()],
    )


# -- the box ---------------------------------------------------------------------------------------


@dataclass(slots=True)
class Cable:
    """A cable with a unit behind it, for one test.

    `port`: its USB socket, from 0; `kind`: the chip's name (`usb.chips.named`); `name`: its latest
    name in the guest; `chip`: the model that is plugged in, a new one each time.
    """

    box: Box
    port: int
    kind: str
    serial: str
    wire: Wire
    name: str = ""
    chip: Device | None = None

    def plug(self) -> str:
        """Plug the cable in; return its name in the guest once it has one: `ttyUSB0`."""
        self.put_in()
        self.name = self.box.guest.port_of(self.port + 1)
        return self.name

    def put_in(self) -> None:
        """Plug the cable in, whether or not it gets a name."""
        chip = self.chip = plugged(self.kind, self.wire, self.serial)
        for uart in chip.uarts:
            uart.buffer = _PLENTY

        def plug() -> None:
            self.wire.carry(chip.uart)
            self.box.sockets[self.port].plug(chip)

        self.box.lines.call(plug)

    def pull(self) -> None:
        """Pull the cable out; return when the guest has noticed."""
        self.box.lines.call(self.wire.drop)
        self.box.empty(self.port)

    @property
    def was_opened(self) -> bool:
        """Whether a program has opened the port since it was plugged in: then DTR was set."""
        return self.chip is not None and any("dtr=1" in it for it in self.chip.uart.log)

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
            is_taken = self._is_taken()
            self.pull()
            return seen if is_taken else None

        return pull_when_cut

    def _is_taken(self) -> bool:
        """Wait until the chip, then the guest, hold nothing for the program; False: it is slow."""
        chip = self.chip
        assert chip is not None
        empty = 0
        for _ in range(_LOOKS):
            is_empty = self.box.lines.call(lambda: not chip.backlog)
            if not self.box.guest.drain(f"/dev/{self.name}"):
                return False
            empty = empty + 1 if is_empty else 0
            if empty == _EMPTY_LOOKS:
                return True
        return False


class Box:
    """A running guest with USB ports, each with a wire behind it.

    `folder` can be written from both sides; `home`, in it, is where commands run. `pauses`: for how
    many seconds the emulated computer may stop, and the program not notice. `hardware`: QEMU's
    options for memory and processors.
    """

    def __init__(
        self,
        folder: Path,
        pauses: float | None = None,
        hardware: tuple[str, ...] = SMALL,
        sockets: int = SOCKETS,
    ) -> None:
        self.home = self.folder = folder
        self._env = {PAUSES: str(pauses)} if pauses else {}
        names = ("agent", *(f"usb{number}" for number in range(sockets)))
        pairs = {name: socket.socketpair() for name in names}
        self._ends = {name: pair[0] for name, pair in pairs.items()}
        self._qemu = boot(folder, {name: pair[1] for name, pair in pairs.items()}, hardware)
        for _, theirs in pairs.values():
            theirs.close()
        self.lines = Lines()
        self.sockets = [self._redirected(name) for name in names[1:]]
        self._wires: dict[int, Wire] = {}
        self.complaints = ""
        """What QEMU itself says, a reason why it ended."""
        self._listener = threading.Thread(target=self._listen)
        self._listener.start()
        self.guest = Guest(self._ends["agent"])
        if not self.guest.wait_until_ready():
            self.close()
            console = (folder / "console").read_text(errors="replace")
            raise AssertionError(f"the guest did not boot: {self.complaints}{console}")

    def _redirected(self, name: str) -> UsbRedir:
        end = self._ends[name]
        _, redir = self.lines.run(self.lines.loop.create_connection(UsbRedir, sock=end))
        return redir

    def cable(
        self,
        port: int = 0,
        *,
        chip: str = "FT232R",
        serial: str | None = None,
        unit: Responder | None = None,
        **settings: str,
    ) -> Cable:
        """Return a cable, not plugged in, with `unit` or one by `settings`
        (docs/reference/simulator.md).

        The latter's car is that of `still.toml`, if `settings` name no other. An FT232R has a
        `serial` number unless another or none ("") is given; the other chips have none.
        """

        def bus_from(start: float) -> Bus:
            if unit is not None:
                return wired(unit, settings)
            return build_bus({"scenario": str(STILL_CAR)} | settings, start=start)

        if old := self._wires.pop(port, None):
            self.lines.remove(old)
        wire = self._wires[port] = self.lines.put(bus_from)
        if serial is None:
            serial = "A50285BI" if chip == "FT232R" else ""
        return Cable(self, port, chip, serial, wire)

    def restore(self) -> None:
        """Leave the box as it was after the boot."""
        self.guest.kill_all()
        self.unplug_cables()
        for wire in self._wires.values():
            self.lines.remove(wire)
        self._wires.clear()

    def unplug_cables(self) -> None:
        self.empty(*range(len(self.sockets)))

    def empty(self, *ports: int) -> None:
        """Pull out what is in these USB sockets; return when the guest has noticed."""
        for port in ports:
            self.lines.run(self.sockets[port].pull())
        self.guest.wait_until_gone([port + 1 for port in ports])

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
        self._listener.join(PATIENCE)
        for each in self.sockets:
            self.lines.call(each.close)
        self.lines.close()
        self._ends["agent"].close()
        assert self._qemu.stderr
        self._qemu.stderr.close()

    def _listen(self) -> None:
        assert self._qemu.stderr
        for line in self._qemu.stderr:
            self.complaints += line.decode(errors="replace")
