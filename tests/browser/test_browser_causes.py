"""Causes on the page: of a virtual car with a leak, by a complaint, with the way to the chart."""

from __future__ import annotations

from playwright.sync_api import expect


def test_causes_are_ranked_by_a_touch_and_lead_to_the_chart(served, visitor):
    served.nobody_controls()
    tab = visitor(served.url).show("causes")
    expect(tab.find("[data-verdict]")).to_be_visible()
    chip = tab.find("[role=group] .segment").first
    chip.click()
    expect(chip).to_have_attribute("aria-pressed", "true")
    expect(tab.find("[data-verdict]")).to_be_visible()
    tab.says("a cold start")
