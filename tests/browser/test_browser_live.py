"""Live: what the unit was set to is what the page says, in both languages."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

SHOWN = {  # as the car of the rig was set, by hand from §4
    "TWAT": ("87", "87"),
    "UACC": ("13.8", "13,8"),
    "JAIR": ("15.0", "15,0"),  # 0x05DC / 100
    "INJ": ("4.64", "4,64"),
    "UOZ": ("−3.5", "−3,5"),  # 0xF9, signed, / 2
    "RXX": ("Idle", "Холостой ход"),
    "DET": ("No knock", "Детонации нет"),
}


@pytest.mark.parametrize(("locale", "which"), [("en-GB", 0), ("ru-RU", 1)])
def test_the_values_are_those_of_the_unit(dash, visitor, locale, which):
    tab = visitor(dash.url, locale=locale).show("live")
    tab.is_line("sampling")
    for name, texts in SHOWN.items():
        expect(tab.value(name)).to_have_text(texts[which])
    dash.garage.set("TWAT", "91")
    expect(tab.value("TWAT")).to_have_text("105")
    expect(tab.find('[data-tile="TWAT"]')).to_contain_class("warning")
    dash.garage.set("TWAT", "7F")
    expect(tab.value("TWAT")).to_have_text("87")
    expect(tab.find('[data-tile="TWAT"]')).not_to_contain_class("warning")
