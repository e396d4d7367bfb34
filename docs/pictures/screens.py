"""Take the pictures of the dashboard's screens, in both languages, into en and ru beside this file.

A virtual car drives in town for a minute and a half, is recorded, and has two stored faults. Run
from the repository's root, with Chromium installed: python docs/pictures/screens.py [NAME …]
"""

from __future__ import annotations

import sys
import time

import served_car
from served_car import LYING, PHONE, Tab, ask

SECONDS = 62  # after that the car drives, and the chart of a minute is full
FAULTS = "17,41"
THERE = {  # what a screen shows once it has what it shows
    "live": '[data-value="FREQ"]',
    "chart": ".panes canvas",
    "faults": "ol.cards article",
    "test-list": "[data-test]",
    "passport": "dl, table",
    "memory": '[role="grid"]',
    "recordings": "tbody tr",
    "report": "iframe",
    "connection": ".columns",
}
ADDRESSES = {"test-list": "tests"}


def show(tab: Tab, screen: str) -> None:
    """Go to a screen, and wait until it shows what it shows."""
    tab.show(ADDRESSES.get(screen, screen))
    if screen == "memory":
        tab.page.get_by_role("tab", name="XRAM").click()
        tab.page.locator(".bar input").first.fill("8000")
        tab.page.locator(".bar [type=submit]").click()
    tab.page.locator(f"#screen {THERE[screen]}").first.wait_for()
    tab.page.wait_for_function("() => !document.querySelector('#screen [aria-busy=true]')")
    if screen == "report":
        tab.page.frame_locator("iframe").locator("h1").wait_for()


def other_car(scenario: str) -> None:
    """Have another virtual car on the line, with the same faults."""
    ask("/control/take", {"force": True})
    ask("/connect", {"port": served_car.car(f"{scenario}&faults={FAULTS}")})
    ask("/control/release")


def guided_test(tab: Tab) -> None:
    """Take the picture of a guided test."""
    ask("/control/take", {"force": True})  # from the tab before
    ask("/control/release")
    show(tab, "test-list")
    tab.page.locator("[data-test=idle] button").first.click()
    tab.page.locator(".todo").wait_for()
    tab.page.wait_for_timeout(4000)
    tab.take("tests")
    tab.press("End the test", "Прервать проверку")
    tab.page.locator(".todo").wait_for(state="detached")


def on_a_phone(tab: Tab) -> None:
    """Take the pictures of a phone, upright and lying on its side."""
    tab.page.set_viewport_size(PHONE)
    show(tab, "live")
    tab.take("phone")
    tab.page.set_viewport_size(LYING)
    tab.page.keyboard.press("b")  # as a phone that lies on its side does by itself
    tab.page.locator("#screen .big [data-value]").first.wait_for()
    tab.take("phone-lying")


def main(wanted: list[str]) -> None:
    """Take all pictures, or those of the screens that are named."""
    with (
        served_car.program(f"warm-idle&faults={FAULTS}"),
        served_car.tabs(wanted) as tabs,
    ):
        for tab in tabs:
            guided_test(tab)
        other_car("city")
        ask("/control/take", {"force": True})
        ask("/recording/start")
        time.sleep(SECONDS)  # the real program drives in real time: charts are to be full
        for screen in THERE:
            if screen == "memory":
                ask("/recording/stop")
                ask("/control/release")
            for tab in tabs:
                show(tab, screen)
                tab.take(screen)
        for tab in tabs:
            on_a_phone(tab)


if __name__ == "__main__":
    main(sys.argv[1:])
