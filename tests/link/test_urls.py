"""URLs and the register of schemes; nothing is opened."""

from __future__ import annotations

import subprocess
import sys
from contextlib import suppress
from string import ascii_lowercase

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.errors import BadPortUrl
from mikas.link import open_link, register, urls
from mikas.link.urls import PortUrl, parse
from mikas.options import check_names

calls = []


def opener(url, options):
    calls.append((url, options))
    return "an open link"


@pytest.fixture(autouse=True)
def schemes_as_before(monkeypatch):
    monkeypatch.setattr(urls, "_openers", dict(urls._openers))
    calls.clear()


@pytest.mark.parametrize(
    ("url", "scheme", "address"),
    [
        ("/dev/ttyUSB0", "serial", "/dev/ttyUSB0"),
        ("COM3", "serial", "COM3"),
        ("COM3:", "serial", "COM3:"),
        (r"\\.\COM12", "serial", r"\\.\COM12"),
        ("C:/tmp/pty", "serial", "C:/tmp/pty"),
        ("/dev/cu.usbserial-A50285BI", "serial", "/dev/cu.usbserial-A50285BI"),
        ("/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0", "serial",
         "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0"),
        ("serial:/dev/ttyUSB0", "serial", "/dev/ttyUSB0"),
        ("serial:///dev/ttyUSB0", "serial", "/dev/ttyUSB0"),
        ("Serial:COM3", "serial", "COM3"),
        ("socket://host:4001", "socket", "host:4001"),
        ("SOCKET:host:4001", "socket", "host:4001"),
        ("rfc2217://[::1]:4001", "rfc2217", "[::1]:4001"),
        ("sim:", "sim", ""),
        ("sim://", "sim", ""),
    ],
)  # fmt: skip
def test_scheme_and_address(url, scheme, address):
    assert parse(url) == PortUrl(scheme, address, {})


def test_options_are_decoded():
    assert parse("sim:?scenario=warm-idle&seed=1&faults=13%2C53&empty=").options == {
        "scenario": "warm-idle",
        "seed": "1",
        "faults": "13,53",
        "empty": "",
    }


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("", "it is empty"),
        ("?baud=9600", "it is empty"),
        ("serial:", "it is empty"),
        ("sokcet://host:1", "Did you mean socket:?"),
        ("tcp://host:1", "there is no “tcp:”, only: serial:, socket:, rfc2217:, sim:"),
        ("smi:?seed=1", "Did you mean sim:?"),
        ("sim:?seed=1&seed=2", "seed is given twice"),
        ("/dev/\0", "zero byte"),
    ],
)
def test_nonsense_is_refused(url, said):
    with pytest.raises(BadPortUrl) as caught:
        parse(url)
    assert said in str(caught.value)
    assert "порт" in caught.value.text.ru


@given(st.text())
def test_any_text_is_a_port_or_a_usage_error(url):
    with suppress(BadPortUrl):
        parse(url)


@given(st.dictionaries(st.text(ascii_lowercase, min_size=1), st.text(), max_size=4))
def test_options_given_by_name_reach_the_opener(options):
    calls.clear()
    register("test", opener)
    open_link("test:x", **options)
    ((url, got),) = calls
    assert got == options
    assert parse(url).options == options


def test_options_given_by_name_win_and_show_in_the_url():
    register("test", opener)
    open_link("test:x?a=1&b=2", b=3, on=True, off=False)
    assert calls == [
        ("test:x?a=1&b=3&on=1&off=0", {"a": "1", "b": "3", "on": "1", "off": "0"}),
    ]


def test_an_opener_may_be_an_import_path():
    register("Test", f"{__name__}:opener")
    assert open_link("TEST:?a=1") == "an open link"
    assert sys.modules[__name__].calls == [("TEST:?a=1", {"a": "1"})]


def test_a_later_registration_replaces_an_earlier_one():
    register("sim", opener)
    assert open_link("sim:") == "an open link"


@pytest.mark.parametrize("scheme", ["", "c", "1a", "a b", "a:b", "a/b"])
def test_impossible_schemes(scheme):
    with pytest.raises(ValueError, match="scheme"):
        register(scheme, opener)


def test_a_wrong_option_is_told_with_the_url():
    def picky(url, options):
        check_names(options, ("baud",))

    register("test", picky)
    with pytest.raises(BadPortUrl) as caught:
        open_link("test:x?buad=1")
    assert str(caught.value).startswith("“test:x?buad=1” is not a port: there is no option “buad”")


def test_importing_the_package_imports_no_back_end():
    heavy = "{'serial', 'mikas.link.serial', 'mikas.link.virtual', 'socket'}"
    code = f"import sys, mikas.link; print(*({heavy} & set(sys.modules)))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).split() == []
