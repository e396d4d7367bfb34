"""Actions on conditions in the page: made, tried, done with sound, voice and a marker; a phone."""

from __future__ import annotations

from playwright.sync_api import expect

from browser.test_browser_channels import violations

HEARD = """
window.said = []
window.rung = 0
speechSynthesis.speak = words => window.said.push([words.lang, words.text])
const start = OscillatorNode.prototype.start
OscillatorNode.prototype.start = function (...when) {
  window.rung++
  return start.apply(this, when)
}
"""


def sheet(tab):
    return tab.page.get_by_role("dialog").last


def test_an_action_sounds_speaks_and_marks_a_recording_that_it_has_started(own, visitor):
    own.nobody_controls()
    tab = visitor(own.url)
    tab.page.add_init_script(HEARD)
    tab.show("live")
    tab.press("Actions on conditions")
    assert violations(tab) == []
    tab.press("New action…")
    form = sheet(tab)
    form.get_by_label("Name").fill("warm")
    form.get_by_label("When").fill("TWAT >")
    expect(form).to_contain_text("not a formula")
    expect(form.get_by_role("button", name="Save")).to_be_disabled()
    form.get_by_label("When").fill("FREQ > 100")
    expect(form.locator("[data-trial]")).to_contain_text("It holds now.")
    form.get_by_label("Holds for, s").fill("1")
    form.get_by_label("Marker").fill("runs at {FREQ}")
    form.get_by_label("Recording").select_option(label="start the recording")
    form.get_by_label("Say").fill("The engine runs")
    form.get_by_label("Sound").check()
    assert violations(tab) == []
    form.get_by_role("button", name="Save").click()
    expect(sheet(tab).locator("[data-action=warm]")).to_contain_text("FREQ > 100")
    tab.is_line("recording")
    tab.until("() => window.rung >= 2")
    assert tab.page.evaluate("() => window.said") == [["en-GB", "The engine runs"]]
    tab.says("Action warm: FREQ > 100")

    # Switched off on this page, it is quiet, and still does the rest.
    sheet(tab).get_by_label("Sound and voice on this page").uncheck()
    tab.page.evaluate("() => { window.said = []; window.rung = 0 }")
    tab.press("Do it now")
    expect(tab.page.get_by_text("Done as a trial: warm")).to_be_visible()
    assert tab.page.evaluate("() => [window.said, window.rung]") == [[], 0]
    tab.page.keyboard.press("Escape")
    expect(tab.page.get_by_role("dialog")).to_have_count(0)
    labels = [
        e["label"] for e in own.get("/history?seconds=600")["events"] if e["kind"] == "marker"
    ]
    assert len(labels) == 2
    assert all(label.startswith("runs at ") for label in labels)


def test_on_a_phone_the_actions_are_behind_more_and_fit(dash, visitor):
    tab = visitor(dash.url, viewport={"width": 390, "height": 844}).show("live")
    tab.page.get_by_role("button", name="More").click()
    tab.page.get_by_role("button", name="Actions on conditions").click()
    tab.press("New action…")
    expect(sheet(tab).get_by_label("Name")).to_be_visible()
    assert tab.page.evaluate("() => document.documentElement.scrollWidth - innerWidth") <= 0
    assert violations(tab) == []
