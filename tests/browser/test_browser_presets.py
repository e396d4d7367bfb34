"""A preset of one's own: added to, put in order by keys and hand, kept over a reload, deleted."""

from __future__ import annotations

from playwright.sync_api import expect


def stand(tab, *first, count=None):
    """Waits until these tiles are the first, or all there are."""
    tab.until(
        """([first, count]) => {
          const names = [...document.querySelectorAll("[data-tile]")].map((it) => it.dataset.tile);
          return first.every((it, at) => it === names[at]) && [null, names.length].includes(count);
        }""",
        [first, count],
    )


def tiles(tab):
    return tab.page.locator("[data-tile]").evaluate_all("all => all.map(it => it.dataset.tile)")


def test_a_preset_is_made_kept_and_deleted(dash, visitor):
    tab = visitor(dash.url).show("live")
    tab.is_line("sampling")
    tab.press("Edit")
    expect(tab.page.locator(".grip").first).to_be_visible()
    first, second, third = tiles(tab)[:3]

    tab.press("Add…")
    sheet = tab.page.get_by_role("dialog")
    sheet.get_by_role("searchbox").fill("intake")
    expect(sheet.locator("li")).to_have_count(1)
    expect(sheet.locator(".cost")).to_contain_text("readings/s")  # what it would cost
    sheet.locator("li button").click()
    tab.page.keyboard.press("Escape")
    expect(tab.page.locator('[data-tile="TAIR"]')).to_be_visible()

    grips = tab.page.locator(".grip")
    grips.first.press("ArrowRight")
    stand(tab, second, first, third)
    grips.nth(2).drag_to(tab.page.locator(f'[data-tile="{second}"]'))
    stand(tab, third)

    order = tiles(tab)
    tab.page.get_by_label("Name of the preset").fill("Winter")
    tab.press("Save")
    expect(tab.page.get_by_role("tab", name="Winter")).to_have_attribute("aria-selected", "true")
    stand(tab, *order, count=len(order))
    expect(tab.value("TAIR")).not_to_have_text("–")  # what is shown is asked

    tab.page.reload()
    expect(tab.page.get_by_role("tab", name="Winter")).to_have_attribute("aria-selected", "true")
    stand(tab, *order, count=len(order))

    tab.press("Edit")
    tab.press("Delete preset")
    tab.page.get_by_role("dialog").get_by_role("button", name="Delete", exact=True).click()
    expect(tab.page.get_by_role("tab", selected=True)).to_be_visible()  # no longer edited
    expect(tab.page.get_by_role("tab", name="Winter")).to_have_count(0)
    assert [preset["id"] for preset in dash.get("/presets")["presets"]] == []


def test_damaged_presets_are_reported(own, visitor):
    presets = own.dashboard.settings.in_state("presets.json")
    presets.parent.mkdir(exist_ok=True)
    presets.write_text("[[", "utf-8")
    tab = visitor(own.url).show("live")
    tab.says("presets.json: the content is damaged, nothing of it is used")
