"""Search in what the chart shows: live, and in a recording; conditions are kept by the program."""

from __future__ import annotations

from playwright.sync_api import expect


def search(tab, expression: str) -> None:
    tab.page.keyboard.press("/")
    field = tab.page.get_by_label("Condition")
    field.fill(expression)
    field.press("Enter")


def test_moments_are_found_marked_and_gone_through(own, visitor):
    own.post("/recording/start", {"name": "hot"})
    for raw, coolant in (("7F", 87), ("8F", 103), ("7F", 87), ("91", 105), ("7F", 87)):
        own.garage.set("TWAT", raw)
        own.until(
            lambda value=coolant: own.get("/history?seconds=1&names=TWAT")["values"][0][-1] == value
        )
    own.post("/recording/stop")
    tab = visitor(own.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    search(tab, "TWAT > 100 and FREQ > 0")
    found = tab.page.get_by_role("group", name="Moments")
    expect(found).to_contain_text("TWAT > 100 and FREQ > 0 (Coolant temperature up to 105)")
    expect(found.get_by_role("status")).to_contain_text("1 of 2")
    expect(tab.traced("TWAT")).to_have_text("103")
    tab.page.keyboard.press("j")
    expect(found.get_by_role("status")).to_contain_text("2 of 2")
    expect(tab.traced("TWAT")).to_have_text("105")

    tab.show("recordings")
    tab.find("tbody tr").get_by_role("button", name="Open", exact=True).click()
    expect(tab.page.get_by_role("slider", name="Position in the recording")).to_be_visible()
    tab.show("chart")
    search(tab, "TWAT > 104")
    expect(found).to_contain_text("TWAT > 104 (Coolant temperature up to 105)")
    expect(found.get_by_role("status")).to_contain_text("1 of 1")


def test_a_wrong_condition_says_why_and_a_good_one_is_kept(dash, visitor):
    tab = visitor(dash.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.refused = True
    sheet = tab.page.get_by_role("dialog")
    tab.page.keyboard.press("/")
    tab.page.keyboard.type("FREK > 100")
    expect(tab.page.get_by_label("Condition")).to_have_value("FREK > 100")
    tab.page.keyboard.press("Enter")
    expect(sheet.locator(".problem")).to_contain_text("Did you mean FREQ")
    search_field = tab.page.get_by_label("Condition")
    search_field.fill("TWAT > 119")
    search_field.press("Enter")
    expect(sheet).to_contain_text("At no moment: TWAT > 119")
    sheet.get_by_role("button", name="Save this condition").click()
    expect(sheet.get_by_role("button", name="Save this condition")).to_have_count(0)
    tab.page.reload()
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.page.keyboard.press("/")
    expect(sheet.get_by_role("button", name="TWAT > 119", exact=True)).to_be_visible()
    sheet.get_by_role("button", name="Delete TWAT > 119").click()
    expect(sheet.get_by_role("button", name="TWAT > 119", exact=True)).to_have_count(0)
    assert dash.get("/searches") == {"searches": []}
