"""A car with a carburettor: its unit has no injectors, so their values are left out, said once."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from browser.rig import dashboard

PHONE = {"width": 390, "height": 844}
LAPTOP = {"width": 1366, "height": 768}
DEAD = ("JAIR", "INJ", "SSM", "FSM", "RCOD", "JQT", "VALF")


@pytest.fixture
def parked(chromium, tmp_path):
    """A program with nothing connected; it ends after the tabs."""
    with dashboard(tmp_path, begin=False) as dash:
        yield dash


@pytest.mark.parametrize("viewport", [PHONE, LAPTOP], ids=["phone", "laptop"])
def test_what_the_unit_does_not_have_is_left_out_and_said_once(parked, visitor, tmp_path, viewport):
    tab = visitor(parked.url, locale="ru-RU", viewport=viewport).show("connection")
    tab.find("summary").get_by_text("Выбрать машину и неисправность").click()
    tab.press("Карбюраторная")
    tab.find("#screen").get_by_label("Поездка").select_option("warm-idle")
    tab.press("Запустить эту машину")
    line = tab.find("[data-ignition-only]")
    expect(line).to_have_count(1)
    expect(line).to_contain_text("Блок только зажигания: форсунок, ДМРВ и РДВ (РХХ) нет")
    for name in DEAD:
        expect(tab.find(f'[data-tile="{name}"]')).to_have_count(0)
    expect(tab.find('[data-tile="FREQ"]').first).to_be_visible()
    tab.page.screenshot(path=tmp_path / "live.png")

    tab.press("Всё равно показать")
    expect(tab.find('[data-tile="INJ"]')).to_be_visible()
    tab.press("Скрыть", exact=True)
    expect(tab.find('[data-tile="INJ"]')).to_have_count(0)

    tab.show("chart")
    expect(line).to_have_count(1)
    expect(tab.traced("INJ")).to_have_count(0)
    expect(tab.traced("FREQ").first).to_be_visible()
    tab.page.screenshot(path=tmp_path / "chart.png")


def test_a_recording_of_such_a_car_is_shown_alike(parked, visitor):
    parked.post("/connect", {"port": "sim:?scenario=warm-idle&model=5.4&ignition_only=yes"})
    parked.samples()
    parked.post("/recording/start", {"name": "carburettor"})
    parked.until(lambda: parked.state()["recording"]["samples"] > 40)
    parked.post("/recording/stop")
    parked.post("/disconnect")
    parked.post("/control/release")
    tab = visitor(parked.url).show("recordings")
    tab.find("#screen").get_by_role("button", name="Open", exact=True).first.click()
    expect(tab.find('nav a[data-screen="live"]')).to_have_attribute("aria-current", "page")
    tab.show("chart")
    expect(tab.find("[data-ignition-only]")).to_have_count(1)
    expect(tab.traced("INJ")).to_have_count(0)
    expect(tab.traced("FREQ").first).to_be_visible()
