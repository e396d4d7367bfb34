"""Take the pictures of the dashboard's screens, in both languages, into en and ru beside this file.

A virtual car drives in town for a minute and a half, is recorded, and has two stored faults. Run
from the repository's root, with Chromium installed: python docs/pictures/screens.py [NAME …]
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import few_colours
from playwright.sync_api import Page, sync_playwright

FOLDER = Path(__file__).parent
LOCALES = {"en": "en-GB", "ru": "ru-RU"}
SIZE = {"width": 1280, "height": 720}
PHONE = {"width": 390, "height": 844}
LYING = {"width": 844, "height": 390}
SECONDS = 62  # after that the car drives, and the chart of a minute is full
PORT = 8079
FAULTS = "17,41"
ADDRESS = f"http://127.0.0.1:{PORT}"
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


@contextmanager
def demo(folder: str) -> Iterator[None]:
    """Run the program with a virtual car."""
    command = [
        sys.executable, "-m", "mikas", "demo", "--scenario", "city", "--faults", FAULTS,
        "--host-port", str(PORT), "--no-browser", "--record", folder,
    ]  # fmt: skip
    own = os.environ | {"MIKAS_STATE": f"{folder}-state"}  # nothing of the user's on the pictures
    out = subprocess.PIPE
    with subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, env=own) as program:
        assert program.stdout
        program.stdout.readline()  # its address: it listens
        try:
            yield
        finally:
            program.terminate()


def ask(path: str, body: object) -> None:
    """Ask the program for something, as one more client."""
    headers = {"Content-Type": "application/json", "X-Mikas-Client": "pictures-0001"}
    request = urllib.request.Request(
        f"{ADDRESS}/api{path}", json.dumps(body).encode(), headers, method="POST"
    )
    urllib.request.urlopen(request).close()


def show(page: Page, screen: str) -> None:
    """Go to a screen, and wait until it shows what it shows."""
    page.evaluate("where => { location.hash = where }", f"/{ADDRESSES.get(screen, screen)}")
    if screen == "memory":
        page.get_by_role("tab", name="XRAM").click()
        page.locator(".bar input").first.fill("8000")
        page.locator(".bar [type=submit]").click()
    page.locator(f"#screen {THERE[screen]}").first.wait_for()
    page.wait_for_function("() => !document.querySelector('#screen [aria-busy=true]')")
    if screen == "report":
        page.frame_locator("iframe").locator("h1").wait_for()


def take(page: Page, language: str, name: str, wanted: list[str]) -> None:
    """Take the picture of what the page shows, if it is wanted."""
    if not wanted or name in wanted:
        few_colours.write(page.screenshot(), FOLDER / language / f"{name}.png")


def other_car(scenario: str) -> None:
    """Have another virtual car on the line, with the same faults."""
    ask("/control/take", {"force": True})
    ask("/connect", {"port": f"sim:?scenario={scenario}&faults={FAULTS}"})
    ask("/control/release", {})


def guided_test(first: Page, wanted: list[str]) -> None:
    """Take the pictures of a guided test."""
    show(first, "test-list")
    first.locator("[data-test=idle] button").first.click()
    first.locator(".todo").wait_for()
    first.wait_for_timeout(4000)
    take(first, "en", "tests", wanted)
    first.locator("header button[lang=ru]").click()
    first.get_by_role("button", name="Прервать проверку").wait_for()
    take(first, "ru", "tests", wanted)
    first.locator("header button[lang=en]").click()
    first.get_by_role("button", name="End the test").click()
    first.locator(".todo").wait_for(state="detached")


def main(wanted: list[str]) -> None:
    """Take all pictures, or those of the screens that are named."""
    program = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))))
    folder = "/tmp/mikas"  # it is on a picture
    for left in (folder, f"{folder}-state"):
        shutil.rmtree(left, ignore_errors=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        with demo(folder):
            tabs: dict[str, Page] = {}
            for language, locale in LOCALES.items():
                context = browser.new_context(
                    locale=locale, viewport=SIZE, color_scheme="light", reduced_motion="reduce"
                )
                tabs[language] = context.new_page()
                tabs[language].goto(f"{ADDRESS}/#/live")
                tabs[language].locator('#screen [data-value="FREQ"]').first.wait_for()
            other_car("warm-idle")
            guided_test(tabs["en"], wanted)
            other_car("city")
            ask("/control/take", {"force": True})
            ask("/recording/start", {})
            tabs["en"].wait_for_timeout(SECONDS * 1000)
            for screen in THERE:
                if screen == "memory":
                    ask("/recording/stop", {})
                    ask("/control/release", {})
                for language, page in tabs.items():
                    show(page, screen)
                    take(page, language, screen, wanted)
            for language, page in tabs.items():
                page.set_viewport_size(PHONE)
                show(page, "live")
                take(page, language, "phone", wanted)
                page.set_viewport_size(LYING)
                page.keyboard.press("b")  # as a phone that lies on its side does by itself
                page.locator("#screen .big [data-value]").first.wait_for()
                take(page, language, "phone-lying", wanted)
        browser.close()


if __name__ == "__main__":
    main(sys.argv[1:])
