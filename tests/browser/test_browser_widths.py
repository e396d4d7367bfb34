"""Nothing is cut: no label, button or field on any screen, in either language, from a phone to a
wide window, with alarms at the gauges; and what a thumb has to hit is large enough for one.
"""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from browser.rig import SCREENS, dashboard
from browser.test_browser_screens import TOLD, there

HEIGHTS = {390: 844, 844: 390, 1280: 800, 1920: 1080}
CUT = r"""
() => {
  const found = [];
  const boxes = "[data-tile], button, a, td, th, li, article, select, header, nav, section";
  const tell = (why, it, text) => found.push(`${why}: ${text} (${it.localName}.${it.className})`);

  /** How the text is cut by what it stands in, up to the next thing that scrolls. */
  function judge(it, text, left, right, top, bottom) {
    for (let up = it; up && up !== document.documentElement; up = up.parentElement) {
      const { display, overflowX, overflowY } = getComputedStyle(up);
      if (up.localName === "dialog") return;
      if (display === "inline" || display === "contents") continue;
      const box = up.getBoundingClientRect();
      const beside = right > box.right + 1 || left < box.left - 1;
      const below = bottom > box.bottom + 4 || top < box.top - 4;
      if (/auto|scroll/.test(overflowX) && beside) return tell("scrolls sideways", it, text);
      if (/auto|scroll/.test(overflowX + overflowY)) return;
      if (/hidden|clip/.test(overflowX) && beside) return tell("cut", it, text);
      if (/hidden|clip/.test(overflowY) && below) return tell("cut below", it, text);
      if (up.matches(boxes) && (beside || below)) return tell("out of its box", it, text);
    }
    if (right > innerWidth + 1 || left < -1) tell("off the screen", it, text);
  }

  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const it = walker.currentNode.parentElement;
    const text = walker.currentNode.data.trim();
    if (!text || it.closest(".visually-hidden, script, option, [role=grid]")) continue;
    if (it.closest("[title]")?.title.includes(text)) continue;  // ends with …, whole in the title
    if (!it.checkVisibility()) continue;
    const range = document.createRange();
    range.selectNodeContents(walker.currentNode);
    const { left, right, top, bottom, width } = range.getBoundingClientRect();
    if (width > 0) judge(it, text, left, right, top, bottom);
  }
  const pen = document.createElement("canvas").getContext("2d");
  for (const field of document.querySelectorAll("input[placeholder], select")) {
    if (!field.checkVisibility()) continue;
    const { font, paddingLeft, paddingRight } = getComputedStyle(field);
    const text = field.selectedOptions?.[0]?.text ?? field.placeholder;
    pen.font = font;
    const taken = pen.measureText(text).width + parseFloat(paddingLeft) + parseFloat(paddingRight);
    if (text && taken > field.clientWidth + 1) tell("cut in a field", field, text);
  }
  return found;
}
"""
"""What is cut of what is on the page now. A memory's bytes keep their columns and may scroll."""
SMALL = r"""
() => [...document.querySelectorAll("header button, tbody button, tbody a, nav a")]
  .filter((it) => it.checkVisibility())
  .map((it) => [it.ariaLabel || it.innerText, it.getBoundingClientRect()])
  .filter(([, { width, height }]) => width < 44 || height < 44)
  .map(([name, { width, height }]) => `${name}: ${width} × ${height}`)
"""

