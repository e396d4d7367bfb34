"""The documentation beside the page: linked both ways, and left alone by the service worker."""

from __future__ import annotations

import json

import pytest
from playwright.sync_api import expect

from browser.chromium_rig import must_not_miss

from .site_rig import BUILT

pytestmark = pytest.mark.realtime


@pytest.fixture(autouse=True)
def joined():
    there = (BUILT / "docs" / "index.html").is_file()
    must_not_miss("" if there else "the documentation is not beside the page: make site")


def test_the_page_leads_to_the_documentation_and_back(visit):
    visit.show("connection")
    with visit.page.expect_popup() as opened:
        visit.find("#screen a[href^=docs]").click()
    docs = opened.value
    expect(docs.locator("article h1")).to_have_text("mikas¶")
    back = docs.get_by_role("link", name="Open mikas in this browser")
    assert back.evaluate("it => it.href") == f"{visit.url}/index.html"
    docs.close()


def test_it_is_no_part_of_the_page(visit):
    listed = json.loads((BUILT / "files.json").read_text("utf-8"))["files"]
    assert [each["path"] for each in listed if each["path"].startswith("docs/")] == []
    docs = visit.page.context.new_page()
    response = docs.goto(f"{visit.url}/docs/ru/protocol.html")
    assert not response.from_service_worker
    assert "content-security-policy" not in response.headers
    expect(docs.locator("article h1")).to_contain_text("Протокол")
    docs.close()
