"""The udev rules, run on made-up devices by a small interpreter of udev(7)'s language.

Where this computer's `udevadm` can verify rules (systemd 254), it does so too.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

import pytest

from mikas.link.chips import known_products
from mikas.link.udev_rules import FILE, rules

ITEM = re.compile(r'([A-Z]+)(?:\{([A-Za-z_]+)\})?(==|!=|\+=|=)"([^"]*)"')


@dataclass
class Device:
    """A device of an event. `attributes`: its own and then its parents', one mapping each."""

    subsystem: str
    kind: str = ""
    driver: str = ""
    attributes: list[dict[str, str]] = field(default_factory=list)
    env: dict[str, str] = field(default_factory=dict)
    tags: set[str] = field(default_factory=set)
    action: str = "add"

    def __post_init__(self) -> None:
        self.env["DEVTYPE"] = self.kind

    def values(self, key: str, name: str) -> list[str]:
        """What a match of `key` is compared with."""
        match key:
            case "ACTION":
                return [self.action]
            case "SUBSYSTEM":
                return [self.subsystem]
            case "SUBSYSTEMS":
                return [self.subsystem, *(["usb"] if self.attributes[1:] else [])]
            case "DRIVER":
                return [self.driver]
            case "ENV":
                return [self.env.get(name, "")]
        raise AssertionError(f"unknown match {key}")


def parsed(text: str) -> list[list[tuple[str, str, str, str]]]:
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    for line in lines:
        assert re.fullmatch(rf"{ITEM.pattern}(, {ITEM.pattern})*", line), line
    return [ITEM.findall(line) for line in lines]


def apply(text: str, device: Device) -> Device:
    lines, at = parsed(text), 0
    while at < len(lines):
        line, at = lines[at], at + 1
        matches = [item for item in line if item[2] in ("==", "!=")]
        ofparent = [item for item in matches if item[0] == "ATTRS"]
        if not all(_holds(device, item) for item in matches if item not in ofparent):
            continue
        if ofparent and not any(
            all(each.get(name) == value for _, name, _, value in ofparent)
            for each in device.attributes
        ):
            continue
        for key, name, operator, value in line:
            match key, operator:
                case "GOTO", "=":
                    at = next(
                        n for n, other in enumerate(lines) if ("LABEL", "", "=", value) in other
                    )
                case "ENV", "=":
                    device.env[name] = re.sub(
                        r"\$env\{(\w+)\}", lambda it: device.env.get(it[1], ""), value
                    )
                case "TAG", "+=":
                    device.tags.add(value)
                case "ATTR", "=":
                    device.attributes[0][name] = value
                case "LABEL", "=":
                    pass
                case _, "==" | "!=":
                    pass
                case _:
                    raise AssertionError((key, operator))
    return device


def _holds(device: Device, item: tuple[str, str, str, str]) -> bool:
    key, name, operator, pattern = item
    same = any(
        fnmatchcase(value, one) for value in device.values(key, name) for one in pattern.split("|")
    )
    return same == (operator == "==")


def ids(vendor: int, product: int) -> dict[str, str]:
    return {"idVendor": f"{vendor:04x}", "idProduct": f"{product:04x}"}


def usb(vendor: int, product: int, **settings: str) -> Device:
    env = {"PRODUCT": f"{vendor:x}/{product:x}/264"}
    return Device("usb", "usb_device", "usb", [ids(vendor, product)], env, **settings)


def tty(vendor: int, product: int) -> Device:
    return Device("tty", attributes=[{}, ids(vendor, product), ids(0x1D6B, 2)])


@pytest.mark.parametrize(("vendor", "product"), known_products(), ids=lambda it: f"{it:04x}")
def test_every_known_adapter_is_its_users_alone(vendor, product):
    port = apply(rules(), tty(vendor, product))
    assert port.tags == {"uaccess"}
    assert port.env["ID_MM_PORT_IGNORE"] == port.env["ID_MM_DEVICE_IGNORE"] == "1"
    device = apply(rules(), usb(vendor, product))
    assert device.env["ID_MM_DEVICE_IGNORE"] == "1"
    assert not device.tags
    as_brltty = f'ENV{{PRODUCT}}=="{vendor:x}/{product:x}/*", ENV{{BRLTTY_BRAILLE_DRIVER}}="bm"\n'
    assert "BRLTTY_BRAILLE_DRIVER" in apply(as_brltty, usb(vendor, product)).env
    assert "BRLTTY_BRAILLE_DRIVER" not in apply(as_brltty, device).env


@pytest.mark.parametrize(
    "device",
    [
        tty(0x046D, 0xC52B),  # a mouse's receiver
        tty(0x0403, 0xDE58),  # a braille display with FTDI's number
        Device("tty", attributes=[{}]),
        Device("usb", "usb_interface", "ftdi_sio", [{}, ids(0x0403, 0x6001)]),
        Device("net", attributes=[{}, ids(0x0403, 0x6001)]),
        usb(0x0403, 0x6001, action="remove"),
        usb(0x067B, 0x2517),  # a hub of the maker of PL2303
    ],
    ids=lambda it: f"{it.subsystem} {it.action}",
)
def test_other_devices_are_left_alone(device):
    before = dict(device.env)
    assert apply(rules(), device).env == before
    assert not device.tags


@pytest.mark.parametrize("action", ["add", "bind", "change"])
def test_the_ftdi_driver_gets_a_latency_of_1_ms_and_no_other(action):
    for driver, timer in (("ftdi_sio", "1"), ("ch341-uart", None)):
        port = Device("usb-serial", "", driver, [{}, {}, ids(0x0403, 0x6001)], action=action)
        assert apply(rules(), port).attributes[0].get("latency_timer") == timer


def test_the_file_is_read_before_the_rules_that_it_prepares():
    others = ["73-seat-late.rules", "77-mm-qdl-device-blacklist.rules", "80-mm-candidate.rules",
              "85-brltty.rules", "90-brltty-device.rules"]  # fmt: skip
    assert min([FILE.name, *others]) == FILE.name
    assert FILE.parent.name == "rules.d"


def test_each_label_is_there_once_and_used():
    items = [item for line in parsed(rules()) for item in line]
    labels = [value for key, *_, value in items if key == "LABEL"]
    assert sorted(labels) == sorted({value for key, *_, value in items if key == "GOTO"})


def test_udev_itself_accepts_them(tmp_path):
    file = tmp_path / FILE.name
    file.write_text(rules())
    udevadm = shutil.which("udevadm")
    if udevadm and _runs(udevadm, "verify", "--help"):
        assert _runs(udevadm, "verify", "--no-style", str(file))


def _runs(*words: str) -> bool:
    return subprocess.run(words, capture_output=True, check=False).returncode == 0
