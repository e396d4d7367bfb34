"""Causes on the site: ranked in the page's own Python, without numpy."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.realtime


def test_the_causes_of_the_car_are_ranked_in_the_browser(visit, car):
    visit.connect().show("causes")
    expect(visit.page.locator("[data-verdict]")).to_be_visible(timeout=30_000)
    chip = visit.page.locator("[role=group] .segment").first
    chip.click()
    expect(chip).to_have_attribute("aria-pressed", "true")
    expect(visit.page.locator("[data-verdict]")).to_be_visible(timeout=30_000)
