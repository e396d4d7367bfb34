"""The built site in a tab: what a person does there, and what is asked of the program."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import BrowserContext, expect

from browser.rig import Tab

BUILT = Path(__file__).parents[2] / "build" / "site"
PORT = "webserial:0403:6001"
ASK = """async path => {
  const response = await fetch(path)
  if (!response.ok) throw new Error(`${path}: ${response.status} ${await response.text()}`)
  return response.json()
}"""
RECORDED = """async seconds => {
  const { recording, now } = await (await fetch("api/state")).json()
  return recording?.samples >= 2 && now - recording.since >= seconds && now - recording.since
}"""
KEPT = "() => navigator.serviceWorker?.controller != null"


def missing() -> str:
    return "" if (BUILT / "files.json").is_file() else "the site was not built: make site"


class SiteTab(Tab):
    """A tab on the site, with the program in it."""

    def open(self, screen: str = "live") -> SiteTab:
        """Open the site, and wait until the program runs and downloads work."""
        self.page.goto(f"{self.url}/#/{screen}")
        self.runs()
        return self

    def again(self) -> SiteTab:
        """Reload the page."""
        self.page.reload()
        self.runs()
        return self

    def renew(self) -> SiteTab:
        """Open the site in a new tab; this one is gone."""
        context = self.page.context
        self.page.close()
        self.attend(context.new_page())
        return self.open()

    def runs(self) -> None:
        expect(self.page.locator("header[data-line]")).to_be_visible()
        self.until(KEPT)

    def connect(self) -> SiteTab:
        """Connect to the adapter, if that is not done; wait until the unit is known.

        Values come before: before that nothing can be recorded. On a busy computer a connection may
        be without an answer just now; it comes back by itself.
        """
        self.show("connection")
        if self.state()["line"] == "off":
            self.press(f"Connect to {PORT}")
        self.is_line("sampling")
        expect(self.page.locator("header[data-line]")).to_contain_text("Mikas 7.1")
        return self

    def get(self, path: str) -> dict:
        """Ask the program, through the service worker."""
        return self.page.evaluate(ASK, f"api{path}")

    def state(self) -> dict:
        return self.get("/state")

    def record(self) -> None:
        self.press("Record")
        self.is_line("recording")

    def recorded(self, seconds: float) -> float:
        """Wait until the recording in progress is that long and has samples, which come late on
        a busy computer; return how long it is.
        """
        return self.until(RECORDED, seconds)

    def stop_recording(self) -> None:
        self.press("Stop recording")
        self.is_line("sampling")

    def recordings(self) -> list[dict]:
        return self.get("/recordings")["recordings"]

    def download(self, where) -> bytes:
        """Return the file that a click on `where` brings."""
        with self.page.expect_download() as download:
            where.click()
        return Path(download.value.path()).read_bytes()


@contextmanager
def site_tab(context: BrowserContext, url: str) -> Iterator[SiteTab]:
    tab = SiteTab(context.new_page(), url)
    try:
        yield tab
    finally:
        tab.page.close()
    assert not tab.complaints, tab.complaints
