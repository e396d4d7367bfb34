"""The site in Chromium, on a computer with fake USB adapters.

Skipped as a whole where Chromium or the rights for the fake adapters are missing, unless
`MIKAS_REQUIRE_CHROMIUM` is set: then that is a failure.
"""

from __future__ import annotations

import sys

import pytest
from playwright.sync_api import sync_playwright

from browser.chromium_rig import installed, launched, must_not_miss, visits

from . import computer_rig, site_rig, usb_sockets_rig
from .pages_rig import StaticHost
from .site_rig import site_tab
from .usb_sockets_rig import UsbSockets
from .wire_rig import cable, wire

collect_ignore_glob = [] if sys.platform == "linux" else ["*"]


@pytest.fixture(scope="package")
def whole_computer():
    must_not_miss("" if installed() else "Chromium is not installed")
    must_not_miss(computer_rig.missing())
    with computer_rig.computer() as computer:
        yield computer


@pytest.fixture(scope="package")
def usb_sockets(whole_computer):
    """The USB sockets of that computer, for WebUSB."""
    must_not_miss(usb_sockets_rig.missing())
    made = UsbSockets(whole_computer)
    yield made
    made.close()


@pytest.fixture(scope="package")
def chromium_program(whole_computer, tmp_path_factory):
    """The browser's program, to be started on that computer."""
    return whole_computer.wrapper(installed(), tmp_path_factory.mktemp("chromium"))


@pytest.fixture(scope="package")
def driver():
    """Playwright, to start browsers with."""
    with sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="package")
def chromium(driver, chromium_program):
    with launched(driver, chromium_program) as browser:
        yield browser


@pytest.fixture
def computer(whole_computer):
    """The computer that the browser runs on, with nothing plugged in."""
    yield whole_computer
    whole_computer.unplug_all()
    whole_computer.forget_choice()


@pytest.fixture
def visitor(chromium):
    """Opens tabs, as the fixture of this name in `browser`."""
    with visits(chromium) as visit:
        yield visit


@pytest.fixture
def ft232(computer, tmp_path):
    """An FT232 on the virtual unit, plugged in."""
    with cable(computer, tmp_path) as plugged:
        yield plugged


@pytest.fixture
def by_hand(computer):
    """An FT232, plugged in; the test itself is at the other end of its wire."""
    with wire(computer) as plugged:
        yield plugged


@pytest.fixture
def host(computer):
    """Starts a host of pages: `host(folder, answers={"/path": answer})`."""
    hosts = []

    def serve(folder, answers=None) -> StaticHost:
        hosts.append(StaticHost(computer, folder, answers))
        return hosts[-1]

    yield serve
    for each in hosts:
        each.stop()


@pytest.fixture(scope="module")
def site(chromium, whole_computer):
    """The built site on a static host."""
    must_not_miss(site_rig.missing())
    served = StaticHost(whole_computer, site_rig.BUILT)
    yield served
    served.stop()


@pytest.fixture(scope="module")
def car(whole_computer, tmp_path_factory):
    """An FT232 on the virtual unit, plugged in, for the tests of a module."""
    with cable(whole_computer, tmp_path_factory.mktemp("car")) as plugged:
        yield plugged


@pytest.fixture(scope="module")
def profile(chromium):
    """A profile of the browser for the tests of a module: what is kept stays."""
    context = chromium.new_context(locale="en-GB", viewport={"width": 1280, "height": 800})
    yield context
    context.close()


@pytest.fixture(scope="module")
def visit(site, profile):
    """The site in a tab, which the tests of a module share: starting the program takes seconds."""
    with site_tab(profile, site.url) as tab:
        yield tab.open()


@pytest.fixture
def tab(visit, car):
    """That tab, connected to the car."""
    visit.refused = False
    return visit.connect()
