"""The page without installation as the benchmarks use it: a computer, its cables, a browser."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from bench.dash_rig import chromium

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext, Page, Playwright

ROOT = Path(__file__).parents[1]
SITE = ROOT / "build" / "site"
_PAGES = Path(__file__).parent / "site_pages"
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class SiteBench:
    """A computer with fake adapters, its browser, and the site with the pages of the bench."""

    computer: Any
    playwright: Playwright
    program: str
    browser: Browser
    folder: Path
    url: str

    @contextmanager
    def cable(self, **settings: str) -> Iterator[None]:
        from static_site.wire_rig import cable

        with (
            TemporaryDirectory() as folder,
            cable(self.computer, Path(folder), scenario="warm-idle", **settings),
        ):
            yield

    @contextmanager
    def page(self, name: str = "", **options: Any) -> Iterator[Page]:
        context = self.browser.new_context(locale="en-GB", **options)
        yield self._opened(context, name)
        context.close()

    @contextmanager
    def page_of_a_person(self, name: str = "") -> Iterator[Page]:
        """A page whose files are kept on the disk, not in memory as in the others, where each
        write is another process' work: a millisecond.
        """
        with TemporaryDirectory() as folder:
            context = self.playwright.chromium.launch_persistent_context(
                folder, executable_path=self.program, args=list(FLAGS), locale="en-GB"
            )
            yield self._opened(context, name)
            context.close()

    def _opened(self, context: BrowserContext, name: str) -> Page:
        page = context.new_page()
        page.set_default_timeout(60_000)
        page.goto(self.url + name)
        return page

    @contextmanager
    def worker(self, access: str = "serial") -> Iterator[Page]:
        """A page that runs the line's worker of the site and asks it."""
        with self.page_of_a_person("bench.html") as page:
            self.begin(page, "line", access)
            yield page

    def begin(self, page: Page, role: str, access: str = "serial") -> None:
        """Start a worker; `access`: how it reaches the cable, `serial` or `usb`."""
        script = next((self.folder / "assets").glob("worker-*.js")).name
        asked = [f"assets/{script}", role, access]
        page.evaluate("([url, role, access]) => begin(url, role, access)", asked)


def missing() -> str:
    """What keeps the site from being measured in a browser here; empty: nothing."""
    if not (SITE / "files.json").is_file():
        raise RuntimeError("build/site is missing: make site")
    if chromium() is None or sys.platform != "linux":
        return "Chromium is not installed"
    if (tests := str(ROOT / "tests")) not in sys.path:
        sys.path.insert(0, tests)
    from static_site import computer_rig

    return str(computer_rig.missing())


@contextmanager
def site_bench() -> Iterator[SiteBench]:
    from playwright.sync_api import sync_playwright

    from static_site import computer_rig
    from static_site.pages_rig import StaticHost

    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        site = folder / "site"
        shutil.copytree(SITE, site)
        for name in ("bench.html", "bench.js"):
            shutil.copy(_PAGES / name, site)
        rolldown = ROOT / "web" / "node_modules" / ".bin" / "rolldown"
        for name in ("keep", "exchange"):
            made = ["--format", "esm", "--file", str(site / f"{name}.js")]
            command = [str(rolldown), str(_PAGES / f"{name}.ts"), *made]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        computer = stack.enter_context(computer_rig.computer())
        host = StaticHost(computer, site)
        stack.callback(host.stop)
        playwright = stack.enter_context(sync_playwright())
        program = computer.wrapper(chromium(), folder)
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        stack.callback(browser.close)
        yield SiteBench(computer, playwright, program, browser, site, f"{host.url}/")


def until_sampling(page: Page) -> None:
    while json.loads(ask(page, "line", "GET", "/api/state"))["samples"] <= 3:
        page.wait_for_timeout(200)


def ask(page: Page, role: str, method: str, path: str, body: object = None) -> str:
    text: str = page.evaluate(
        "([role, method, path, body]) => ask(role, method, path, body).then(it => it.text)",
        [role, method, path, body],
    )
    return text
