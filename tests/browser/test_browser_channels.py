"""A channel's card, opened by one touch; and channels of one's own, made in the page."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from playwright.sync_api import expect

AXE = Path(find_spec("axe_playwright_python").origin).parent / "axe.min.js"


def violations(tab) -> list[str]:
    """What axe has against the page as it is."""
    tab.page.evaluate(AXE.read_text("utf-8"))
    found = tab.page.evaluate("() => axe.run(document, {resultTypes: ['violations']})")
    return [each["id"] for each in found["violations"]]


def sheet(tab):
    return tab.page.get_by_role("dialog")


def field(tab, label):
    return sheet(tab).get_by_label(label)


def test_a_value_leads_to_its_card_and_limits_are_kept(own, visitor):
    own.samples()
    own.nobody_controls()
    tab = visitor(own.url).show("faults")
    opener = tab.find(".reading", has_text="Intake air temperature").first
    opener.focus()
    tab.page.keyboard.press("Enter")
    card = sheet(tab)
    expect(card.locator("[data-raw]")).to_contain_text("3C, that is 20 °C")
    expect(card.locator("li.stored")).to_contain_text("17")
    expect(card.get_by_text("b − 40")).to_be_visible()
    assert violations(tab) == []

    # A limit of one's own alarms at once, and is in the file that all commands read.
    field(tab, "Warning above").fill("15,5")
    field(tab, "Gauge from").fill("-20")
    card.get_by_role("button", name="Save").click()
    expect(card.locator(".beyond")).to_have_text("Above the limit 15.5 °C: warning")
    file = own.dashboard.catalogs.own.path
    assert "warning_high = 15.5" in file.read_text("utf-8")
    assert "gauge = [-20, 100]" in file.read_text("utf-8")
    field(tab, "Danger above").fill("a lot")
    card.get_by_role("button", name="Save").click()
    expect(card.get_by_role("alert")).to_contain_text("“a lot” is not a number")
    field(tab, "Danger above").fill("3")
    tab.refused = True
    card.get_by_role("button", name="Save").click()
    expect(tab.page.locator("body")).to_contain_text("must be above")
    card.get_by_role("button", name="As shipped").click()
    expect(card.locator(".beyond")).to_have_count(0)
    expect(field(tab, "Warning above")).to_have_value("")
    tab.page.keyboard.press("Escape")
    expect(card).to_have_count(0)
    expect(opener).to_be_focused()


def test_a_channel_of_ones_own_is_made_and_drawn(own, visitor):
    own.samples()
    own.nobody_controls()
    tab = visitor(own.url).show("chart")
    tab.press("Traces…")
    sheet(tab).get_by_role("button", name="Add").first.click()
    sheet(tab).get_by_role("button", name="New channel…").click()
    editor = tab.page.get_by_role("dialog", name="New channel")
    lacking = editor.get_by_text("To save it, fill in:")
    expect(lacking).to_have_text("To save it, fill in: Name, Name in formulas, Formula")
    editor.get_by_label("Name", exact=True).fill("Double voltage")
    editor.get_by_label("Name in formulas").fill("twice")
    expect(lacking).to_have_text("To save it, fill in: Formula")
    formula = editor.get_by_role("textbox", name="Formula", exact=True)
    formula.press_sequentially("2 * uac")
    expect(editor.get_by_role("option").first).to_contain_text("UACC")
    formula.press("Enter")
    expect(formula).to_have_value("2 * UACC")
    trial = editor.locator("[data-trial]")
    expect(trial).to_contain_text("27.6")
    expect(lacking).to_have_count(0)
    formula.press_sequentially(" + k % 3")
    expect(editor.locator("mark")).to_have_text("%")
    save = editor.get_by_role("button", name="Save")
    expect(save).to_be_disabled()
    formula.fill("2 * UACC + k")
    expect(editor.get_by_text("names K, which does not exist")).to_be_visible()
    editor.get_by_text("Constants").click()
    editor.get_by_role("button", name="Add a constant").click()
    editor.get_by_label("Name of the constant").fill("k")
    editor.get_by_label("Its value").fill("0,4")
    expect(trial).to_contain_text("28.0")
    editor.get_by_label("Unit").fill("V")
    assert violations(tab) == []
    save.click()
    expect(editor).to_have_count(0)
    if sheet(tab).count():
        tab.page.keyboard.press("Escape")
    expect(tab.traced("TWICE")).to_have_text("28.0")
    text = own.dashboard.catalogs.own.path.read_text("utf-8")
    assert "[derived.TWICE]" in text
    assert 'unit = "V"' in text

    # Its card edits it.
    tab.button("About Double voltage").click()
    expect(sheet(tab).get_by_text("2 * UACC + k")).to_be_visible()
    sheet(tab).get_by_role("button", name="Edit the channel…").click()
    editor = tab.page.get_by_role("dialog", name="Channel TWICE")
    editor.get_by_role("textbox", name="Formula", exact=True).fill("10 * UACC")
    expect(editor.locator("[data-trial]")).to_contain_text("138.0")
    editor.get_by_role("button", name="Save").click()
    expect(editor).to_have_count(0)
    tab.page.keyboard.press("Escape")
    expect(tab.traced("TWICE")).to_have_text("138.0")
    tab.button("About Double voltage").click()
    sheet(tab).get_by_role("button", name="Edit the channel…").click()
    editor = tab.page.get_by_role("dialog", name="Channel TWICE")
    tab.page.set_viewport_size({"width": 1280, "height": 600})
    editor.get_by_role("button", name="Delete").click()
    expect(editor.get_by_role("button", name="Delete it")).to_be_in_viewport()
    tab.refused = True  # the card may have asked for the value just before
    editor.get_by_role("button", name="Delete it").click()
    expect(editor).to_have_count(0)
    tab.says("Channel deleted: TWICE")
    expect(tab.traced("TWICE")).to_have_count(0)
    own.until(lambda: "TWICE" not in [it["name"] for it in own.state()["plan"]["wanted"]])


def test_the_card_of_a_recording_has_its_moment_and_the_present_catalog(own, visitor):
    own.samples()
    own.post("/recording/start", {"name": "drive"})
    own.until(lambda: (own.state()["recording"] or {"samples": 0})["samples"] > 30)
    own.garage.set("TWAT", "7A")
    own.until(lambda: own.get("/channels/TWAT/value")["value"] == 82)
    own.post("/recording/stop")
    own.garage.set("TWAT", "5F")
    tab = visitor(own.url).show("recordings")
    tab.press("Open")
    tab.page.get_by_role("region", name="Player").get_by_role("slider").press("Home")
    tab.show("chart")
    tab.button("About Coolant temperature").click()
    expect(sheet(tab).locator("[data-raw]")).to_have_text("7F, that is 87 °C")
    # Another client changes a limit and adds a channel: the open card and recording have both.
    limits = {"warning_high": 80, "danger_high": None, "hysteresis": 0}
    own.api.put("/api/channels/TWAT/keys", json={"limits": limits}).raise_for_status()
    expect(sheet(tab).locator(".beyond")).to_have_text("Above the limit 80 °C: warning")
    channel = {"formula": "TWAT + 1", "text": {"en": "One more", "ru": "x"}, "new": True}
    own.api.put("/api/channels/MORE", json=channel).raise_for_status()
    tab.until("() => document.querySelector('[data-raw]').textContent.startsWith('7F')")
    expect(sheet(tab).locator("[data-raw]")).to_have_text("7F, that is 87 °C")
