"""In the guest: the built site in Chromium, as a person with a phone uses it.

    python phone_site.py CHROMIUM SITE SHARED [FLAG …]

Connects to the one cable by a touch on its button. Prints what came of it, one JSON line: `line`,
the state; `says`, the text of the screen; `value`, the coolant temperature if the unit answers.
Takes a picture in both languages, into SHARED.
"""

from __future__ import annotations

import json
import sys
import threading
from pathlib import Path

from phone_serving import FLAGS, served, show_life
from playwright.sync_api import Page, sync_playwright

PORT = 8000
PATIENCE = 900_000  # ms; the guest is slow
PHONE = {
    "viewport": {"width": 390, "height": 844},
    "device_scale_factor": 2,
    "is_mobile": True,
    "has_touch": True,
    "locale": "en-GB",
    "user_agent": "Mozilla/5.0 (Linux; Android 10; K) AppleWebKit/537.36 (KHTML, like Gecko) "
    "Chrome/150.0.0.0 Mobile Safari/537.36",
}
ENDED = """() => {
  const line = document.querySelector("header[data-line]").dataset.line
  return ["sampling", "no-port", "no-echo", "echo-only"].includes(line) && line
}"""
READ = """() => document.querySelector('#screen [data-value="TWAT"]')?.innerText"""


def note(text: str) -> None:
    print(text, flush=True)


def visit(page: Page, shared: Path) -> dict[str, str]:
    page.set_default_timeout(PATIENCE)
    page.goto(f"http://localhost:{PORT}/#/connection")
    note("the page is loaded")
    button = page.get_by_role("button", name="Connect to webusb:").first
    button.wait_for()
    note("the cable is listed")
    button.tap()
    line = page.wait_for_function(ENDED).json_value()
    found = {"line": line, "says": page.locator("#screen").inner_text()}
    note("there is an outcome")
    if line == "sampling":
        page.evaluate("location.hash = '#/live'")
        page.wait_for_function(READ)
        found["value"] = page.evaluate(READ)
    for language in ("en", "ru"):
        page.screenshot(path=str(shared / f"{language}.png"))
        if language == "en":
            page.get_by_role("button", name="More").tap()
            page.locator("button[lang=ru]").tap()
            page.keyboard.press("Escape")
            page.wait_for_timeout(3000)
    return found


def main(program: str, site: str, shared: str, *flags: str) -> None:
    show_life()
    threading.Thread(target=served(site, PORT).serve_forever, daemon=True).start()
    with sync_playwright() as playwright:
        context = playwright.chromium.launch_persistent_context(
            "/run/p/profile", executable_path=program, args=[*FLAGS, *flags],
            ignore_default_args=["--enable-automation"], timeout=PATIENCE, **PHONE,
        )  # fmt: skip
        note("the browser runs")
        print(json.dumps(visit(context.pages[0], Path(shared))), flush=True)
        context.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
