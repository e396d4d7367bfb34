"""The site on a car: the adapter is found, values and passport are those of the unit."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from .site_rig import PORT

pytestmark = pytest.mark.realtime


def test_an_adapter_that_the_browser_allows_is_listed_and_connected(visit, car):
    visit.show("connection")
    expect(visit.button("Choose the cable…")).to_be_visible()
    one = visit.find("#screen li", has_text="0403:6001")
    expect(one).to_contain_text("FT232R")
    visit.press(f"Connect to {PORT}")
    visit.is_line("sampling")
    expect(visit.find("header[data-line]")).to_contain_text("Mikas 7.1")
    expect(one).to_contain_text("in use")


def test_values_are_those_of_the_unit(tab, car):
    tab.show("live")
    for name, raw, shown in (
        ("TWAT", "80", "88"), ("TWAT", "7F", "87"), ("UACC", "8A", "13.8"), ("UOZ", "F9", "−3.5"),
        ("JAIR", "DC 05", "15.0"),
    ):  # fmt: skip
        car.set(name, raw)
        expect(tab.value(name)).to_have_text(shown)


def test_the_passport_is_the_units(tab):
    tab.show("passport")
    tab.says("17.3763.000-02")


def test_an_adapter_that_was_pulled_is_found_again(tab, car):
    tab.refused = True
    tab.show("live")
    car.pull()
    tab.is_line("no-port")
    expect(tab.value("TWAT")).not_to_have_text("87")
    car.put_back()
    tab.is_line("sampling")
    car.set("TWAT", "81")
    expect(tab.value("TWAT")).to_have_text("89")
