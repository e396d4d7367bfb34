"""CO is set by a meter on the page: each write confirmed, in the journal, and put back."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from browser.rig import dashboard
from browser.test_browser_channels import violations


@pytest.fixture
def idle(chromium, tmp_path):
    with dashboard(tmp_path, scenario="warm-idle") as dash:
        yield dash.samples()


@pytest.mark.parametrize(
    ("locale", "viewport"),
    [("en-GB", {"width": 1280, "height": 720}), ("ru-RU", {"width": 390, "height": 844})],
)
def test_co_is_set_step_by_step_and_put_back(idle, visitor, locale, viewport):
    idle.nobody_controls()
    tab = visitor(idle.url, locale=locale, viewport=viewport).show("tests/co")
    screen = tab.find("#screen")
    expect(screen.locator(".text-ok")).to_be_visible()
    tab.find(".lock button").click()
    tab.find("dialog .foot button").last.click()
    expect(tab.find(".lock.open")).to_be_visible()
    screen.locator("form input").first.fill("0.8")
    assert violations(tab) == []
    screen.locator("form [type=submit]").click()
    analyser = {"88": "2,0", "80": "1.2", "7C": "0.9"}
    for _ in range(4):
        raw = screen.locator("[data-now] code").inner_text()
        screen.locator("form input").fill(analyser[raw])
        screen.locator("form [type=submit]").click()
        expect(
            screen.locator("[data-proposal]").or_(screen.locator(".notice.signal-ok"))
        ).to_be_visible()
        if screen.locator(".notice.signal-ok").count():
            break
        assert violations(tab) == []
        screen.locator(".notice button").first.click()
        expect(screen.locator("form")).to_be_visible()
        expect(screen.locator("[data-now] code")).not_to_have_text(raw)
    expect(screen.locator("[data-now] code")).not_to_have_text("88")
    assert tab.page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
    back = screen.get_by_role("button", name="0.469" if locale == "en-GB" else "0,469")
    back.click()
    expect(back).to_have_count(0)
    expect(screen.locator("[data-now] code")).to_have_text("88")
    done = [it for it in idle.get("/journal")["entries"] if it["state"] == "done"]
    assert (done[0]["after"], done[-1]["before"]) == ("88", "88")