BOXES = """
const box = (it) => it.getBoundingClientRect();
const over = (one, other) => one !== other
  && one.left < other.right - 1 && other.left < one.right - 1
  && one.top < other.bottom - 1 && other.top < one.bottom - 1;
"""
COVERED = f"""() => {{{BOXES}
  const boxes = [...document.querySelectorAll("form, .toast")].map(box);
  return boxes.filter((one) => boxes.some((other) => over(one, other)));
}}"""
"""Messages and fields at the foot of the page that lie over each other."""
OUTSIDE = f"""() => {{{BOXES}
  const sheet = box(document.querySelector("dialog[open]"));
  const fields = [...document.querySelectorAll("dialog[open] :is(input, select, textarea, button)")]
    .map((it) => [it, box(it)])
    .filter(([, place]) => place.width > 0);
  const typed = fields.filter(([it]) => it.localName !== "button").map(([, place]) => place);
  return fields
    .filter(([, {{ left, right }}]) => left < sheet.left || right > sheet.right)
    .map(([it]) => it.outerHTML.slice(0, 90))
    .concat(typed.filter((one) => typed.some((other) => over(one, other))));
}}"""
"""Fields and buttons of a sheet that leave it, and fields that lie over each other."""
UNNAMED = f"""() => {{{BOXES}
  return [...document.querySelectorAll("[data-tile]")].filter((tile) => {{
    const name = box(tile.querySelector(".tools .name"));
    return !name.width || name.bottom > box(tile).bottom
      || [...tile.querySelectorAll(".tools :is(select, button)")].map(box)
        .some((it) => it.bottom > box(tile).bottom + 1 || over(it, name));
  }}).map((tile) => tile.dataset.tile);
}}"""
"""Tiles whose tools lie over their name or leave the tile."""


@pytest.fixture(scope="module")
def alarmed(chromium, tmp_path_factory):
    """A car beyond its limits in coolant and voltage, with unsure faults, and two recordings."""
    with dashboard(tmp_path_factory.mktemp("alarmed")) as dash:
        dash.samples()
        dash.garage.set("TWAT", "9B")  # 115 °C
        dash.garage.set("UACC", "5E")  # 9.4 V
        for name in ("Волга после ремонта генератора", "drive"):
            dash.post("/recording/start", {"name": name})
            dash.until(lambda: dash.state()["recording"]["samples"] > 2)
            dash.post("/recording/stop")
        yield dash


def opened(visitor, dash, language, width, **wishes):
    dash.nobody_controls()
    locale = {"en": "en-GB", "ru": "ru-RU"}[language]
    return visitor(
        dash.url, locale=locale, viewport={"width": width, "height": HEIGHTS[width]}, **wishes
    )


@pytest.mark.parametrize("width", HEIGHTS)
@pytest.mark.parametrize("language", ["en", "ru"])
def test_no_label_is_cut_on_any_preset(alarmed, visitor, language, width):
    tab = opened(visitor, alarmed, language, width).show("live")
    expect(tab.value("TWAT")).to_have_text("115")
    cut = {}
    for name in ("idle", "driving", "fuel", "ignition", "all"):
        if width < 1000:
            tab.find("#screen header select").select_option(name)
        else:
            preset = tab.find(f'#screen [data-id="{name}"]')
            preset.click()
            expect(preset).to_have_attribute("aria-selected", "true")
        if name in ("idle", "driving", "ignition"):
            expect(tab.find("[data-tile=UACC].warning")).to_be_visible()
            expect(tab.find("[data-tile=TWAT].warning")).to_be_visible()
        tab.until(TOLD)
        cut[name] = tab.page.evaluate(CUT)
    assert {preset: found for preset, found in cut.items() if found} == {}


@pytest.mark.parametrize("width", HEIGHTS)
@pytest.mark.parametrize("language", ["en", "ru"])
def test_nothing_is_cut_on_any_other_screen(alarmed, visitor, language, width):
    tab = opened(visitor, alarmed, language, width)
    cut = {}
    for screen in SCREENS:
        if screen != "live":
            there(tab, screen)
            cut[screen] = tab.page.evaluate(CUT)
    assert {screen: found for screen, found in cut.items() if found} == {}


