"""The documentation as a reader has it: two languages, a search, and no network."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

pytestmark = pytest.mark.realtime

TITLES = {"en": "The Mikas K-Line protocol, clause by clause", "ru": "Протокол Микаса по K-Line"}
PAGES = (
    "index", "tutorials/owner", "reference/screens/live", "protocol", "reference/parameters",
    "reference/python/package", "reference/help", "development/architecture",
)  # fmt: skip


def heading(page):
    return page.locator("article h1")


@pytest.mark.parametrize(("locale", "language"), [("en-GB", "en"), ("ru-RU", "ru"), ("de", "en")])
def test_a_reader_begins_in_the_own_language(reader, locale, language):
    page = reader("index.html", locale=locale)
    page.wait_for_url(f"**/{language}/index.html")
    expect(page.locator("html")).to_have_attribute("lang", language)


def test_the_switch_stays_on_the_page(reader):
    page = reader("en/protocol.html")
    for language in ("ru", "en"):
        page.locator(".md-select button").hover()
        page.locator(f".md-select a[hreflang={language}]").click()
        page.wait_for_url(f"**/{language}/protocol.html")
        expect(heading(page)).to_contain_text(TITLES[language])


@pytest.mark.parametrize(
    ("language", "words"), [("en", "coolant temperature"), ("ru", "температура охлаждающей")]
)
def test_the_search_finds_a_parameter(reader, language, words):
    page = reader(f"{language}/index.html")
    page.keyboard.press("/")
    page.get_by_role("combobox").fill(words)
    found = page.get_by_role("option")
    found.filter(has_text="TWAT").first.click()
    page.wait_for_url(f"**/{language}/*/*.html*")
    expect(page.locator("article")).to_contain_text("TWAT")


@pytest.mark.parametrize("language", ["en", "ru"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_and_pictures_are_whole(reader, language, scheme):
    for name in PAGES:
        page = reader(f"{language}/{name}.html", color_scheme=scheme)
        expect(heading(page)).to_be_visible()
        page.wait_for_load_state("load")
        broken = "() => [...document.images].filter(it => !it.naturalWidth).map(it => it.src)"
        assert page.evaluate(broken) == []


@pytest.mark.parametrize("language", ["en", "ru"])
def test_nothing_is_wider_than_a_phone(reader, language):
    for name in PAGES:
        page = reader(f"{language}/{name}.html", viewport={"width": 390, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth") <= 390, name
