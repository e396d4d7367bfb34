"""The program that has a serial port open, or has taken its adapter from the system (Linux).

Two system programs are known for it. ModemManager opens each new port and looks for a modem there.
brltty takes adapters with chips that are also in braille displays (CH340, CP210x): through usbfs,
so the kernel's driver lets go and the port disappears.

`/proc` and `/sys` show; elsewhere nothing is found. The files that another user's program has open
are visible to root only, so a system program that is merely running is named as the likely one.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from mikas.cleaning import clean_line
from mikas.errors import (
    AdapterTaken,
    AdapterWithoutDriver,
    PortBusy,
    PortNotFound,
    PortProbed,
    TakenByBrltty,
)
from mikas.i18n import Text
from mikas.link.chips import known_products

PROC = Path("/proc")
USB_DEVICES = Path("/sys/bus/usb/devices")
_CHIPS = known_products()
_MODEM_MANAGER, _BRLTTY = "ModemManager", "brltty"
_PTY_MASTERS = frozenset({"/dev/ptmx", "/dev/pts/ptmx"})  # of a pty, `mikas sim` has both ends
_UNKNOWN = Text("another program", "другой программой")
_CLOSE_IT = Text("Close it, then try again.", "Закройте её и повторите.")
_ANOTHER_CABLE = Text(
    "Linux refuses copies of this chip of a version that it does not know. Unplug it and plug it "
    "in again; if it stays so, take a cable with an FT232R, CH340 or CP2102.",
    "Linux не пускает подделки этой микросхемы незнакомой версии. Отключите адаптер и подключите "
    "снова; если не поможет, возьмите кабель на FT232R, CH340 или CP2102.",
)


@dataclass(frozen=True, slots=True)
class Holder:
    """A program. `certain`: the file was seen open; else only that the program runs."""

    program: str
    pid: int
    certain: bool = True

    @property
    def text(self) -> Text:
        """The program after "in use by", "занят"."""
        if not self.certain:
            return Text(
                f"another program, likely {self.program}",
                f"другой программой, скорее всего {self.program}",
            )
        return Text(
            f"{self.program} (process {self.pid})",
            f"программой {self.program} (процесс {self.pid})",
        )


def port_busy(url: str, address: str, proc: Path = PROC) -> PortBusy:
    """Return the error of the busy port `address`, with its holder if one is found."""
    return _busy(url, _holder(address, proc, hidden=_MODEM_MANAGER))


def shared(url: str, address: str, proc: Path = PROC) -> PortBusy | None:
    """Return the error of a port that another program has open beside this one; None: it has not.

    Exclusive access does not keep programs of root off.
    """
    holder = _holder(address, proc)
    return None if holder is None else _busy(url, holder)


def _busy(url: str, holder: Holder | None) -> PortBusy:
    if holder is None:
        return PortBusy(url=url)
    if holder.program == _MODEM_MANAGER:
        return PortProbed(url=url, holder=holder.text)
    return PortBusy(url=url, holder=holder.text, advice=_CLOSE_IT)


def adapter_without_port(
    url: str = "",
    kind: tuple[int, int] | None = None,
    *,
    usb: Path = USB_DEVICES,
    proc: Path = PROC,
) -> PortNotFound | None:
    """Return the error of the first adapter on USB, of this `kind`, that has no serial port."""
    for device, ids in _adapters(usb):
        if kind not in (None, ids):
            continue
        interfaces = list(device.glob(f"{device.name}:*"))
        drivers = {Path(_target(each / "driver")).name for each in interfaces}
        if drivers - {"", "usbfs"}:
            continue  # a driver of the kernel makes a port
        node = f"/dev/bus/usb/{_number(device, 'busnum'):03}/{_number(device, 'devnum'):03}"
        holder = _holder(node, proc) or _running(_BRLTTY, proc)
        if holder is not None and holder.program == _BRLTTY:
            return TakenByBrltty(url=url, chip=_CHIPS[ids])
        if "usbfs" in drivers:
            return AdapterTaken(
                url=url, chip=_CHIPS[ids], holder=_UNKNOWN if holder is None else holder.text
            )
        chip = _CHIPS[ids]
        if chip.startswith("PL2303"):
            return AdapterWithoutDriver(url=url, chip=chip, advice=_ANOTHER_CABLE)
        return AdapterWithoutDriver(url=url, chip=chip)
    return None


def _adapters(usb: Path) -> Iterator[tuple[Path, tuple[int, int]]]:
    """Yield the USB devices that are adapters, with vendor and product."""
    with suppress(OSError):
        for device in sorted(usb.iterdir()):
            with suppress(OSError, ValueError):
                ids = _hex(device / "idVendor"), _hex(device / "idProduct")
                if ids in _CHIPS:
                    yield device, ids


def _holder(file: str, proc: Path, hidden: str = "") -> Holder | None:
    """Return another program that has `file` open, else `hidden` if it runs and hides its files."""
    real, suspected = os.path.realpath(file), None
    other_end = _PTY_MASTERS if real.startswith("/dev/pts/") else frozenset[str]()
    for folder, program in _programs(proc):
        try:
            files = {_target(each) for each in (folder / "fd").iterdir()}
            if real in files and not files & other_end:
                return Holder(program, int(folder.name))
        except PermissionError:
            if program == hidden:
                suspected = Holder(program, int(folder.name), certain=False)
        except OSError:
            continue  # it has ended
    return suspected


def _running(program: str, proc: Path) -> Holder | None:
    found = (int(folder.name) for folder, name in _programs(proc) if name == program)
    return next((Holder(program, pid, certain=False) for pid in found), None)


def _programs(proc: Path) -> Iterator[tuple[Path, str]]:
    """Yield the folder and the name of every other process."""
    with suppress(OSError):
        for folder in sorted(proc.iterdir()):
            if folder.name.isdecimal() and int(folder.name) != os.getpid():
                with suppress(OSError):
                    name = (folder / "comm").read_bytes().decode("utf-8", "replace")
                    yield folder, clean_line(name.strip())


def _target(link: Path) -> str:
    try:
        return str(link.readlink())
    except OSError:
        return ""


def _hex(file: Path) -> int:
    return int(file.read_text("ascii"), 16)


def _number(device: Path, name: str) -> int:
    try:
        return int((device / name).read_text("ascii"))
    except (OSError, ValueError):
        return 0
