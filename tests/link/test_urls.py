"""URLs, and the links that distributions bring; nothing is opened."""

from __future__ import annotations

import errno
import subprocess
import sys
from contextlib import suppress
from functools import cache
from string import ascii_lowercase

import pytest
from hypothesis import given
from hypothesis import strategies as st

from link_rig import installed, registered
from mikas.errors import BadPortUrl, PortFailed, UsageError
from mikas.link import LinkWrapper, open_link, urls
from mikas.link.urls import PortUrl, parse
from mikas.options import check_names

calls = []


class OpenLink(LinkWrapper):
    pass


@cache
def wire():
    return open_link("sim:?clock=simulated")


def opener(url, options):
    calls.append((url, options))
    return OpenLink(wire())


def raising(url, options):
    raise ZeroDivisionError("of a stranger")


def refusing(url, options):
    raise PermissionError(errno.EACCES, "denied")


def opening_nothing(url, options):
    return None


NO_FUNCTION = 5


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
def test_a_url_is_split_into_scheme_and_address(url, scheme, address):
    assert parse(url) == PortUrl(scheme, address, {})


def test_options_are_decoded():
    assert parse("sim:?scenario=warm-idle&seed=1&faults=13%2C53&empty=").options == {
        "scenario": "warm-idle",
        "seed": "1",
        "faults": "13,53",
        "empty": "",
    }


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("", "it is empty"),
        ("?baud=9600", "it is empty"),
        ("serial:", "it is empty"),
        ("sokcet://host:1", "Did you mean socket:?"),
        ("tcp://host:1", "there is no “tcp:”, only: replay:, rfc2217:, serial:, sim:, socket:"),
        ("smi:?seed=1", "Did you mean sim:?"),
        ("sim:?seed=1&seed=2", "seed is given twice"),
        ("/dev/\0", "zero byte"),
    ],
)
def test_nonsense_is_refused(url, message):
    with pytest.raises(BadPortUrl) as caught:
        parse(url)
    assert message in str(caught.value)
    assert "порт" in caught.value.text.ru


@given(st.text())
def test_any_text_is_a_port_or_a_usage_error(url):
    with suppress(BadPortUrl):
        parse(url)


@given(st.dictionaries(st.text(ascii_lowercase, min_size=1), st.text(), max_size=4))
def test_options_given_by_name_reach_the_opener(options):
    calls.clear()
    with registered("test", opener):
        open_link("test:x", **options)
        ((url, got),) = calls
        assert got == options
        assert parse(url).options == options


def test_options_given_by_name_win_and_show_in_the_url():
    calls.clear()
    with registered("test", opener):
        open_link("test:x?a=1&b=2", b=3, on=True, off=False)
    assert calls == [
        ("test:x?a=1&b=3&on=1&off=0", {"a": "1", "b": "3", "on": "1", "off": "0"}),
    ]


def test_the_error_of_a_wrong_option_names_the_url():
    def picky(url, options):
        check_names(options, ("baud",))

    with registered("test", picky), pytest.raises(BadPortUrl) as caught:
        open_link("test:x?buad=1")
    assert str(caught.value).startswith("Invalid port “test:x?buad=1”: there is no option “buad”")


