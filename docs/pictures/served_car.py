"""A virtual car, the program that reads it, and tabs that show it: as with a real car.

The car is in the program itself, where a busy computer leaves no gaps, or its unit, a λ meter and a
GPS receiver are at a port each (Linux, macOS). The program keeps nothing of the user's own.
Chromium has to be installed; it runs only while a tab is shown.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import few_colours
from playwright.sync_api import Locator, Page, ViewportSize, sync_playwright

FOLDER = Path(__file__).parent
LOCALES = {"en": "en-GB", "ru": "ru-RU"}
DESKTOP = ViewportSize(width=1280, height=720)
PHONE = ViewportSize(width=390, height=844)
LYING = ViewportSize(width=844, height=390)
PORT = 8077
ADDRESS = f"http://127.0.0.1:{PORT}"
CLIENT = "pictures-0002"
WORK = Path("/tmp/car")  # short and always the same: pictures show the ports in it
MIKAS = (sys.executable, "-m", "mikas")
UNIT, METER, GPS = (str(WORK / name) for name in ("ttyUSB0", "ttyUSB1", "ttyUSB2"))


@contextmanager
def program(scenario: str) -> Iterator[None]:
    """Run the program with a virtual car in it. `scenario`: with options, as `city&faults=17`."""
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir()
    with _dashboard(car(scenario)):
        yield


def car(scenario: str) -> str:
    """Return the port of a virtual car in the program itself."""
    return f"sim:?scenario={scenario}"


@contextmanager
def program_at_ports(scenario: str) -> Iterator[None]:
    """Run a virtual car in this scenario, and the program at its port."""
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir()
    beside = ["--instrument", "aem", "--instrument", "nmea"]
    served = [*MIKAS, "sim", "--scenario", scenario, *beside]
    with subprocess.Popen(served, stdout=subprocess.PIPE, text=True) as sim:
        assert sim.stdout
        try:
            for link in (UNIT, METER, GPS):
                Path(link).symlink_to(sim.stdout.readline().strip().rpartition("=")[2])
            with _dashboard(UNIT):
                yield
        finally:
            sim.terminate()


@contextmanager
def _dashboard(port: str) -> Iterator[None]:
    command = [
        *MIKAS, "dash", "--port", port, "--host-port", str(PORT), "--no-browser",
        "--record", str(WORK / "recordings"),
    ]  # fmt: skip
    kept = os.environ | {"MIKAS_STATE": str(WORK / "state")}
    out = subprocess.PIPE
    with subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, env=kept) as dash:
        assert dash.stdout
        dash.stdout.readline()  # its address: it listens
        try:
            yield
        finally:
            dash.terminate()


def ask(path: str, body: object = None, method: str = "POST") -> dict[str, Any]:
    """Ask the program for something, as one more client; return its answer."""
    headers = {"Content-Type": "application/json", "X-Mikas-Client": CLIENT}
    content = None if method == "GET" else json.dumps(body or {}).encode()
    request = urllib.request.Request(f"{ADDRESS}/api{path}", content, headers, method=method)
    with urllib.request.urlopen(request) as answer:
        found: dict[str, Any] = json.load(answer)
        return found


class Tab:
    """A tab in one language. `wanted`: names of the pictures to take; none: all."""

    def __init__(self, page: Page, language: str, wanted: Sequence[str]) -> None:
        self.page, self.language, self._wanted = page, language, wanted

    def show(self, where: str) -> None:
        """Go to a screen, and wait until it shows what it shows."""
        self.page.evaluate("where => { location.hash = where }", f"/{where}")
        self.page.wait_for_function("() => !document.querySelector('#screen [aria-busy=true]')")

    def say(self, en: str, ru: str) -> str:
        """Return the text in the tab's language."""
        return en if self.language == "en" else ru

    def press(self, en: str, ru: str) -> None:
        """Press the button of this name, in the sheet in front if there is one."""
        sheets = self.page.locator("dialog[open]")
        place = sheets.last if sheets.count() else self.page
        place.get_by_role("button", name=self.say(en, ru), exact=True).first.click()

    def take(self, name: str, of: Locator | None = None) -> None:
        """Take the picture of what the tab shows, or of a part of it, if it is wanted."""
        if self._wanted and name not in self._wanted:
            return
        self.page.mouse.move(2, 300)  # no tile, no line of a list
        self.page.wait_for_timeout(500)
        shot = self.page.screenshot() if of is None else of.screenshot()
        out = FOLDER / self.language / f"{name}.png"
        few_colours.write(shot, out)
        print(out, out.stat().st_size, file=sys.stderr)


@contextmanager
def tabs(wanted: Sequence[str], size: ViewportSize = DESKTOP) -> Iterator[list[Tab]]:
    """Open a tab in each language."""
    chromium = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        opened = []
        for language, locale in LOCALES.items():
            context = browser.new_context(
                locale=locale, viewport=size, color_scheme="light", reduced_motion="reduce"
            )
            page = context.new_page()
            page.goto(f"{ADDRESS}/#/connection")
            page.locator("#screen .columns").wait_for()
            opened.append(Tab(page, language, wanted))
        yield opened
        browser.close()
