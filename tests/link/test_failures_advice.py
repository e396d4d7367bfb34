"""A port that does not open: what to do next depends on what it is."""

from __future__ import annotations

import errno
import socket

import pytest
from serial import SerialException

from mikas.cli.advice import ADVICE
from mikas.errors import NoPortGiven, PortBusy
from mikas.link.failures import opening_failed
from mikas.link.ports import choose_port


class Listed:
    manufacturer, serial_number, location = "FTDI", None, None

    def __init__(self, device: str, vid: int | None = 0x0403) -> None:
        self.device, self.vid, self.pid = device, vid, 0x6001
        self.description = device


def refused(number: int, text: str) -> Exception:
    cause = OSError(number, text)
    error = SerialException(f"could not open port: {cause}")
    error.__cause__ = cause
    return error


@pytest.mark.parametrize("url", ["socket://10.0.0.5:4001", "rfc2217://10.0.0.5:4001"])
@pytest.mark.parametrize(
    "reason", [ConnectionRefusedError(111, "refused"), socket.gaierror(-2, "no name")]
)
def test_an_address_in_the_network_has_nothing_to_unplug(url, reason):
    error = SerialException(f"could not open port: {reason}")
    error.__cause__ = reason
    reported = opening_failed(url, error)
    assert "Check, in order: the host and the port" in str(reported)
    assert "nplug" not in str(reported)
    assert "Проверьте по порядку: имя и порт" in reported.text.ru


def test_what_is_no_serial_port_at_all_is_a_wrong_name():
    reported = opening_failed("/etc/passwd", refused(errno.ENOTTY, "Inappropriate ioctl"))
    assert "Serial ports found:" in str(reported)
    assert "nplug" not in str(reported)
    assert "Найденные последовательные порты:" in reported.text.ru


def test_an_adapter_that_fails_is_unplugged_and_plugged_in_again():
    reported = opening_failed("/dev/ttyUSB0", refused(errno.EIO, "Input/output error"))
    assert "Unplug the adapter" in str(reported)


def test_a_busy_port_may_be_our_own_other_window():
    assert "another window of mikas" in str(PortBusy(url="COM3"))
    assert "другое окно mikas" in PortBusy(url="COM3").text.ru


def test_of_several_adapters_one_is_to_be_named():
    with pytest.raises(NoPortGiven) as raised:
        choose_port(lambda: [Listed("/dev/ttyUSB0"), Listed("/dev/ttyUSB1")])
    reported = ADVICE.text(raised.value)
    assert "Found: /dev/ttyUSB0 (FT232R), /dev/ttyUSB1 (FT232R)." in reported.en
    assert "--port /dev/ttyUSB0" in reported.en
    assert "plugged in" not in reported.en
    assert "--port /dev/ttyUSB0" in reported.ru


def test_where_there_is_none_it_is_to_be_plugged_in_or_named():
    with pytest.raises(NoPortGiven) as raised:
        choose_port(lambda: [Listed("/dev/ttyS0", vid=None)])
    reported = ADVICE.text(raised.value)
    assert "Plug the adapter in" in reported.en
    assert "--port" in reported.en.replace("--port sim:", "")
    assert "Подключите адаптер" in reported.ru
