"""Finding the adapter among made-up ports."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from serial.tools import list_ports

from mikas.cleaning import clean_line
from mikas.errors import NoPortGiven, PortNotFound
from mikas.link import choose_port, find_ports
from mikas.link.ports import listed


@dataclass
class Listed:
    device: str
    description: str = "n/a"
    vid: int | None = None
    pid: int | None = None
    serial_number: str | None = None
    manufacturer: str | None = None
    location: str | None = None


FTDI = Listed("/dev/ttyUSB0", "FT232R USB UART", 0x0403, 0x6001, "A50285BI", "FTDI")
CH340 = Listed("/dev/ttyUSB1", "USB2.0-Serial", 0x1A86, 0x7523)
PROLIFIC = Listed(
    "COM4", "Prolific USB-to-Serial Comm Port (COM4)", 0x067B, 0x2303, None, "Prolific"
)
PHONE = Listed("/dev/ttyACM0", "SAMSUNG_Android", 0x04E8, 0x6860)
BUILT_IN = Listed("/dev/ttyS0", "ttyS0")
BLUETOOTH = Listed("/dev/cu.Bluetooth-Incoming-Port")


def found(*ports, **settings):
    return find_ports(lambda: ports, **settings)


def test_an_adapter_has_its_name_chip_numbers_and_latency(tmp_path):
    (tmp_path / "ttyUSB0").mkdir()
    (tmp_path / "ttyUSB0" / "latency_timer").write_text("16\n")
    (port,) = found(FTDI, sysfs=tmp_path)
    assert port.url == "/dev/ttyUSB0"
    assert port.description == "FT232R USB UART (FTDI)"
    assert (port.vid, port.pid, port.serial_number) == (0x0403, 0x6001, "A50285BI")
    assert port.chip == "FT232R"
    assert port.likely
    assert port.latency_ms == 16
    assert "16 ms" in port.quirks[0].en
    assert "16 мс" in port.quirks[0].ru


def test_the_texts_of_a_device_that_someone_has_made_are_of_one_line_and_short():
    words = "\x1b]0;x\a\u202e\n" + "y" * 999
    (port,) = found(Listed("/dev/ttyUSB0", words, 0x0403, 0x6001, words, words, words))
    for text in (port.description, port.serial_number, port.location):
        assert clean_line(text, 300) == text
        assert "\x1b" not in text


@pytest.mark.parametrize(
    ("given", "number"),
    [("A50285BI", "A50285BI"), ("5&2A5C8B5&0&3", None), ("", None), (None, None)],
)
def test_a_number_that_windows_made_up_is_none(given, number):
    (port,) = found(Listed("COM3", vid=0x1A86, pid=0x7523, serial_number=given, location="1-4"))
    assert (port.serial_number, port.location) == (number, "1-4")


def test_no_latency_where_the_system_does_not_tell(tmp_path):
    assert found(CH340, sysfs=tmp_path)[0].latency_ms is None


@pytest.mark.parametrize(
    ("vid", "pid", "chip", "quirk"),
    [
        (0x0403, 0x6015, "FT231X", "latency timer"),
        (0x0403, 0xFFFF, "FTDI", "latency timer"),
        (0x1A86, 0x7523, "CH340", "lumps"),
        (0x1A86, 0x55D4, "CH9102", ""),
        (0x10C4, 0xEA60, "CP210x", "10400 becomes 14400"),
        (0x067B, 0x2303, "PL2303", "counterfeit"),
        (0x067B, 0x23A3, "PL2303GC", ""),
    ],
)
def test_a_chip_is_recognized_with_its_quirks(vid, pid, chip, quirk):
    (port,) = found(Listed("COM3", vid=vid, pid=pid))
    assert (port.chip, port.likely) == (chip, True)
    assert quirk in " ".join(text.en for text in port.quirks)
    assert all(text.ru for text in port.quirks)


def test_an_unknown_usb_device_is_not_likely_and_says_so():
    (port,) = found(PHONE)
    assert (port.chip, port.likely) == ("", False)
    assert "unknown USB device" in port.quirks[0].en


@pytest.mark.parametrize("port", [BUILT_IN, BLUETOOTH])
def test_other_ports_are_not_likely_and_have_no_quirks(port):
    (port,) = found(port)
    assert (port.chip, port.likely, port.quirks) == ("", False, ())


def test_a_description_is_never_empty_nor_repeats_the_port():
    assert [port.description for port in found(BLUETOOTH, PROLIFIC)] == [
        "Prolific USB-to-Serial Comm Port",
        "/dev/cu.Bluetooth-Incoming-Port",
    ]


def test_the_best_guess_comes_first():
    com10, com9 = Listed("COM10", vid=0x10C4, pid=0xEA60), Listed("COM9", vid=0x10C4, pid=0xEA60)
    urls = [port.url for port in found(BUILT_IN, PHONE, PROLIFIC, com10, com9, CH340, FTDI)]
    assert urls == [
        "/dev/ttyUSB0", "/dev/ttyUSB1", "COM9", "COM10", "COM4", "/dev/ttyACM0", "/dev/ttyS0",
    ]  # fmt: skip


def test_the_only_likely_port_is_chosen():
    assert choose_port(lambda: [BUILT_IN, PHONE, FTDI]) == "/dev/ttyUSB0"


@pytest.mark.parametrize(
    ("ports", "en", "ru"),
    [
        ([], "none", "ни одного"),
        ([BUILT_IN], "/dev/ttyS0", "/dev/ttyS0"),
        ([CH340, FTDI], "/dev/ttyUSB0 (FT232R), /dev/ttyUSB1 (CH340)", "/dev/ttyUSB0 (FT232R), "),
    ],
)
def test_otherwise_the_user_chooses(ports, en, ru):
    with pytest.raises(NoPortGiven) as caught:
        choose_port(lambda: ports)
    assert isinstance(caught.value, PortNotFound)
    assert f"Found: {en}" in caught.value.text.en
    assert f"Найдены: {ru}" in caught.value.text.ru


def test_an_empty_list_of_ports_is_none_in_words():
    assert listed([]).en == "none"


def test_the_systems_ports_can_be_listed():
    assert all(port.url and port.description for port in find_ports())


def test_an_adapter_plugged_in_while_listing_is_found_by_another_look(monkeypatch):
    answers = [TypeError("int() can't convert non-string with explicit base"), [FTDI]]

    def stumble():
        answer = answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    monkeypatch.setattr(list_ports, "comports", stumble)
    assert [port.chip for port in find_ports()] == ["FT232R"]
