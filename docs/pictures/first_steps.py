"""Take the pictures of the owner's first steps on the page without installation, in both languages.

The page is build/site (make site), in Chromium on a computer with a fake adapter, as in
tests/static_site: that needs Linux and root. One tab does the steps; at each of them it is shown in
both languages. Run from the repository's root, with the tests' rigs on the path:
PYTHONPATH=tests python docs/pictures/first_steps.py [NAME …]
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import few_colours
from playwright.sync_api import sync_playwright

from browser.chromium_rig import installed, launched
from static_site import computer_rig
from static_site.pages_rig import StaticHost
from static_site.site_rig import BUILT, PORT, SiteTab, missing, site_tab
from static_site.wire_rig import cable

FOLDER = Path(__file__).parent
SIZE = {"width": 1280, "height": 720}
LANGUAGES = ("ru", "en")  # the tab goes on in the last one
WATCHED = 25  # s: the small lines on the gauges have a course
COMPUTED = re.compile("Virtual car, warm idle|Виртуальный автомобиль, прогрет")
RECORDED = 75  # s: enough of warm idle for causes

Step = Callable[[], None]


class Pictures:
    """Takes those that are wanted, of what the tab shows."""

    def __init__(self, tab: SiteTab, wanted: list[str]) -> None:
        self._tab, self._wanted = tab, wanted

    def take(self, name: str, screen: str = "", again: Step | None = None) -> None:
        """Take it in both languages.

        `screen`: to be opened for each; `again`: the step to be done for each.
        """
        if self._wanted and name not in self._wanted:
            return
        page, shots = self._tab.page, {}
        for language in LANGUAGES:
            button = page.locator(f"header button[lang={language}]")
            if button.count():
                button.click()
            page.locator(f"html[lang={language}]").wait_for(state="attached")
            if screen:
                self._tab.show("live")
                self._tab.show(screen)
                page.locator("#screen iframe, #screen [data-verdict]").first.wait_for()
                page.wait_for_function("() => !document.querySelector('#screen [aria-busy=true]')")
            if page.locator("iframe").count():
                page.frame_locator("iframe").locator("h1").wait_for()
            if again:
                again()
            page.mouse.move(640, 718)
            page.wait_for_timeout(500)
            shots[language] = page.screenshot()
            if again:
                page.keyboard.press("Escape")
        for language, shot in shots.items():  # afterwards: a message is shown for seconds only
            out = FOLDER / language / f"{name}.png"
            few_colours.write(shot, out)
            print(out, out.stat().st_size, file=sys.stderr)


def virtual_car(tab: SiteTab, pictures: Pictures) -> None:
    """From the first visit to the gauges, and the card of a value."""
    tab.show("connection")
    tab.says("Start the virtual car")
    pictures.take("first-open")
    tab.press("Start the virtual car")
    tab.value("FREQ").wait_for()
    tab.page.wait_for_timeout(WATCHED * 1000)
    pictures.take("first-gauges")
    pictures.take("card", again=lambda: open_card(tab, "TWAT"))


def open_card(tab: SiteTab, name: str) -> None:
    """Touch the value's tile."""
    tab.page.locator(f'[data-opens="{name}"]').first.click()
    tab.page.get_by_role("dialog").get_by_text(COMPUTED).wait_for()  # comes last


def defect(tab: SiteTab, pictures: Pictures) -> None:
    """A car whose throttle does not close, recorded while it idles."""
    tab.show("connection")
    tab.page.get_by_text("Choose a car and its defect").click()
    form = tab.page.locator("form", has=tab.button("Start this car"))
    form.get_by_role("combobox", name="Defect").select_option(label="Throttle does not close")
    form.get_by_role("combobox", name="Drive").select_option("warm-idle")
    form.scroll_into_view_if_needed()
    pictures.take("first-defect")
    tab.press("Start this car")
    tab.is_line("sampling")
    tab.show("live")
    tab.record()
    tab.page.wait_for_timeout(RECORDED * 1000)
    tab.recorded(RECORDED)
    pictures.take("first-record")
    tab.stop_recording()
    tab.page.get_by_role("button", name="Open", exact=True).wait_for()
    pictures.take("first-saved")
    tab.page.get_by_role("button", name="Open", exact=True).click()
    tab.page.get_by_role("slider", name="Position in the recording").wait_for()
    tab.show("chart")
    tab.page.locator(".panes canvas").first.wait_for()
    tab.page.keyboard.press("Space")
    tab.page.wait_for_timeout(8000)
    tab.page.keyboard.press("Space")
    pictures.take("first-chart")


def answers(tab: SiteTab, pictures: Pictures) -> None:
    """The causes and the report of the recording."""
    tab.show("causes")
    tab.page.locator("[data-verdict]").wait_for()
    tab.press("idles high")
    tab.page.locator("[data-cause]").first.wait_for()
    tab.page.wait_for_timeout(3000)
    pictures.take("causes", "causes")
    pictures.take("first-report", "report")
    tab.press("Back to live")


def main(wanted: list[str]) -> None:
    """Do the steps, and take the pictures that are named, or all."""
    program = installed()
    if not program or (why := missing() or computer_rig.missing()):
        raise SystemExit(why if program else "Chromium is not installed")
    with (
        tempfile.TemporaryDirectory() as folder,
        computer_rig.computer() as computer,
        sync_playwright() as playwright,
        launched(playwright, computer.wrapper(program, Path(folder))) as browser,
        ExitStack() as ending,
    ):
        host = StaticHost(computer, BUILT)
        ending.callback(host.stop)
        context = browser.new_context(
            locale="en-GB", viewport=SIZE, color_scheme="light", reduced_motion="reduce"
        )
        with site_tab(context, host.url) as tab:
            tab.open("connection")
            pictures = Pictures(tab, wanted)
            virtual_car(tab, pictures)
            defect(tab, pictures)
            answers(tab, pictures)
            with cable(computer, Path(folder)):
                tab.show("connection")
                tab.press(f"Connect to {PORT}")
                tab.says("The ECU answers")
                tab.is_line("sampling")
                pictures.take("first-cable")


if __name__ == "__main__":
    main(sys.argv[1:])
