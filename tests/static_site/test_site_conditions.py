"""Actions on conditions in the page without installation: they act, and outlive the page."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.realtime


def test_an_action_marks_and_outlives_the_page(tab):
    tab.show("live")
    tab.press("Actions on conditions")
    tab.press("New action…")
    form = tab.page.get_by_role("dialog").last
    form.get_by_label("Name").fill("runs")
    form.get_by_label("When").fill("FREQ > 100")
    form.get_by_label("Holds for, s").fill("1")
    form.get_by_label("Marker").fill("runs")
    expect(form.get_by_label("Webhook on this computer")).to_have_count(0)
    expect(form.locator("[data-trial]")).to_be_visible()
    form.get_by_role("button", name="Save").click()
    tab.says("Action runs: FREQ > 100")
    kept = tab.get("/actions")
    assert (kept["network"], kept["problem"]) == (False, None)
    tab.page.keyboard.press("Escape")
    tab.again()
    assert [rule["name"] for rule in tab.get("/actions")["rules"]] == ["runs"]
