"""The udev rules for adapters on Linux: `70-mikas.rules`, made of the table of chips.

- ModemManager ignores the adapter (`ID_MM_DEVICE_IGNORE`, `ID_MM_PORT_IGNORE`; its rules are 77 and
  80).
- brltty leaves it to its driver. It has no property for that, but all its rules (85 or 90) compare
  `PRODUCT`, the kernel's `1a86/7523/264`, as no rule of systemd or ModemManager does: a word is put
  before it.
- The user at the computer may open it, without the group `dialout`: the tag `uaccess`, for which
  73-seat-late.rules looks. Hence the number 70.
- The FTDI driver hands bytes over after 1 ms instead of 16.

A chip for "any other product" of a vendor has no rule: the vendors make hubs and phones too.
"""

from __future__ import annotations

from pathlib import Path

from mikas.link.chips import known_products

FILE = Path("/etc/udev/rules.d/70-mikas.rules")
PACKAGED = Path("/usr/lib/udev/rules.d") / FILE.name
"""Those of the Debian package; udev prefers the other ones."""

_HEAD = """\
# K-Line adapters, for mikas: of its Debian package, or of `mikas ports --install-rules`.
# Unplug the adapter and plug it in again; to undo all of this, remove the package or this file.
# A braille display with one of these chips is then no longer started by brltty.

ACTION=="remove", GOTO="mikas_end"
SUBSYSTEM=="usb", ENV{DEVTYPE}=="usb_device", GOTO="mikas_chips"
SUBSYSTEM=="usb-serial|tty", SUBSYSTEMS=="usb", GOTO="mikas_chips"
GOTO="mikas_end"

LABEL="mikas_chips"
"""
_TAIL = """
GOTO="mikas_end"

LABEL="mikas_adapter"

# ModemManager does not look for a modem here.
ENV{ID_MM_DEVICE_IGNORE}="1"
SUBSYSTEM=="tty", ENV{ID_MM_PORT_IGNORE}="1"

# brltty does not take it for a braille display: its rules compare PRODUCT.
SUBSYSTEM=="usb", ENV{PRODUCT}="mikas/$env{PRODUCT}"

# The user at this computer may open the port.
SUBSYSTEM=="tty", TAG+="uaccess"

# Received bytes are handed over after 1 ms instead of 16.
SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{latency_timer}="1"

LABEL="mikas_end"
"""


def rules() -> str:
    """Return the text of the file."""
    by_chip: dict[str, list[str]] = {}
    for (vendor, product), chip in known_products().items():
        by_chip.setdefault(chip, [f"# {chip}"]).append(
            f'ATTRS{{idVendor}}=="{vendor:04x}", ATTRS{{idProduct}}=="{product:04x}", '
            'GOTO="mikas_adapter"'
        )
    lines = [line for chip in by_chip.values() for line in chip]
    return _HEAD + "\n".join(lines) + _TAIL
