"""Files in and out of the site on a phone: installed, without a network, shared by other apps.

A tab as a phone shows it: its name, its size, touch. What other apps do is done by a form, as the
system posts it, and by a page of the test beside the site.
"""

from __future__ import annotations

import json
import re
import struct

import pytest
from playwright.sync_api import expect

from browser.chromium_rig import FLAGS
from dashboard.recordings_rig import record

from .site_rig import BUILT, site_tab

pytestmark = pytest.mark.realtime

ANDROID = (
    "Mozilla/5.0 (Linux; Android 14; K) AppleWebKit/537.36 (KHTML, like Gecko) "
    "Chrome/156.0.0.0 Mobile Safari/537.36"
)
PHONE = {
    "user_agent": ANDROID, "viewport": {"width": 412, "height": 840}, "device_scale_factor": 2,
    "has_touch": True, "is_mobile": True, "locale": "en-GB",
}  # fmt: skip
SETTLED = 6.0  # s: a computer has started its reader by then
SHARE = """([name, bytes]) => {
  const form = document.createElement("form")
  Object.assign(form, { method: "POST", enctype: "multipart/form-data", action: "shared" })
  const field = Object.assign(document.createElement("input"), { type: "file", name: "recordings" })
  const files = new DataTransfer()
  if (name) files.items.add(new File([new Uint8Array(bytes)], name))
  field.files = files.files
  form.append(field)
  document.body.append(form)
  form.submit()
}"""


@pytest.fixture(scope="module")
def profile(driver, chromium_program, tmp_path_factory):
    """A profile on the disk: a private window can't install."""
    context = driver.chromium.launch_persistent_context(
        tmp_path_factory.mktemp("profile"), executable_path=chromium_program, args=FLAGS, **PHONE
    )
    yield context
    context.close()


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    """A recording from elsewhere, by a phone's browser: it has handed it over as text."""
    path = record(tmp_path_factory.mktemp("elsewhere") / "drive.pcapng")
    return "drive.pcapng.txt", list(path.read_bytes())


def share(tab, name="", content=()):
    """As another app does: the system posts the file to the site, in this tab."""
    with tab.page.expect_navigation(url=re.compile(r"shared=|#/recordings$")):
        tab.page.evaluate(SHARE, [name, list(content)])


def test_it_can_be_installed_and_takes_files_of_other_apps(visit):
    devtools = visit.page.context.new_cdp_session(visit.page)
    assert devtools.send("Page.getInstallabilityErrors")["installabilityErrors"] == []
    found = devtools.send("Page.getAppManifest")
    assert found["errors"] == []
    assert found["url"] == f"{visit.url}/manifest.webmanifest"
    manifest = json.loads(found["data"])
    sizes = {icon["sizes"]: icon for icon in manifest["icons"]}
    assert {"192x192", "512x512", "any"} <= set(sizes)
    for size in (192, 512):
        icon = (BUILT / sizes[f"{size}x{size}"]["src"]).read_bytes()
        assert struct.unpack(">II", icon[16:24]) == (size, size)
    assert any(it.get("purpose") == "maskable" for it in manifest["icons"])
    shared = manifest["share_target"]
    assert (shared["method"], shared["enctype"]) == ("POST", "multipart/form-data")
    assert manifest["file_handlers"][0]["accept"] == {"application/x-pcapng": [".pcapng"]}
    devtools.detach()


def test_a_phone_has_one_worker_until_a_recording_is_opened(visit, site):
    visit.show("connection").says("it starts without a network, too")
    site.stop()
    try:
        visit.refused = True
        visit.again().show("connection").press("Start the virtual car")
        visit.is_line("sampling")
        visit.show("live").record()
        visit.recorded(SETTLED)
        visit.stop_recording()
        assert len(visit.page.workers) == 1
        visit.show("recordings").find("#screen article").get_by_role("button", name="Open").click()
        player = visit.page.get_by_role("region", name="Player")
        expect(player).to_be_visible()
        assert len(visit.page.workers) == 2
        visit.is_line("sampling")
        player.get_by_role("button", name="More player controls").click()
        player.get_by_role("button", name="Close the recording").click()
        visit.show("connection").press("Disconnect")
        visit.is_line("off")
    finally:
        visit.refused = False
        site.start()


def test_what_another_app_shares_is_added_by_the_tab_that_has_the_program(
    visit, site, profile, drive
):
    site.stop()
    try:
        with site_tab(profile, site.url) as second:
            visit.refused = second.refused = True
            second.page.goto(second.url)
            second.says("mikas is open in another tab")
            share(second, *drive)
            second.says("added to the recordings there")
            visit.says("1 recording added")
            share(second)
            second.says("No file came with that share")
        visit.show("recordings").says("drive.pcapng")
        share(visit, "photo.png", b"no recording")  # a phone goes on in the same tab
        visit.runs()
        visit.says("photo")
        assert "shared" not in visit.page.url
        assert [it["id"] for it in visit.recordings() if it["id"].startswith("drive")] == [
            "drive.pcapng"
        ]
    finally:
        visit.refused = False
        site.start()