@pytest.mark.parametrize("size", [(390, 844), (844, 390)])
def test_fields_stay_in_their_sheets(alarmed, visitor, size):
    alarmed.nobody_controls()
    viewport = dict(zip(("width", "height"), size, strict=True))
    tab = visitor(alarmed.url, viewport=viewport, has_touch=True).show("memory")
    sheet = tab.page.get_by_role("dialog")
    found = {}

    def look(name):
        expect(sheet).to_be_visible()
        if outside := tab.page.evaluate(OUTSIDE):
            found[name] = outside
        tab.page.keyboard.press("Escape")
        expect(sheet).to_have_count(0)

    tab.press("Add a cell")
    look("cell")
    tab.press("Unlock writing")
    look("unlock")
    tab.show("live").find('[data-opens="TWAT"]').first.click()
    look("card")
    if size == (844, 390):
        tab.press("All tiles")
    tab.press("Edit", exact=True)
    tab.press("Add…")
    look("tile")
    tab.press("Cancel", exact=True)
    tab.show("chart")
    for name in ("Traces…", "Find…", "Statistics…", "Image…"):
        tab.press("More tools")
        tab.find("#screen .menu li").get_by_role("button", name=name).click()
        look(name)
    tab.show("recordings")
    for name in ("Export ", "Compare ", "Car details of ", "Delete "):
        tab.page.get_by_label(re.compile(f"^{name}")).first.click()
        look(name)
    assert found == {}


@pytest.mark.parametrize("language", ["en", "ru"])
def test_a_tile_that_is_edited_shows_its_name(alarmed, visitor, language):
    tab = opened(visitor, alarmed, language, 390).show("live")
    tab.press({"en": "Edit", "ru": "Изменить"}[language], exact=True)
    expect(tab.find(".tools").first).to_be_visible()
    assert tab.page.evaluate(UNNAMED) == []


@pytest.mark.parametrize("language", ["en", "ru"])
def test_recordings_are_cards_on_a_phone_with_all_there_is_to_do(alarmed, visitor, language):
    tab = opened(visitor, alarmed, language, 390, has_touch=True).show("recordings")
    card = tab.find("tbody tr").first
    expect(card).to_contain_text("M71 PROG · 17.3763.000-02")
    expect(card).to_contain_text("drive.pcapng")
    expect(tab.find("thead")).to_have_text("")
    assert tab.page.evaluate(SMALL) == []
    names = {"en": ["Export", "Report on", "Delete"], "ru": ["Экспорт", "Отчёт по", "Удалить"]}
    for name in names[language]:
        expect(card.get_by_label(f"{name} drive.pcapng")).to_be_visible()
    card.get_by_role("button", name={"en": "Open", "ru": "Открыть"}[language]).tap()
    expect(tab.page.get_by_role("slider")).to_be_visible()


@pytest.mark.parametrize("width", HEIGHTS)
@pytest.mark.parametrize("language", ["en", "ru"])
def test_a_recording_is_started_and_ended_by_a_thumb(own, visitor, language, width):
    own.garage.set("UACC", "5E")
    tab = opened(visitor, own, language, width, has_touch=True).show("live")
    expect(tab.find("header .signal")).to_be_visible()  # an alarm: the fullest band there is
    begin = tab.button({"en": "Record", "ru": "Запись"}[language], exact=True)
    assert tab.page.evaluate(SMALL) == []
    begin.tap()
    tab.is_line("recording")
    expect(begin).to_have_count(0)
    end = tab.button({"en": "Stop recording", "ru": "Остановить запись"}[language])
    assert tab.page.evaluate(CUT) == []
    tab.button({"en": "Marker", "ru": "Отметка"}[language], exact=True).tap()
    expect(tab.find("form input[maxlength]")).to_be_visible()
    assert tab.find(".toast").count() > 0
    assert tab.page.evaluate(COVERED) == []
    box = end.bounding_box()
    assert min(box["width"], box["height"]) >= (44 if width < 1000 else 40)
    end.tap()
    tab.is_line("sampling")
    assert len(own.get("/recordings")["recordings"]) == 1
