"""Who has the port: from made-up trees of /proc and /sys, shaped as Linux shows them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from mikas.errors import AdapterTaken, AdapterWithoutDriver, PortBusy, PortProbed, TakenByBrltty
from mikas.link.holders import adapter_without_port, port_busy, shared

USB_NODE = "/dev/bus/usb/001/007"


class Computer:
    """A made-up Linux under `folder`."""

    def __init__(self, folder: Path) -> None:
        self.proc, self.usb = folder / "proc", folder / "usb"
        self.proc.mkdir()
        self.usb.mkdir()
        (self.proc / "meminfo").touch()

    def run(self, pid: int, program: str, *files: str) -> None:
        fd = self.proc / str(pid) / "fd"
        fd.mkdir(parents=True)
        (fd.parent / "comm").write_text(f"{program}\n")
        for number, file in enumerate(("/dev/null", *files)):
            (fd / str(number)).symlink_to(file)

    def plug(self, ids: str, *, driver: str = "", port: str = "") -> None:
        device = self.usb / "1-4"
        interface = device / "1-4:1.0"
        interface.mkdir(parents=True)
        vendor, product = ids.split(":")
        for name, text in (
            ("idVendor", vendor), ("idProduct", product), ("busnum", "1"), ("devnum", "7"),
        ):  # fmt: skip
            (device / name).write_text(f"{text}\n")
        if driver:
            (interface / "driver").symlink_to(f"../../../bus/usb/drivers/{driver}")
        if port:
            (interface / port).mkdir()

    def without_port(self):
        return adapter_without_port("/dev/ttyUSB0", usb=self.usb, proc=self.proc)


@pytest.fixture
def computer(tmp_path):
    return Computer(tmp_path)


@pytest.fixture
def hidden(monkeypatch):
    """Names of programs of root, whose open files a user does not see."""
    names: set[str] = set()
    listed = Path.iterdir

    def iterdir(folder: Path):
        if folder.name == "fd" and (folder.parent / "comm").read_text().strip() in names:
            raise PermissionError(13, "Permission denied")
        return listed(folder)

    monkeypatch.setattr(Path, "iterdir", iterdir)
    return names


def test_the_program_that_has_it_open_is_named(computer):
    computer.run(100, "bash", "/dev/ttyUSB1")
    computer.run(200, "minicom", "/dev/ttyUSB0")
    computer.run(os.getpid(), "mikas", "/dev/ttyUSB0")
    error = port_busy("/dev/ttyUSB0?baud=9600", "/dev/ttyUSB0", computer.proc)
    assert type(error) is PortBusy
    assert "is in use by minicom (process 200). Close it" in error.text.en
    assert "занят программой minicom (процесс 200)" in error.text.ru
    assert shared("/dev/ttyUSB0", "/dev/ttyUSB0", computer.proc).reason == (
        "Port /dev/ttyUSB0 is in use by minicom (process 200)",
        "Порт /dev/ttyUSB0 занят программой minicom (процесс 200)",
    )


def test_modem_manager_has_its_own_advice(computer):
    computer.run(300, "ModemManager", "/dev/ttyUSB0")
    error = port_busy("/dev/ttyUSB0", "/dev/ttyUSB0", computer.proc)
    assert type(error) is PortProbed
    assert "in use by ModemManager (process 300)" in error.text.en
    assert "half a minute" in error.text.en


def test_a_system_program_that_hides_its_files_is_the_likely_one(computer, hidden):
    computer.run(300, "ModemManager", "/dev/ttyUSB0")
    computer.run(400, "getty", "/dev/ttyUSB0")
    hidden |= {"ModemManager", "getty"}
    error = port_busy("/dev/ttyUSB0", "/dev/ttyUSB0", computer.proc)
    assert type(error) is PortProbed
    assert "in use by another program, likely ModemManager" in error.text.en
    assert shared("/dev/ttyUSB0", "/dev/ttyUSB0", computer.proc) is None  # not certain enough


@pytest.mark.parametrize("folder", ["proc", "no-such-folder"])
def test_where_nothing_is_found_it_is_another_program(computer, folder):
    computer.run(300, "ModemManager", "/dev/ttyS4")
    error = port_busy("COM3", "COM3", computer.proc.parent / folder)
    assert error.reason.en == "Port COM3 is in use by another program"
    assert "another window of mikas" in error.text.en
    assert shared("COM3", "COM3", computer.proc) is None


def test_the_far_end_of_a_pty_is_no_holder(computer):
    computer.run(100, "sim", "/dev/ptmx", "/dev/pts/7")
    assert shared("/dev/pts/7", "/dev/pts/7", computer.proc) is None
    computer.run(99, "watch", "/dev/pts/7")
    assert shared("/dev/pts/7", "/dev/pts/7", computer.proc) is not None


@pytest.mark.parametrize(
    "program",
    [("brltty", USB_NODE), ("brltty",)],
    ids=["it has the device open", "it has tried"],
)
@pytest.mark.parametrize("driver", ["usbfs", ""])
def test_brltty_has_taken_the_adapter(computer, program, driver):
    computer.plug("1a86:7523", driver=driver)
    computer.run(500, *program)
    error = computer.without_port()
    assert type(error) is TakenByBrltty
    assert "The adapter (CH340) is plugged in but has no port: brltty" in error.text.en
    assert "udev" in error.text.en
    assert "brltty" in error.text.ru


def test_another_program_has_taken_the_adapter(computer):
    computer.plug("0403:6001", driver="usbfs")
    assert "in use by another program" in computer.without_port().reason.en
    computer.run(600, "qemu-system-x86", USB_NODE)
    error = computer.without_port()
    assert type(error) is AdapterTaken
    assert "(FT232R) is plugged in but has no port: it is in use by qemu-system" in error.text.en


def test_an_adapter_that_no_driver_serves_is_an_error_of_its_own(computer):
    computer.plug("10c4:ea60")
    error = computer.without_port()
    assert type(error) is AdapterWithoutDriver
    assert "(CP210x)" in error.text.en
    assert adapter_without_port("x", (0x0403, 0x6001), usb=computer.usb) is None  # of this kind


def test_a_copy_of_a_pl2303_that_linux_refuses_is_to_be_replaced(computer):
    computer.plug("067b:2303")
    error = computer.without_port()
    assert type(error) is AdapterWithoutDriver
    assert "refuses copies of this chip" in error.text.en
    assert "подделки" in error.text.ru


@pytest.mark.parametrize(
    ("ids", "driver", "port"),
    [("0403:6001", "ftdi_sio", "ttyUSB0"), ("1a86:55d4", "cdc_acm", "tty"), ("046d:c52b", "", "")],
    ids=["FTDI", "CDC", "a mouse"],
)
def test_an_adapter_with_its_driver_and_other_devices_are_no_errors(computer, ids, driver, port):
    computer.plug(ids, driver=driver, port=port)
    computer.run(500, "brltty")
    assert computer.without_port() is None


def test_without_usb_no_adapter_is_found(tmp_path):
    assert adapter_without_port(usb=tmp_path / "none", proc=tmp_path) is None
