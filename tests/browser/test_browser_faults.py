"""Faults: read, and erased in two steps; what was there stays in the journal."""

from __future__ import annotations

from playwright.sync_api import expect

from dashboard.recordings_rig import record_fault
from mikas.client import Ecu


def test_faults_are_read_and_erased_and_kept_in_the_journal(own, visitor):
    tab = visitor(own.url).show("faults")
    cards = tab.find("ol.cards article")
    expect(cards).to_have_count(2)
    expect(cards.nth(0)).to_contain_text("17")
    expect(cards.nth(1)).to_contain_text("41")
    tab.press("Erase…")
    sheet = tab.page.get_by_role("dialog")
    expect(sheet).to_contain_text("17")
    assert own.garage.car.faults == [17, 41]
    sheet.get_by_role("button", name="Cancel").click()
    assert own.garage.car.faults == [17, 41]
    tab.press("Erase…")
    sheet.get_by_role("button", name="Erase with the engine running").click()
    tab.says("No faults are stored")
    assert own.garage.car.faults == []
    expect(tab.find('nav a[data-screen="faults"] .count')).to_have_count(0)
    tab.find("summary", has_text="Journal").click()
    expect(tab.find("details li").first).to_contain_text("were stored: 17, 41")


def test_a_list_that_changed_meanwhile_is_shown_again_not_erased(own, visitor):
    tab = visitor(own.url).show("faults")
    tab.refused = True
    expect(tab.find("ol.cards article")).to_have_count(2)
    tab.press("Erase…")
    sheet = tab.page.get_by_role("dialog")
    expect(sheet).to_contain_text("41")
    own.garage.car.faults.append(53)
    sheet.get_by_role("button", name="Erase with the engine running").click()
    expect(sheet).to_contain_text("nothing was erased")
    expect(sheet).to_contain_text("53")
    assert own.garage.car.faults == [17, 41, 53]


def test_a_new_fault_is_announced_and_has_its_freeze_frame(own, visitor):
    own.until(lambda: own.state()["fault_count"] == 2)
    own.nobody_controls()
    tab = visitor(own.url).show("live")
    own.garage.car.faults.append(13)
    tab.says("New fault in the unit: 13")
    tab.press("Show")
    frame = tab.page.get_by_role("article", name="13: ").locator("details")
    frame.locator("summary").click()
    expect(frame).to_contain_text("The unit stored the fault at")
    expect(frame.get_by_role("row", name="Air flow")).to_contain_text("15.0 kg/h")
    expect(frame.locator("svg path").first).to_be_attached()
    expect(tab.page.get_by_role("article", name="17: ")).to_contain_text("No freeze frame")
    frame.get_by_role("button", name="Delete freeze frame").click()
    sheet = tab.page.get_by_role("dialog", name="Delete this freeze frame?")
    sheet.get_by_role("button", name="Cancel").click()
    expect(frame.locator("svg path").first).to_be_attached()
    frame.get_by_role("button", name="Delete freeze frame").click()
    sheet.get_by_role("button", name="Delete", exact=True).click()
    expect(tab.page.get_by_role("article", name="13: ")).to_contain_text("No freeze frame")


def test_a_recording_has_its_faults_with_the_frame_of_the_new_one(own, visitor):
    folder = own.dashboard.library.folder.folder
    folder.mkdir(exist_ok=True)
    record_fault(folder / "drive.pcapng")
    tab = visitor(own.url).show("recordings")
    tab.press("Open", exact=True)
    expect(tab.page).not_to_have_url(f"{own.url}/#/recordings")
    tab.show("faults")
    expect(tab.page.get_by_role("article", name="71: ")).to_contain_text("before the recording's")
    frame = tab.page.get_by_role("article", name="13: ").locator("details")
    frame.locator("summary").click()
    expect(frame).to_contain_text("The unit stored the fault at")
    expect(frame.get_by_role("row", name="Air flow")).to_contain_text("kg/h")
    expect(frame.locator("svg path").first).to_be_attached()
    frame.get_by_role("button", name="Show in chart").click()
    expect(tab.page.get_by_role("group", name="Moments")).to_contain_text("Fault 13 stored")


def test_an_erase_reads_the_faults_three_times(own, visitor, monkeypatch):
    """For the sheet, for the comparison with what the sheet showed, and back."""
    readings = []
    read = Ecu.faults

    def counted(ecu):
        readings.append(read(ecu))
        return readings[-1]

    tab = visitor(own.url).show("faults")
    expect(tab.find("ol.cards article")).to_have_count(2)
    monkeypatch.setattr(Ecu, "faults", counted)
    tab.press("Erase…")
    sheet = tab.page.get_by_role("dialog")
    expect(sheet).to_contain_text("17")
    sheet.get_by_role("button", name="Erase with the engine running").click()
    tab.says("No faults are stored")
    tab.find("summary", has_text="Journal").click()
    expect(tab.find("details li").first).to_contain_text("were stored: 17, 41")
    samples = own.state()["samples"]
    own.until(lambda: own.state()["samples"] > samples + 9)
    assert [[fault.code for fault in each] for each in readings] == [[17, 41], [17, 41], []]


def test_frames_that_can_not_be_saved_are_said_until_that_is_closed(own, visitor, tmp_path, said):
    (tmp_path / "state").mkdir(exist_ok=True)
    (tmp_path / "state" / "freeze-frames").write_text("in the place of the folder")
    own.until(lambda: own.state()["fault_count"] == 2)
    own.nobody_controls()
    tab = visitor(own.url, viewport={"width": 390, "height": 844}).show("live")
    own.garage.car.faults.append(13)
    tab.says("Freeze frames can't be saved in")
    notice = tab.find(".toast", has_text="Freeze frames can't be saved")
    own.garage.car.faults.append(14)
    tab.says("New fault in the unit: 14")
    expect(notice).to_have_count(1)
    notice.get_by_role("button", name="Close").click()
    expect(notice).to_have_count(0)
    assert len(said) == 1