class TestDistributions:
    """Links that other distributions bring, with real metadata."""

    def test_a_link_of_another_distribution_opens(self, tmp_path):
        with installed(tmp_path, "own-link", {"Loud": f"{__name__}:opener"}):
            calls.clear()
            loud = open_link("LOUD:?a=1")
            assert isinstance(loud, sys.modules[__name__].OpenLink)
            assert sys.modules[__name__].calls == [("LOUD:?a=1", {"a": "1"})]
            assert parse("sim:").scheme == "sim"
        with pytest.raises(BadPortUrl, match="there is no “loud:”"):
            open_link("loud://")

    def test_a_scheme_of_two_distributions_names_both(self, tmp_path):
        with installed(tmp_path, "own-sim", {"sim": f"{__name__}:opener"}):
            with pytest.raises(UsageError, match=r"brings sim: mikas \S+, own-sim 1\.0") as caught:
                open_link("sim:")
            assert "own-sim 1.0" in caught.value.text.ru
            assert "Uninstall all but one" in str(caught.value)
            assert parse("sim:").scheme == "sim"  # nothing is loaded for that

    @pytest.mark.parametrize(
        ("place", "why"),
        [
            ("no_such_module:opener", "ModuleNotFoundError: No module named 'no_such_module'"),
            ("own_broken:missing", "AttributeError"),
            ("own_failing:opener", "ZeroDivisionError"),
            ("own_exiting:opener", "SystemExit: 3"),
            (f"{__name__}:raising", "could not open the port (ZeroDivisionError: of a stranger)"),
            (f"{__name__}:opening_nothing", "opened no link: None has no url, baud"),
            (f"{__name__}:NO_FUNCTION", "is not a function of an address and its options"),
        ],
    )
    def test_a_link_that_does_not_work_names_its_distribution(self, tmp_path, place, why):
        (tmp_path / "own_broken.py").write_text("")
        (tmp_path / "own_failing.py").write_text("1 / 0")
        (tmp_path / "own_exiting.py").write_text("raise SystemExit(3)")
        with installed(tmp_path, "own-broken", {"broken": place}):
            with pytest.raises(UsageError, match=r"of the distribution own-broken 1\.0") as caught:
                open_link("broken:x")
            assert why in str(caught.value)
            assert "own-broken 1.0" in caught.value.text.ru
            with open_link("sim:?clock=simulated") as link:  # others are not concerned
                assert link.now() == 0.0

    @pytest.mark.parametrize(
        "entries", [b"[console_scripts]\njust words\n", b"\xff\xfe[mikas.links]\nx = y:z\n"]
    )
    def test_a_distribution_with_damaged_metadata_harms_no_other(self, tmp_path, entries):
        broken = tmp_path / "broken-1.0.dist-info"
        broken.mkdir()
        (broken / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
        (broken / "entry_points.txt").write_bytes(entries)
        with installed(tmp_path, "own-link", {"loud": f"{__name__}:opener"}):
            assert open_link("loud:x")
            assert len(urls.registered()["sim"]) == 1

    def test_an_error_of_the_system_is_a_port_that_did_not_open(self, tmp_path):
        with installed(tmp_path, "own-link", {"mine": f"{__name__}:refusing"}):
            with pytest.raises(PortFailed, match="mine:x could not be opened") as caught:
                open_link("mine:x")
            assert caught.value.errno == errno.EACCES

    def test_an_incomplete_installation_says_so(self, monkeypatch):
        monkeypatch.setattr("importlib.metadata.entry_points", lambda **_: ())
        urls.registered.cache_clear()
        with pytest.raises(UsageError, match="not installed as it should"):
            open_link("/dev/ttyUSB0")

    def test_where_the_system_has_no_serial_ports_a_wrong_one_leads_to_the_browsers_list(
        self, monkeypatch
    ):
        entries = {"sim": urls.registered()["sim"], "webserial": []}
        monkeypatch.setattr(urls, "registered", lambda: entries)
        for url in ("/dev/ttyUSB0", "COM3", "serial:COM3", "socket://a:1", "sim:?scenario=none"):
            with pytest.raises(BadPortUrl) as caught:
                open_link(url)
            text = str(caught.value)
            assert "Choose the cable…" in text
            assert "/dev/ttyUSB0" not in text.replace(url, "")
            assert "COM3" not in text.replace(url, "")
        with open_link("sim:?clock=simulated") as link:
            assert link.is_virtual

    def test_a_path_needs_no_metadata(self, monkeypatch):
        monkeypatch.setattr(urls, "registered", None)
        assert parse("/dev/ttyUSB0").scheme == "serial"

    def test_our_own_schemes_load(self):
        for scheme in ("serial", "socket", "rfc2217", "sim", "replay"):
            assert callable(urls.opener_of(scheme))


def test_importing_the_package_imports_no_back_end():
    heavy = "{'serial', 'mikas.link.serial', 'mikas.link.virtual', 'socket'}"
    code = f"import sys, mikas.link; print(*({heavy} & set(sys.modules)))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).split() == []


def test_an_adapter_has_its_name_among_the_ports_and_others_have_none():
    assert parse("/dev/ttyUSB0?rts=1").name == parse("serial:/dev/ttyUSB0").name == "/dev/ttyUSB0"
    assert PortUrl("webserial", "0403:6001", {"rts": "1"}).name == "webserial:0403:6001"
    schemes = ("serial", "webserial", "webusb", "socket")
    adapters = [PortUrl(scheme, "x", {}).is_adapter for scheme in schemes]
    assert adapters == [True, True, True, False]


@pytest.mark.parametrize(
    ("one", "other", "two"),
    [
        ("sim:?scenario=city", "sim:?scenario=city", False),
        ("sim:?scenario=city", "sim:?scenario=city&car=leak:8", True),
        ("sim:", "/dev/ttyUSB0", True),
        ("/dev/ttyUSB0", "/dev/ttyUSB1", False),
        ("/dev/ttyUSB0", "socket://192.168.0.5:4001", False),
    ],
)
def test_a_virtual_car_is_at_its_own_url_alone(one, other, two):
    assert urls.are_of_two_cars(one, other) is two
    assert urls.are_of_two_cars(other, one) is two
