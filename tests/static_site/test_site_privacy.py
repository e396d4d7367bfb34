"""Nothing leaves the computer: a whole session, in the browser's own log of its network."""

from __future__ import annotations

import json

import pytest
from playwright.sync_api import expect

from browser.chromium_rig import FLAGS

from .computer_rig import CHOOSING, ORIGIN
from .site_rig import SiteTab

pytestmark = pytest.mark.realtime

ELSEWHERE = f"{CHOOSING}/files.json"
"""What a request to another origin would get: the same host answers."""
BROWSER = "not an origin"
"""In the log: who asks for the address that was typed, and looks for a newer browser."""
IN_THE_PAGE = """async address => {
  const tried = { fetch: () => fetch(address, { mode: "no-cors" }),
    script: () => import(address),
    socket: () => loaded(new WebSocket(address.replace("http", "ws"))),
    image: () => loaded(Object.assign(new Image(), { src: address })),
  }
  const loaded = it => new Promise((done, failed) => {
    it.onload = it.onopen = done
    it.onerror = failed
  })
  const done = []
  navigator.sendBeacon(address, "it does not say whether that was allowed: the log does")
  for (const [name, attempt] of Object.entries(tried))
    await Promise.resolve().then(attempt).then(() => done.push(name), () => {})
  return done
}"""
IN_A_WORKER = """async address => {
  const left = ["fetch", "XMLHttpRequest", "WebSocket", "EventSource", "WebTransport", "Worker"]
    .filter(it => globalThis[it] !== undefined)
  await import(address).then(() => left.push("import"), () => {})
  return left
}"""


@pytest.fixture
def logged(driver, chromium_program, tmp_path):
    """A browser with a log of its network: `tab`, and after `close()` the `addresses` in it."""
    return Logged(driver, chromium_program, tmp_path / "net-log.json")


class Logged:
    def __init__(self, driver, program, file):
        self._file = file
        flags = [*FLAGS, f"--log-net-log={file}"]
        self._browser = driver.chromium.launch(executable_path=program, args=flags)
        context = self._browser.new_context(locale="en-GB")
        self.tab = SiteTab(context.new_page(), ORIGIN)

    def addresses(self) -> set[str]:
        """End the browser; return the addresses of all requests of its pages and workers."""
        self._browser.close()
        log = json.loads(self._file.read_text("utf-8"))
        begun = log["constants"]["logEventTypes"]["URL_REQUEST_START_JOB"]
        given = [it.get("params", {}) for it in log["events"] if it["type"] == begun]
        return {it["url"] for it in given if it.get("initiator", BROWSER) != BROWSER}


def test_no_request_of_a_whole_session_leaves_the_origin(logged, site, car):
    tab = logged.tab.open().connect()
    tab.show("live").record()
    tab.recorded(1)
    tab.stop_recording()
    name = tab.recordings()[0]["id"]
    tab.show("recordings").press(f"Export {name}")
    assert tab.download(tab.button(".csv", exact=True))
    assert tab.download(tab.page.get_by_role("link", name=".pcapng", exact=True))
    tab.page.keyboard.press("Escape")
    tab.show("report").find("#screen select").first.select_option(name)
    expect(tab.page.frame_locator("#screen iframe").locator("h1")).to_be_visible()
    tab.again().connect()  # from the kept files, with what the service worker adds to them
    asked = logged.addresses()
    assert f"{ORIGIN}/files.json" in asked
    assert {it for it in asked if not it.startswith(f"{ORIGIN}/")} == set()


def test_no_page_and_no_worker_can_reach_another_origin(logged, site):
    tab = logged.tab.open()
    for visit in ("first", "second"):
        assert tab.page.evaluate(IN_THE_PAGE, f"{ELSEWHERE}?page-{visit}") == []
        for worker in tab.page.workers:
            assert worker.evaluate(IN_A_WORKER, f"{ELSEWHERE}?worker-{visit}") == []
        tab.again()
    assert {it for it in logged.addresses() if it.startswith(ELSEWHERE)} == set()
