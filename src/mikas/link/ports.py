"""The serial ports of this computer, with the chip of each.

A K-Line adapter looks like any other device with its USB serial chip. "Likely" therefore means a
known chip: the only such port is used, otherwise the user chooses. pyserial is imported when ports
are listed.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from mikas.cleaning import clean_line
from mikas.errors import NoPortGiven
from mikas.i18n import Text
from mikas.link.chips import CHIPS, chip_of
from mikas.link.holders import adapter_without_port

if TYPE_CHECKING:
    from serial.tools.list_ports_common import ListPortInfo

_SYSFS = Path("/sys/bus/usb-serial/devices")  # Linux
_LONGEST = 300  # characters; USB has at most 126 in each text of a device
_LISTINGS = 5  # attempts; two adapters on one hub come and go at once
_RANK = {chip: rank for rank, (chip, _) in enumerate(CHIPS.values())}


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
    """The address for `connect`."""
    description: str
    chip: str = ""
    """The USB serial chip; empty: unknown."""
    quirks: tuple[Text, ...] = ()
    """The facts known of that chip."""
    likely: bool = False
    vid: int | None = None
    """The USB vendor."""
    pid: int | None = None
    """The USB product."""
    serial_number: str | None = None
    """The adapter's serial number."""
    latency_ms: int | None = None
    location: str | None = None
    """The USB socket."""


def system_ports() -> Iterable[ListPortInfo]:
    """List the ports; retry if pyserial 3.5 fails on an adapter that comes or goes just now."""
    from serial.tools.list_ports import comports

    for _ in range(_LISTINGS - 1):
        with suppress(OSError, TypeError, ValueError):
            return list(comports())
    return list(comports())


def find_ports(lister: Lister = system_ports, sysfs: Path = _SYSFS) -> list[Port]:
    """Return all serial ports, the most likely adapter first."""
    return sorted((_port(each, sysfs) for each in lister()), key=by_likelihood)


def choose_port(lister: Lister = system_ports) -> str:
    """Return the URL of the only likely port of this computer; raises as `only_likely`."""
    return only_likely(find_ports(lister))


def only_likely(ports: Sequence[Port]) -> str:
    """Return the URL of the only likely one of `ports`.

    Raises `NoPortGiven` if it is not the only one, or the error of an adapter without a port.
    """
    likely = [port.url for port in ports if port.likely]
    if not likely:
        raise adapter_without_port() or NoPortGiven(found=listed(ports))
    if len(likely) > 1:
        raise NoPortGiven(found=listed(ports), example=likely[0])
    return likely[0]


def named(address: str, ports: Iterable[Port]) -> Port | None:
    """Return the port with this name; `address` may be a link to it (`/dev/serial/by-id/…`)."""
    real = real_name(address)
    return next((it for it in ports if address == it.url or real == real_name(it.url)), None)


def real_name(address: str) -> str:
    """Return the name of a serial port of which `address` may be a link, or another spelling."""
    with suppress(OSError):  # of a folder that was removed
        address = os.path.realpath(address)
    return os.path.normcase(address)


def listed(ports: Iterable[Port]) -> Text:
    """`/dev/ttyUSB0 (FT232R), /dev/ttyS0`, for a message; "none" if there are none."""
    names = [f"{port.url} ({port.chip})" if port.chip else port.url for port in ports]
    return Text(", ".join(names) or "none", ", ".join(names) or "ни одного")


def _port(it: ListPortInfo, sysfs: Path) -> Port:
    chip, quirks = chip_of(it.vid, it.pid)
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
        location=clean_line(it.location or "", _LONGEST) or None,
    )


def _serial_number(it: ListPortInfo) -> str | None:
    """Return the adapter's own number: Windows makes one up, with an `&`, for each USB socket."""
    number = clean_line(it.serial_number or "", _LONGEST)
    return None if "&" in number else number or None


def _description(it: ListPortInfo) -> str:
    text = (it.description or "").removesuffix(f"({it.device})").strip()  # Windows adds its name
    if text in {"", "n/a"}:
        text = it.device
    maker = it.manufacturer or ""
    whole = f"{text} ({maker})" if maker and maker.lower() not in text.lower() else text
    return clean_line(whole, _LONGEST)


def _latency(device: str, sysfs: Path) -> int | None:
    try:
        return int((sysfs / Path(device).name / "latency_timer").read_text("ascii"))
    except (OSError, ValueError):
        return None  # not Linux, or a chip without one


def by_likelihood(port: Port) -> tuple[bool, int, list[tuple[int, str]]]:
    """Return the key by which the most likely adapter is the first one."""
    rank = _RANK.get(port.chip, len(_RANK)) - (port.vid is not None)
    pieces = re.findall(r"\d+|\D+", port.url)  # COM10 follows COM9
    return not port.likely, rank, [(int(it), "") if it.isdigit() else (0, it) for it in pieces]


VIRTUAL = Text("virtual ECU", "виртуальный блок")


def described(description: str) -> Text:
    """Return a link's or a recording's `description`, an English string, in both languages."""
    return VIRTUAL if description == VIRTUAL.en else Text(description, description)
