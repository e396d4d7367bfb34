"""The browser: Debian's Chromium, never one that Playwright downloads. Skipped as a whole where
there is none, or where the page was not built, unless `MIKAS_REQUIRE_CHROMIUM` is set: then that is
a failure.
"""

from __future__ import annotations

import os
import shutil
from contextlib import ExitStack

import pytest
from playwright.sync_api import sync_playwright

from browser.rig import LAPTOP, dashboard, tab_in
from mikas.dashboard.page import FOLDER

_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    f"--host-resolver-rules=MAP {LAPTOP} 127.0.0.2",
)  # fmt: skip


def _chromium() -> str | None:
    names = ("chromium", "chromium-browser", "google-chrome")
    return next(filter(None, map(shutil.which, names)), None)


def _missing() -> str:
    if _chromium() is None:
        return "Chromium is not installed"
    return "" if (FOLDER / "index.html").is_file() else "the page was not built: pip install ."


@pytest.fixture(scope="package")
def chromium():
    if missing := _missing():
        if os.environ.get("MIKAS_REQUIRE_CHROMIUM"):
            pytest.fail(missing)
        pytest.skip(missing)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=_chromium(), args=_FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def visitor(chromium):
    """Opens tabs: `visitor(url, locale="ru-RU", …)`, each in a browser profile of its own."""
    with ExitStack() as stack:

        def visit(url: str, **wishes):
            wishes = {"locale": "en-GB", "viewport": {"width": 1280, "height": 800}} | wishes
            # As a person does who has compared the fingerprint.
            context = chromium.new_context(ignore_https_errors=True, **wishes)
            stack.callback(context.close)
            return stack.enter_context(tab_in(context, url))

        yield visit


@pytest.fixture(scope="module")
def served(chromium, tmp_path_factory):
    """The program, connected to a car; shared by a module's tests."""
    with dashboard(tmp_path_factory.mktemp("served")) as dash:
        yield dash.samples()


@pytest.fixture
def dash(served):
    """That program, with no client in control."""
    served.nobody_controls()
    return served


@pytest.fixture
def own(chromium, tmp_path):
    """A program with a car of the test's own, to be changed."""
    with dashboard(tmp_path) as dash:
        yield dash.samples()
