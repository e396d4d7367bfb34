"""How the site starts: without a network, in a new version, beside another tab."""

from __future__ import annotations

import json
import shutil
from hashlib import sha256

import pytest
from playwright.sync_api import expect

from browser.chromium_rig import must_not_miss

from .pages_rig import StaticHost
from .site_rig import BUILT, missing, site_tab

pytestmark = pytest.mark.realtime

ANOTHER = "<!-- another version -->"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The built site, to be changed."""
    must_not_miss(missing())
    return shutil.copytree(BUILT, tmp_path_factory.mktemp("site") / "site")


@pytest.fixture(scope="module")
def site(chromium, whole_computer, folder):
    served = StaticHost(whole_computer, folder)
    yield served
    served.stop()


def test_after_the_first_visit_it_starts_without_a_network(visit, site):
    visit.show("connection")
    visit.says("it starts without a network, too")
    site.stop()
    try:
        visit.refused = True
        visit.again().show("connection")
        visit.press("Start the virtual car")
        visit.is_line("sampling")
        visit.show("live")
        expect(visit.value("TWAT")).not_to_have_text("")
    finally:
        visit.refused = False
        site.start()
    visit.show("connection").press("Disconnect")
    visit.is_line("off")


def test_the_second_tab_is_told_and_takes_over(visit, site, profile):
    with site_tab(profile, site.url) as second:
        second.page.goto(second.url)
        second.says("mikas is open in another tab")
        second.press("Use it here instead")
        second.runs()
        visit.says("mikas is open in another tab")
    visit.runs()  # by itself, when the other one is closed


def test_a_tab_that_records_keeps_the_car(visit, site, profile, car):
    visit.connect().record()
    with site_tab(profile, site.url) as second:
        second.page.goto(second.url)
        second.press("Use it here instead")
        second.says("The other tab is recording")
        visit.stop_recording()
        second.press("Use it here instead")
        second.says("The other tab is connected to the car")
    visit.is_line("sampling")


def test_a_new_version_is_offered_and_not_forced(visit, folder, car):
    publish_another_version(folder)
    visit.again().connect()
    visit.until("async () => (await navigator.serviceWorker.getRegistration()).waiting !== null")
    use = visit.button("Use it now")
    expect(use).to_have_count(0)
    visit.press("Disconnect")
    visit.says("A new version of mikas is ready.")
    page = "async () => (await fetch('index.html')).text()"
    assert ANOTHER not in visit.page.evaluate(page)
    with visit.page.expect_navigation():
        use.first.click()
    visit.runs()
    assert ANOTHER in visit.page.evaluate(page)
    expect(use).to_have_count(0)


def publish_another_version(folder):
    """As the host does that is given a newer build."""
    index, worker, listing = (
        folder / name for name in ("index.html", "service-worker.js", "files.json")
    )
    index.write_text(index.read_text("utf-8").replace("</body>", f"{ANOTHER}</body>"), "utf-8")
    listed = json.loads(listing.read_text("utf-8"))
    version = "0" * len(listed["version"])
    script = worker.read_text("utf-8")
    assert script.count(listed["version"]) == 1
    worker.write_text(script.replace(listed["version"], version), "utf-8")
    listed["version"] = version
    for file in listed["files"]:
        content = (folder / file["path"]).read_bytes()
        file["bytes"], file["sha256"] = len(content), sha256(content).hexdigest()
    listing.write_text(json.dumps(listed), "utf-8")
