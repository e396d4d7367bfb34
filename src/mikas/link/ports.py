"""The serial ports of this computer, the chip of each, and the chip's quirks.

A K-Line adapter is a level shifter on a USB serial chip and looks like any other device with that
chip. "Likely" therefore names the chip: the only such port is used, otherwise the user chooses.
pyserial is imported when ports are listed.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.errors import NoPortGiven
from mikas.i18n import Text

if TYPE_CHECKING:
    from serial.tools.list_ports_common import ListPortInfo

_SYSFS = Path("/sys/bus/usb-serial/devices")  # Linux
_LISTINGS = 5  # attempts; two adapters on one hub come and go at once

_LATENCY = Text(
    "hands over received bytes after up to 16 ms (its latency timer); that is lowered to 1 ms "
    "where the system lets a program do it, on Windows by hand: Device Manager, the port, "
    "Port Settings, Advanced",
    "отдаёт принятое с задержкой до 16 мс (latency timer); где система даёт, программа сама ставит "
    "1 мс, в Windows это делают вручную: Диспетчер устройств, порт, Параметры порта, Дополнительно",
)
_LUMPS = Text(
    "hands over received bytes in lumps of up to 32, so arrival times are coarse",
    "отдаёт принятое порциями до 32 байт, поэтому время прихода грубое",
)
_CLONES = Text(
    "cheap cables with it vary: some have a weak K-Line driver or no echo",
    "дешёвые кабели с ней разные: бывает слабый драйвер K-Line, бывает нет эха",
)
_COUNTERFEIT = Text(
    "many are counterfeit, and the maker's newer Windows drivers refuse those (code 10, or “phased "
    "out”): install an older driver or take another cable",
    "много подделок, а новые драйверы изготовителя для Windows их не пускают (код 10 или «phased "
    "out»): поставьте старый драйвер или возьмите другой кабель",
)
_UNKNOWN = Text(
    "an unknown USB device: possibly an adapter; the connection check shows whether it works",
    "неизвестное устройство USB: возможно, адаптер; работает ли он, покажет проверка связи",
)

_FTDI, _CH340, _PROLIFIC = (_LATENCY,), (_LUMPS, _CLONES), (_COUNTERFEIT,)

# By USB vendor and product; product 0 stands for any other product of the vendor. The most frequent
# chips of K-Line cables come first: FT232R, then CH340.
_CHIPS: dict[tuple[int, int], tuple[str, tuple[Text, ...]]] = {
    (0x0403, 0x6001): ("FT232R", _FTDI),
    (0x0403, 0x6015): ("FT231X", _FTDI),
    (0x0403, 0x6014): ("FT232H", _FTDI),
    (0x0403, 0x6010): ("FT2232", _FTDI),
    (0x0403, 0x6011): ("FT4232", _FTDI),
    (0x0403, 0): ("FTDI", _FTDI),
    (0x1A86, 0x7523): ("CH340", _CH340),
    (0x1A86, 0x7522): ("CH340", _CH340),
    (0x1A86, 0x5523): ("CH341", _CH340),
    (0x4348, 0x5523): ("CH341", _CH340),
    (0x1A86, 0x55D2): ("CH342", ()),
    (0x1A86, 0x55D3): ("CH343", ()),
    (0x1A86, 0x55D4): ("CH9102", ()),
    (0x10C4, 0xEA60): ("CP210x", ()),
    (0x10C4, 0xEA70): ("CP2105", ()),
    (0x10C4, 0xEA71): ("CP2108", ()),
    (0x067B, 0x2303): ("PL2303", _PROLIFIC),
    (0x067B, 0x23A3): ("PL2303GC", ()),
    (0x067B, 0x23B3): ("PL2303GB", ()),
    (0x067B, 0x23C3): ("PL2303GT", ()),
    (0x067B, 0x23D3): ("PL2303GL", ()),
    (0x067B, 0): ("PL2303", _PROLIFIC),
    (0x04D8, 0x00DD): ("MCP2221", ()),
    (0x04D8, 0x00DF): ("MCP2200", ()),
    (0x04E2, 0x1410): ("XR21V1410", ()),
}
_RANK = {chip: rank for rank, chip in enumerate(_CHIPS.values())}


Lister = Callable[[], "Iterable[ListPortInfo]"]


@dataclass(frozen=True, slots=True)
class Port:
    """One serial port of this computer: `url` is the value for `--port` (`/dev/ttyUSB0`, `COM3`).

    `description`: the system's name with the maker, `FT232R USB UART (FTDI)`; never empty. `chip`:
    its USB serial chip, empty if unknown, with its `quirks`. `likely`: it may be an adapter, for it
    is a USB serial chip, not Bluetooth, not built in. `latency_ms`: the chip's latency timer, where
    the system shows it (Linux, FTDI).
    """

    url: str
    description: str
    chip: str = ""
    quirks: tuple[Text, ...] = ()
    likely: bool = False
    vid: int | None = None
    pid: int | None = None
    serial_number: str | None = None
    latency_ms: int | None = None
    location: str | None = None


def system_ports() -> Iterable[ListPortInfo]:
    """List the ports; retry if pyserial 3.5 fails on an adapter that comes or goes just now."""
    from serial.tools.list_ports import comports

    for _ in range(_LISTINGS - 1):
        with suppress(OSError, TypeError, ValueError):
            return list(comports())
    return list(comports())


def find_ports(lister: Lister = system_ports, sysfs: Path = _SYSFS) -> list[Port]:
    """Return all serial ports, the most likely adapter first."""
    return sorted((_port(each, sysfs) for each in lister()), key=_order)


def choose_port(lister: Lister = system_ports) -> str:
    """Return the URL of the only likely port; `NoPortGiven` if it is not the only one."""
    ports = find_ports(lister)
    likely = [port.url for port in ports if port.likely]
    if not likely:
        raise NoPortGiven(found=listed(ports))
    if len(likely) > 1:
        raise NoPortGiven(found=listed(ports), example=likely[0])
    return likely[0]


def named(address: str, ports: Iterable[Port]) -> Port | None:
    """Return the port with this name; `address` may be a link to it (`/dev/serial/by-id/…`)."""
    real = _real(address)
    return next((port for port in ports if address == port.url or real == _real(port.url)), None)


def _real(address: str) -> str:
    return os.path.normcase(os.path.realpath(address))


def listed(ports: Iterable[Port]) -> Text:
    """`/dev/ttyUSB0 (FT232R), /dev/ttyS0`, for a message; "none" if there are none."""
    names = [f"{port.url} ({port.chip})" if port.chip else port.url for port in ports]
    return Text(", ".join(names) or "none", ", ".join(names) or "ни одного")


def _port(it: ListPortInfo, sysfs: Path) -> Port:
    chip, quirks = _chip(it)
    return Port(
        url=it.device,
        description=_description(it),
        chip=chip,
        quirks=quirks,
        likely=bool(chip),
        vid=it.vid,
        pid=it.pid,
        serial_number=_serial_number(it),
        latency_ms=_latency(it.device, sysfs),
        location=it.location or None,
    )


def _serial_number(it: ListPortInfo) -> str | None:
    """Return the adapter's own number: Windows makes one up, with an `&`, for each USB socket."""
    number = it.serial_number or ""
    return None if "&" in number else number or None


