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


LOG = "t;AFR\n0;14,7\n500;13,9\n1000;14,1\n"


def test_a_log_of_another_program_is_compared_with_on_a_phone_too(listed, drives):
    for size in ({"width": 1280, "height": 800}, {"width": 390, "height": 844}):
        listed.page.set_viewport_size(size)
        listed.show("recordings")
        place = listed.find("#screen article, #screen tbody tr", has_text=drives[0])
        place.locator("visible=true").get_by_role("button", name=re.compile("^Compare")).click()
        dialog = listed.page.get_by_role("dialog")
        expect(dialog).to_contain_text("MDF4 is read by mikas installed on a computer")
        accepted = dialog.locator("input[type=file]").get_attribute("accept")
        assert ".mlg" in accepted
        assert ".mf4" not in accepted
        with listed.page.expect_file_chooser() as chooser:
            dialog.get_by_role("button", name="Another program’s log…").click()
        data = {"name": "bench.csv", "mimeType": "text/csv", "buffer": LOG.encode()}
        chooser.value.set_files([data])
        dialog.get_by_label("Which column is the time").select_option(label="t: 0")
        dialog.get_by_label("What it counts").select_option(label="milliseconds")
        dialog.get_by_role("button", name="Compare", exact=True).click()
        bar = listed.page.get_by_role("group", name="Comparison")
        expect(bar).to_contain_text("bench.csv")
        expect(listed.find('[data-second="log:AFR"] b')).to_have_text("14.7")
        bar.get_by_role("button", name="End the comparison").click()
        listed.find("header").get_by_role("button", name="Back to live").click()
    listed.page.set_viewport_size({"width": 1280, "height": 800})


def test_an_export_of_the_site_is_read_by_the_site_with_the_same_values(listed, drives):
    listed.press(f"Export {drives[0]}")
    button = listed.page.get_by_role("button", name=".mlg", exact=True)
    with listed.page.expect_download() as saved:
        button.click()
    data = saved.value.path().read_bytes()
    listed.page.keyboard.press("Escape")
    listed.press(f"Compare {drives[0]} with…")
    dialog = listed.page.get_by_role("dialog")
    with listed.page.expect_file_chooser() as chooser:
        dialog.get_by_role("button", name="Another program’s log…").click()
    file = {"name": "again.mlg", "mimeType": "application/octet-stream", "buffer": data}
    chooser.value.set_files([file])
    dialog.get_by_role("button", name="All", exact=True).click()
    dialog.get_by_role("button", name="Compare", exact=True).click()
    expect(listed.find('[data-second="log:CLT"] b')).to_have_text("87")
    bar = listed.page.get_by_role("group", name="Comparison")
    bar.get_by_role("button", name="End the comparison").click()
