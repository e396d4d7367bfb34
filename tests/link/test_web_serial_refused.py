"""Why a port of the browser does not open, in words, and what its link knows; the rest is tested in
a browser.
"""

from __future__ import annotations

from types import SimpleNamespace as Its

import pytest

from mikas.browser import web_serial
from mikas.errors import NoConnection, PortFailed

FT232 = Its(scheme="webserial", vid=0x0403, pid=0x6001, serialNumber="", nth=1)
IN_PHONE = Its(scheme="webusb", vid=0x0403, pid=0x6001, serialNumber="A10K", nth=1)
CH340 = Its(scheme="webusb", vid=0x1A86, pid=0x7523, serialNumber="", nth=2)
CP2102 = Its(scheme="webusb", vid=0x10C4, pid=0xEA60, serialNumber="0001", nth=1)


@pytest.fixture
def browser(monkeypatch):
    """Has one port granted, and what comes of opening it."""

    def of(granted, opened):
        serial = Its(
            ports=lambda: Its(promise=[granted]), open=lambda *_: Its(promise=opened), now=lambda: 0
        )
        monkeypatch.setattr(web_serial, "_chosen", lambda _, ports: ports[0])  # no URL of a desktop
        monkeypatch.setattr(web_serial, "_host", lambda: (serial, lambda promise: promise))

    return of


@pytest.mark.parametrize(
    ("granted", "refused", "words"),
    [
        (FT232, "NetworkError", ("another tab", "другой вкладке")),
        (FT232, "NetworkError", ("gives no reason", "не сообщил причину")),
        (FT232, "InvalidStateError", ("Reload the page", "Обновите страницу")),
        (FT232, "TimeoutError", ("unplug it and plug it in again", "отключите адаптер")),
        (FT232, "UnknownError", ("14400", "14400")),
        (IN_PHONE, "NetworkError", ("Not through a hub", "Не через хаб")),
        (IN_PHONE, "NotFoundError", ("OTG", "OTG")),
        (IN_PHONE, "SecurityError", ("answer OK when the phone asks", "ответьте «ОК»")),
        (CH340, "ClaimError", ("the cable's CH340 is in use", "CH340 кабеля занята")),
        (CH340, "ClaimError", ("A cable with an FT232R will do", "Подойдёт кабель с FT232R")),
        (CP2102, "RateError", ("CP210x can't do 9600 bit/s: it would make 14400", "14400")),
        (CP2102, "RateError", ("take a cable with an FT232R or CH340", "возьмите кабель с FT232R")),
        (CP2102, "NotSupportedError", ("this kind of CP210x is not known", "неизвестна")),
        (CH340, "ChipError", ("bad copy", "плохая копия")),
    ],
)
def test_a_refusal_says_what_to_do(browser, granted, refused, words):
    browser(granted, Its(refused=refused, message="14400"))
    with pytest.raises(NoConnection) as raised:
        web_serial.open_web_serial("webserial:0403:6001", {})
    assert type(raised.value) is PortFailed
    assert words[0] in raised.value.text.en
    assert words[1] in raised.value.text.ru


def test_a_chip_that_the_browser_takes_over_needs_no_other_cable(browser):
    browser(IN_PHONE, Its(refused="ClaimError", message=""))
    with pytest.raises(PortFailed) as raised:
        web_serial.open_web_serial("webusb:0403:6001", {})
    assert "Close other diagnostics apps" in raised.value.text.en
    assert "will do" not in raised.value.text.en


def test_ports_over_webusb_have_a_scheme_of_their_own_and_no_quirks_of_systems_drivers(browser):
    for granted, url, quirks in (
        (FT232, "webserial:0403:6001", ["latency timer"]),
        (IN_PHONE, "webusb:0403:6001", []),
        (CH340, "webusb:1a86:7523:2", ["cheap cables"]),
        (CP2102, "webusb:10c4:ea60", ["10400 becomes 14400"]),
    ):
        browser(granted, None)
        [port] = web_serial.find_web_ports()
        assert port.url == url
        assert port.serial_number == (granted.serialNumber or None)
        assert len(port.quirks) == len(quirks)
        assert all(words in it.en for words, it in zip(quirks, port.quirks, strict=True))


def test_bytes_come_as_late_as_the_chip_and_the_browser_make_them(browser):
    for granularity, late in ((0, 0.03), (0.001, 0.002), (0.016, 0.017)):
        browser(IN_PHONE, Its(granularity=granularity))
        link = web_serial.open_web_serial("webusb:0403:6001", {})
        assert link.granularity == pytest.approx(late)