def _chip(it: ListPortInfo) -> tuple[str, tuple[Text, ...]]:
    if it.vid is None:
        return "", ()
    return _CHIPS.get((it.vid, it.pid or 0)) or _CHIPS.get((it.vid, 0)) or ("", (_UNKNOWN,))


def _description(it: ListPortInfo) -> str:
    text = (it.description or "").removesuffix(f"({it.device})").strip()  # Windows adds its name
    if text in {"", "n/a"}:
        text = it.device
    maker = it.manufacturer or ""
    return f"{text} ({maker})" if maker and maker.lower() not in text.lower() else text


def _latency(device: str, sysfs: Path) -> int | None:
    try:
        return int((sysfs / Path(device).name / "latency_timer").read_text("ascii"))
    except (OSError, ValueError):
        return None  # not Linux, or a chip without one


def _order(port: Port) -> tuple[bool, int, list[tuple[int, str]]]:
    rank = _RANK.get((port.chip, port.quirks), len(_RANK)) - (port.vid is not None)
    pieces = re.findall(r"\d+|\D+", port.url)  # COM10 follows COM9
    return not port.likely, rank, [(int(it), "") if it.isdigit() else (0, it) for it in pieces]


VIRTUAL = Text("virtual ECU", "виртуальный блок")


def described(description: str) -> Text:
    """Return a link's or a recording's `description`, an English string, in both languages."""
    return VIRTUAL if description == VIRTUAL.en else Text(description, description)
