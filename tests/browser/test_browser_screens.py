"""All screens: no findings of axe, nothing on the console, nothing wider than a phone; and pictures
of each in both themes and languages, in build/screenshots or `MIKAS_SCREENSHOTS`. Their views and
sheets: test_browser_actions.py.
"""

from __future__ import annotations

import os
from importlib.util import find_spec
from pathlib import Path

import pytest
from playwright.sync_api import expect

from browser.rig import SCREENS

THERE = {  # what a screen shows once it has what it shows
    "live": '[data-value="FREQ"]',
    "chart": ".panes canvas",
    "faults": "ol.cards article",
    "tests": "[data-test]",
    "causes": "[data-verdict]",
    "passport": "dl, table",
    "memory": '[role="grid"]',
    "recordings": "tbody tr",
    "report": "iframe",
    "connection": ".columns",
}
TOLD = """() => [...document.querySelectorAll("#screen [data-value], #screen [data-trace]")]
  .every((it) => !/^\\s*–/.test(it.textContent) && (!it.dataset.trace || it.querySelector("b")))"""
"""Whether all values that have a place on the screen are there: asked for, and come."""
IN_THEME = """async theme => {
  const button = document.querySelector("header .right button:not([lang], .keys)")
  if (document.documentElement.dataset.theme !== theme) button.click()
  await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))
}"""
"""Also under a sheet, where a person can't press the button. Charts are drawn in the next frame."""
AXE = Path(find_spec("axe_playwright_python").origin).parent / "axe.min.js"
PICTURES = Path(
    os.environ.get("MIKAS_SCREENSHOTS")
    or Path(__file__).parent.parent.parent / "build" / "screenshots"
)


@pytest.fixture(scope="module")
def lived_in(served):
    """A program that has a recording and a dump to show."""
    served.post("/recording/start", {"name": "Волга"})
    served.post("/recording/marker", {"label": "knock"})
    served.post("/dumps", {"space": "xram", "first": 0x8000, "last": 0x80FF})
    served.until(lambda: served.get("/dumps")["dumps"][0]["state"] == "done")
    served.post("/recording/stop")
    return served


def there(tab, screen):
    """Goes to a screen and waits until it shows what it shows."""
    tab.show(screen)
    if screen == "memory":
        tab.page.get_by_role("tab", name="XRAM").click()
        tab.find(".bar input").first.fill("8000")
        tab.find(".bar [type=submit]").click()
    expect(tab.find(f"#screen {THERE[screen]}").first).to_be_visible()
    expect(tab.find("#screen [aria-busy=true]")).to_have_count(0)
    tab.until(TOLD)
    if screen == "report":
        expect(tab.page.frame_locator("iframe").locator("h1")).to_be_visible()


def violations(tab, name):
    """What axe has against the page as it is."""
    found = tab.page.evaluate("axe.run(document, {iframes: false, resultTypes: ['violations']})")
    return {
        f"{name}: {it['id']}": [node["html"] for node in it["nodes"]] for it in found["violations"]
    }


def in_each_theme(tab, name, *, axe=True):
    """Photograph the page by day and by night; return what axe has against it."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    if axe:
        tab.page.evaluate(f"() => {{ if (!window.axe) {{ {AXE.read_text('utf-8')} }} }}")
    findings = {}
    for theme in ("night", "day"):
        tab.page.evaluate(IN_THEME, theme)
        findings |= violations(tab, f"{name}, {theme}") if axe else {}
        tab.page.screenshot(path=PICTURES / f"{name}-{theme}.png")
    return findings


@pytest.mark.parametrize("language", ["en", "ru"])
def test_every_screen_by_day_and_night_in_each_language(lived_in, visitor, language):
    """Photographed; axe has nothing against any: its rules ask for no language."""
    lived_in.nobody_controls()
    tab = visitor(lived_in.url, locale={"en": "en-GB", "ru": "ru-RU"}[language])
    findings = {}
    for screen in SCREENS:
        there(tab, screen)
        findings |= in_each_theme(tab, f"{screen}-{language}", axe=language == "en")
    assert findings == {}


def test_nothing_is_wider_than_a_phone(lived_in, visitor):
    lived_in.nobody_controls()
    tab = visitor(lived_in.url, viewport={"width": 390, "height": 844}, locale="ru-RU")
    wide = {}
    for screen in SCREENS:
        there(tab, screen)
        tab.page.screenshot(path=PICTURES / f"{screen}-ru-phone.png")
        wide[screen] = tab.page.evaluate(
            """() => [...document.querySelectorAll("html, #screen, #screen *")].filter((it) => {
                 if (!it.matches("html, #screen") && !it.closest("#screen")) return false;
                 return it.getBoundingClientRect().right > innerWidth + 1 && !inside(it);
                 function inside(it) {
                   for (let up = it.parentElement; up && up.id !== "screen"; up = up.parentElement)
                     if (/auto|scroll|hidden/.test(getComputedStyle(up).overflowX)) return true;
                   return false;
                 }
               }).map((it) => it.outerHTML.slice(0, 200))"""
        )
    assert {screen: found for screen, found in wide.items() if found} == {}
