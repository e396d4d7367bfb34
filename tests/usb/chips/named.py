"""All models by name: `plugged("CH340", line)`."""

from __future__ import annotations

from usb.chips.cdc_acm import KINDS as CDC_ACM
from usb.chips.cdc_acm import CdcAcm
from usb.chips.ch34x import KINDS as CH34X
from usb.chips.ch34x import Ch34x
from usb.chips.cp210x import KINDS as CP210X
from usb.chips.cp210x import Cp210x
from usb.chips.device import Device
from usb.chips.ftdi import KINDS as FTDI
from usb.chips.ftdi import Ftdi
from usb.chips.pl2303 import KINDS as PL2303
from usb.chips.pl2303 import Pl2303
from usb.chips.uart import Line, Settings

NAMES = (*FTDI, *CH34X, *CP210X, *PL2303, *CDC_ACM)
FOUR = ("FT232R", "CH340", "CP2102", "PL2303HX")
"""The chips of nearly all K-Line cables, one of each kind."""


class Nowhere:
    """The line of a port that no wire is connected to."""

    def send(self, data: bytes, settings: Settings) -> None:
        """Lose `data`."""

    def hold(self, low: bool) -> None:
        """Do nothing."""


def plugged(name: str, line: Line, serial: str = "") -> Device:
    """Return a new chip, as after plugging in; `line` is that of its first port."""
    if name in FTDI:
        kind = FTDI[name]
        return Ftdi(kind, [line, *_nowhere(kind.ports)], serial)
    if name in CP210X:
        kind = CP210X[name]
        return Cp210x(kind, [line, *_nowhere(kind.ports)], serial)
    for kinds, model in ((CH34X, Ch34x), (PL2303, Pl2303), (CDC_ACM, CdcAcm)):
        if name in kinds:
            return model(kinds[name], line, serial)
    raise KeyError(name)


def driver_of(name: str) -> str:
    """Return the driver of Linux for a chip."""
    drivers = (
        (FTDI, "ftdi_sio"), (CH34X, "ch341"), (CP210X, "cp210x"), (PL2303, "pl2303"),
        (CDC_ACM, "cdc_acm"),
    )  # fmt: skip
    return next(driver for kinds, driver in drivers if name in kinds)


def _nowhere(ports: int) -> list[Line]:
    return [Nowhere() for _ in range(ports - 1)]
