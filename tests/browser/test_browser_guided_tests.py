"""Guided tests: started, followed step by step, judged, put into the report, repeated."""

from __future__ import annotations

import re

from playwright.sync_api import expect

QUICK = """
title = { en = "Quick", ru = "Быстрая" }
finds = { en = "A low voltage.", ru = "Низкое напряжение." }
chart = ["FREQ"]

[step.run]
text = { en = "Let it run.", ru = "Пусть работает." }
until = "FREQ > 300"
hold = 2
watch = ["UACC"]
target.UACC = [14, 14.5]

[step.stop]
text = { en = "Switch it off.", ru = "Заглушите." }
until = "FREQ < 40"
advice = { en = "It still runs.", ru = "Ещё работает." }
timeout = 1

[measure.VOLTAGE]
step = "run"
of = "UACC"
statistic = "median"
text = { en = "Voltage", ru = "Напряжение" }

[rule.low]
when = "VOLTAGE < 14"
verdict = "bad"
confidence = "high"
text = { en = "Only {VOLTAGE}.", ru = "Только {VOLTAGE}." }
check = { en = "Check the belt.", ru = "Проверьте ремень." }
"""


def test_a_test_of_the_users_own_from_start_to_report(own, visitor):
    folder = own.dashboard.settings.tests
    folder.mkdir()
    # Their clock runs 20 times as fast: two seconds may pass between two looks at the page.
    (folder / "quick.toml").write_text(QUICK.replace("hold = 2", "hold = 30"), "utf-8")
    (folder / "wrong.toml").write_text(QUICK.replace("hold = 2", "holds = 2"), "utf-8")
    tab = visitor(own.samples().url).show("tests")
    expect(tab.find("[data-test]")).to_have_count(8)
    tab.says("A test could not be loaded")
    expect(tab.find(".notice")).to_contain_text("wrong.toml:9")
    tab.find("[data-test=quick]").get_by_role("button", name="Start").click()
    expect(tab.find(".todo")).to_have_text("Let it run.")
    watched = tab.find(".values .low")
    expect(watched).to_contain_text("13.8")
    expect(watched).to_contain_text("should be 14.0 to 14.5")
    expect(tab.find(".where")).to_have_text("Step 2 of 2")
    expect(tab.find(".todo")).to_have_text("Switch it off.")
    tab.says("It still runs.")
    tab.page.reload()
    expect(tab.find(".todo")).to_have_text("Switch it off.")
    tab.press("Skip this step")
    verdict = tab.find("section.verdict")
    expect(verdict).to_contain_text("Bad")
    expect(verdict).to_contain_text("Only 13.8 V.")
    tab.says("Check the belt.")
    tab.says("VOLTAGE < 14")
    tab.press("Add to report")
    expect(tab.button("In the report; remove")).to_be_visible()
    assert "Only 13.8 V." in own.api.get("/api/report?lang=en").text
    tab.press("All tests")
    last = tab.find("[data-test=quick] a.last")
    expect(last).to_contain_text("Bad")
    last.click()
    expect(tab.find("section.verdict")).to_contain_text("Only 13.8 V.")
    assert re.search(r"#/tests/quick-\d+", tab.page.url)
    tab.press("Repeat")
    expect(tab.find(".todo")).to_have_text("Let it run.")
    tab.press("End the test")
    expect(tab.find("[data-test]")).to_have_count(8)


def test_a_test_over_the_recording_that_is_shown(own, visitor):
    folder = own.dashboard.settings.tests
    folder.mkdir()
    quick = QUICK[: QUICK.index("[step.stop]")] + QUICK[QUICK.index("[measure.VOLTAGE]") :]
    (folder / "quick.toml").write_text(quick, "utf-8")
    tab = visitor(own.samples().url).show("report")
    sheet = tab.page.get_by_role("dialog")  # the first report asks once whose car it is
    expect(sheet).to_contain_text("Whose car is this?")
    sheet.get_by_role("button", name="Later").click()
    tab.page.keyboard.press("r")
    expect(tab.button("Stop recording")).to_be_visible()
    before = own.state()["samples"]
    own.until(lambda: own.state()["samples"] > before + 120)
    tab.press("Stop recording")
    listed = tab.show("recordings").page.get_by_role("group", name="Recordings")
    listed.get_by_role("button", name="Open", exact=True).click()  # not the message's
    expect(tab.find('nav a[data-screen="live"]')).to_have_attribute("aria-current", "page")
    tab.show("tests")
    tab.says("The tests look for their steps in the recording")
    tab.find("[data-test=quick]").get_by_role("button", name="Test the recording").click()
    tab.says("This result is not kept")
    expect(tab.find("section.verdict")).to_contain_text("Only 13.8 V.")
    expect(tab.find("section.verdict .when")).to_contain_text(".pcapng, from 00:00 to 00:0")
    expect(tab.button("Add to report")).to_have_count(0)
    assert own.get("/tests/results")["results"] == []
    tab.press("Show in the chart")
    expect(tab.find(".panes .cursor.b").first).to_be_visible()  # where the test ends
    tab.show("tests")
    tab.press("All tests")
    tab.find("[data-test=charging]").get_by_role("button").click()
    tab.says("No verdict from this recording")
    tab.says("the recording does not have what the test begins with")
    tab.press("All tests")
    tab.find(".notice").get_by_role("button", name="Close the recording").click()
    expect(tab.find("[data-test=quick]").get_by_role("button", name="Start")).to_be_enabled()
    tab.show("report")  # not asked again
    expect(tab.find("iframe")).to_be_visible()
    expect(sheet).to_have_count(0)
