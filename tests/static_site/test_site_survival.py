"""What ends a recording in the middle: it is listed on return, and at most a second is missing.

The next page says so, connects to the car without a click, and offers to go on.
"""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress
from pathlib import Path

import pytest
from playwright.sync_api import expect

from browser.chromium_rig import FLAGS
from browser.rig import UNTIL, gaps_of

from .site_rig import SiteTab, site_tab

pytestmark = pytest.mark.realtime

LONG = 5.0  # s
MISSING = 3.0  # s, at most: a second, and the sample with which it is over, slow on a busy computer


@pytest.fixture
def recording(tab):
    """How long the recording is that goes on."""
    tab.show("live").record()
    return tab.recorded(LONG)


def is_kept(tab: SiteTab, long: float) -> None:
    """The latest recording is whole but for the last second."""
    latest = tab.recordings()[0]
    assert latest["open"] is False
    assert latest["problem"] is None
    # Faults and methods are read at its beginning, on a loaded machine for more than a second.
    assert latest["gaps"] <= 3
    assert latest["length"] > long - MISSING


def comes_back(tab: SiteTab, long: float) -> None:
    """The next page says what was cut short, and is on the car again by itself."""
    is_kept(tab, long)
    tab.says(f"{tab.recordings()[0]['id']} is kept; at most its last second is missing")
    tab.is_line("sampling")
    said = tab.find(".toast", has_text="is kept")
    said.get_by_role("button", name="Close").click()


def renderers(browser) -> set[int]:
    session = browser.new_browser_cdp_session()
    found = session.send("SystemInfo.getProcessInfo")["processInfo"]
    session.detach()
    return {it["id"] for it in found if it["type"] == "renderer"}


def kill(*processes: int) -> None:
    for each in processes:
        os.kill(each, signal.SIGKILL)


def kill_renderers(browser) -> None:
    """Kill each of them, and wait until the browser knows it.

    One that it keeps in reserve would become the next tab, which then crashes as it opens.
    """
    killed = renderers(browser)
    kill(*killed)
    until = time.monotonic() + UNTIL / 1000
    while killed & renderers(browser):
        assert time.monotonic() < until, "the browser does not notice that its processes died"


def test_a_reload_amid_a_recording_asks_first(tab, recording):
    asked = []
    tab.page.once("dialog", lambda dialog: (asked.append(dialog.type), dialog.accept()))
    long = tab.recorded(recording)
    tab.again()
    assert asked == ["beforeunload"]
    comes_back(tab, long)


def test_a_recording_that_was_cut_short_can_be_continued(tab, recording):
    before = {it["id"] for it in tab.recordings()}
    tab.page.once("dialog", lambda dialog: dialog.accept())
    tab.again().press("Continue", exact=True)
    tab.is_line("recording")
    assert len({it["id"] for it in tab.recordings()} - before) == 1
    tab.stop_recording()
    tab.again().is_line("off")  # nothing was cut short
    expect(tab.button("Continue", exact=True)).to_have_count(0)


def test_what_was_recorded_is_opened_with_one_touch(tab, recording):
    tab.stop_recording()
    tab.find(".toast", has_text="Recording saved").get_by_role("button", name="Open").click()
    expect(tab.page.get_by_role("region", name="Player")).to_contain_text(tab.recordings()[0]["id"])
    tab.find("header[data-shown]").get_by_role("button", name="Back to live").click()


def test_a_closed_tab_loses_nothing_recorded(tab, recording):
    comes_back(tab.renew(), recording)


def test_a_page_whose_process_is_killed_loses_nothing_recorded(tab, recording, chromium):
    with tab.page.expect_event("crash"):
        kill_renderers(chromium)
    comes_back(tab.renew(), recording)


def test_an_adapter_that_is_pulled_amid_a_recording_leaves_one_gap(tab, car, recording):
    tab.refused = True
    car.pull()
    tab.is_line("no-port")
    car.put_back()
    tab.is_line("recording")
    assert tab.recorded(recording + LONG)
    tab.stop_recording()
    assert len(gaps_of(tab, tab.recordings()[0])) == 1


def test_on_a_full_disk_the_recording_so_far_is_whole(tab, recording):
    """The quota that the browser allows is a disk, for a page."""
    disk = tab.page.context.new_cdp_session(tab.page)
    used = disk.send("Storage.getUsageAndQuota", {"origin": tab.url})["usage"]
    disk.send("Storage.overrideQuotaForOrigin", {"origin": tab.url, "quotaSize": used + 20000})
    tab.says("so far is whole. Make room, then repeat. On the Recordings screen")
    assert "/kept" not in tab.page.inner_text("body")
    disk.send("Storage.overrideQuotaForOrigin", {"origin": tab.url})
    tab.stop_recording()
    is_kept(tab, recording)


def test_a_killed_browser_loses_nothing_recorded(
    tab, car, driver, chromium_program, site, tmp_path
):
    tab.show("connection").press("Disconnect")  # it leaves the adapter to the other browser
    tab.is_line("off")

    def start():
        return driver.chromium.launch_persistent_context(
            str(tmp_path), executable_path=chromium_program, args=FLAGS, locale="en-GB"
        )

    killed = start()
    other = SiteTab(killed.new_page(), site.url).open().connect()
    other.record()
    long = other.recorded(LONG)
    with killed.expect_event("close"):
        kill(*of_profile(tmp_path))
    with start() as context, site_tab(context, site.url) as again:
        # The browser may not have stored yet that it was recording: both happen.
        context.add_init_script("localStorage.removeItem('mikas.recording.amid')")
        is_kept(again.open(), long)
        again.connect()


def of_profile(folder) -> list[int]:
    """The browser that has its profile there."""
    option = f"--user-data-dir={folder}".encode()
    found = []
    for line in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):
            given = line.read_bytes().split(b"\0")
            if option in given and not any(it.startswith(b"--type=") for it in given):
                found.append(int(line.parent.name))
    return found
