"""Debian's Chromium, never one that Playwright downloads, and visits with it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

import pytest
from playwright.sync_api import Browser, Playwright, sync_playwright

from browser.rig import LAPTOP, Tab, tab_in

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    f"--host-resolver-rules=MAP {LAPTOP} 127.0.0.2",
)  # fmt: skip


def installed() -> str | None:
    """Return the path of the browser."""
    names = ("chromium", "chromium-browser", "google-chrome")
    return next(filter(None, map(shutil.which, names)), None)


def must_not_miss(missing: str) -> None:
    """Skip if something is `missing`; where a browser is required, that is a failure."""
    if missing and os.environ.get("MIKAS_REQUIRE_CHROMIUM"):
        pytest.fail(missing)
    if missing:
        pytest.skip(missing)


@contextmanager
def started(program: str) -> Iterator[Browser]:
    with sync_playwright() as playwright, launched(playwright, program) as browser:
        yield browser


@contextmanager
def launched(playwright: Playwright, program: str) -> Iterator[Browser]:
    browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
    yield browser
    browser.close()


@contextmanager
def visits(browser: Browser) -> Iterator[Callable[..., Tab]]:
    """Open tabs: `visit(url, locale="ru-RU", …)`, each in a browser profile of its own."""
    with ExitStack() as stack:

        def visit(url: str, **wishes) -> Tab:
            wishes = {"locale": "en-GB", "viewport": {"width": 1280, "height": 800}} | wishes
            # As a person does who has compared the fingerprint.
            context = browser.new_context(ignore_https_errors=True, **wishes)
            stack.callback(context.close)
            return stack.enter_context(tab_in(context, url))

        yield visit
