"""Recordings on the site: made, played, compared, exported as on a desktop."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from browser.rig import dashboard, gaps_of

pytestmark = pytest.mark.realtime

LONG = 1.5  # s of each half of a recording


@pytest.fixture(scope="module")
def drives(visit, car):
    """Two recordings, the earlier one first: 87 °C, a marker, 88 °C; and 55 °C."""
    visit.connect().show("live")
    expect(visit.value("TWAT")).to_have_text("87")
    visit.record()
    visit.recorded(LONG)
    visit.page.keyboard.press("m")
    name = visit.page.get_by_role("textbox", name="Its name")
    name.fill("hotter")
    name.press("Enter")
    car.set("TWAT", "80")
    expect(visit.value("TWAT")).to_have_text("88")
    visit.recorded(2 * LONG)
    visit.stop_recording()
    car.set("TWAT", "5F")
    expect(visit.value("TWAT")).to_have_text("55")
    visit.record()
    visit.recorded(LONG)
    visit.stop_recording()
    return [it["id"] for it in reversed(visit.recordings())]


@pytest.fixture
def listed(tab, drives):
    return tab.show("recordings")


@pytest.fixture(scope="module")
def at_home(visit, drives, tmp_path_factory):
    """The desktop's program, with the first recording as the site handed it out."""
    folder = tmp_path_factory.mktemp("desktop")
    (folder / "recordings").mkdir()
    visit.show("recordings").press(f"Export {drives[0]}")
    data = visit.download(visit.page.get_by_role("link", name=".pcapng", exact=True))
    visit.page.keyboard.press("Escape")
    (folder / "recordings" / drives[0]).write_bytes(data)
    with dashboard(folder, begin=False) as dash:
        yield dash


def test_what_was_recorded_is_listed(listed, drives):
    second, first = listed.recordings()
    assert [first["id"], second["id"]] == drives
    assert (first["markers"], first["open"], first["virtual"]) == (1, False, False)
    assert gaps_of(listed, first) == []
    assert first["passport"][1] == "17.3763.000-02"
    assert first["length"] > LONG  # of about twice that: the last sample came before the stop
    row = listed.find("tbody tr", has_text=drives[0].removesuffix(".pcapng"))
    expect(row).to_contain_text("Mikas 7.1")


def test_it_is_played_in_the_same_screens(listed, drives):
    listed.find("tbody tr").nth(1).get_by_role("button", name="Open", exact=True).click()
    player = listed.page.get_by_role("region", name="Player")
    expect(player).to_contain_text(drives[0])
    listed.show("chart")
    expect(listed.traced("TWAT")).to_have_text("87")
    expect(listed.find(".flags button.marker")).to_have_accessible_name(re.compile("hotter$"))
    player.get_by_role("slider").press("End")
    expect(listed.traced("TWAT")).to_have_text("88")
    player.get_by_role("slider").press("Home")
    listed.page.keyboard.press("Space")
    expect(listed.traced("TWAT")).to_have_text("88")
    player.get_by_role("button", name="Close the recording").click()
    expect(listed.traced("TWAT")).to_have_text("55")


def test_two_recordings_are_compared(listed, drives):
    listed.press(f"Compare {drives[0]} with…")
    listed.page.get_by_role("dialog").get_by_role("button", name=drives[1]).click()
    expect(listed.page.get_by_role("group", name="Comparison")).to_be_visible()
    expect(listed.traced("TWAT")).to_have_text("87")
    expect(listed.find('[data-second="TWAT"] b')).to_have_text("55")
    expect(listed.find('[data-more="TWAT"]')).to_have_text("+32")
    listed.find("header[data-shown]").get_by_role("button", name="Back to live").click()


def test_the_desktop_reads_what_the_site_recorded(at_home, drives):
    (found,) = at_home.get("/recordings")["recordings"]
    assert (found["markers"], gaps_of(at_home, found), found["problem"]) == (1, [], None)
    rows = at_home.get(f"/recordings/{drives[0]}/rows?points=20000")
    coolant = rows["values"][rows["names"].index("TWAT")]
    assert set(coolant) - {None} == {87, 88}


@pytest.mark.parametrize("form", ["csv", "msl", "mlg"])
def test_exports_are_the_desktops_byte_for_byte(listed, at_home, drives, form):
    listed.press(f"Export {drives[0]}")
    made = listed.download(listed.button(f".{form}", exact=True))
    listed.page.keyboard.press("Escape")
    asked = f"/api/recordings/{drives[0]}/export?format={form}"
    assert made == at_home.api.get(asked).raise_for_status().content


def test_the_report_is_the_desktops(listed, at_home, drives):
    listed.show("report").find("#screen select").first.select_option(drives[0])
    expect(listed.page.frame_locator("#screen iframe").locator("h1")).to_be_visible()
    made = listed.download(listed.button("Save HTML"))
    assert made == at_home.api.get(f"/api/recordings/{drives[0]}/report?lang=en").content
