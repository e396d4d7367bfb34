"""Recordings: made, replayed in the same screens, exported, reported, deleted."""

from __future__ import annotations

import csv
import re
from io import StringIO
from itertools import pairwise
from pathlib import Path

import pytest
from playwright.sync_api import expect

from browser.rig import gaps_of


@pytest.fixture(scope="module")
def with_recording(served):
    """A recording of 87 °C and then 88 °C, with a marker where it changed; 55 °C since."""
    served.post("/recording/start", {"name": "drive"})
    _more(served)
    served.garage.set("TWAT", "80")
    served.post("/recording/marker", {"label": "hotter"})
    _more(served)
    served.post("/recording/stop")
    served.garage.set("TWAT", "5F")
    return served


@pytest.fixture
def recorded(with_recording):
    with_recording.nobody_controls()
    return with_recording


def _more(dash):
    began = dash.state()["recording"]["samples"]
    dash.until(lambda: dash.state()["recording"]["samples"] >= began + 10)


def test_r_records_m_marks_r_ends(own, visitor):
    tab = visitor(own.url).show("live")
    expect(tab.value("TWAT")).to_have_text("87")
    tab.page.keyboard.press("r")
    tab.is_line("recording")
    expect(tab.line).to_have_text("Recording")
    own.until(lambda: own.state()["recording"]["samples"] > 5)
    tab.page.keyboard.press("m")
    own.until(lambda: any(it["kind"] == "marker" for it in own.get("/history")["events"]))
    expect(tab.page.get_by_role("textbox", name="Its name")).to_be_focused()
    tab.page.keyboard.press("Escape")
    tab.page.keyboard.press("r")
    tab.is_line("sampling")
    (made,) = own.get("/recordings")["recordings"]
    assert (made["open"], made["markers"], gaps_of(own, made)) == (False, 1, [])
    tab.show("recordings")
    expect(tab.find("tbody tr")).to_have_count(1)
    expect(tab.find("tbody tr")).to_contain_text("M71 PROG")


def test_recordings_from_elsewhere_are_added(own, recorded, visitor, tmp_path):
    sent = tmp_path / "sent.pcapng"
    sent.write_bytes(recorded.api.get("/api/recordings/drive.pcapng/file").content)
    (tmp_path / "photo.pcapng").write_bytes(b"GIF89a")
    tab = visitor(own.url).show("recordings")
    files = [sent, tmp_path / "photo.pcapng"]
    with tab.page.expect_file_chooser() as chooser:
        tab.page.get_by_role("button", name="Add…").click()
    chooser.value.set_files(files)
    expect(tab.find("tbody tr")).to_have_count(1)
    expect(tab.find("tbody tr")).to_contain_text("sent.pcapng")
    expect(tab.find(".toasts")).to_contain_text("1 recording added.")
    expect(tab.find(".toasts")).to_contain_text("photo.pcapng")
    tab.complaints.clear()  # of the refused one


def test_it_is_played_in_the_same_screens(recorded, visitor):
    tab = visitor(recorded.url).show("live")
    expect(tab.value("TWAT")).to_have_text("55")
    tab.show("recordings").press("Open")
    player = tab.page.get_by_role("region", name="Player")
    expect(player).to_contain_text("drive.pcapng")
    expect(tab.value("TWAT")).to_have_text("87")
    expect(tab.value("UACC")).to_have_text("13.8")
    player.get_by_role("slider").press("End")
    expect(tab.value("TWAT")).to_have_text("88")
    tab.show("chart")
    expect(tab.traced("TWAT")).to_have_text("88")
    expect(tab.find(".flags button.marker")).to_have_accessible_name(re.compile("hotter$"))
    player.get_by_role("slider").press("Home")
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.page.keyboard.press("Space")
    expect(tab.traced("TWAT")).to_have_text("88")
    player.get_by_role("button", name="Close the recording").click()
    expect(tab.traced("TWAT")).to_have_text("55")


def test_what_is_played_is_never_taken_for_live(recorded, visitor):
    tab = visitor(recorded.url).show("faults")
    expect(tab.find("ol.cards article")).to_have_count(2)
    tab.show("recordings").press("Open")
    band = tab.find("header[data-shown]")
    expect(band).to_have_attribute("data-shown", "recording")
    expect(band).to_contain_text("Recording, not live")
    expect(band).to_contain_text("drive.pcapng")
    expect(band).not_to_contain_text("readings/s")
    tab.show("faults")
    tab.says("2 faults stored, as last read in the recording")
    expect(tab.find("ol.cards article")).to_have_count(0)
    band.get_by_role("button", name="Back to live").click()
    expect(tab.find("ol.cards article")).to_have_count(2)
    expect(band).to_have_attribute("data-shown", "live")


def test_a_table_of_it_is_downloaded(recorded, visitor):
    tab = visitor(recorded.url).show("recordings")
    tab.press("Export drive.pcapng")
    with tab.page.expect_download() as download:
        tab.press(".csv", exact=True)
    assert download.value.suggested_filename == "drive.csv"
    text = Path(download.value.path()).read_text("utf-8-sig")
    head, *rows = csv.reader(StringIO(text))
    column = next(n for n, name in enumerate(head) if name.startswith("TWAT"))
    values = [float(row[column]) for row in rows if row[column]]
    assert values[0] == 87
    assert values[-1] == 88
    assert set(values) == {87, 88}


def test_the_report_is_shown_and_opens_by_itself(recorded, visitor):
    tab = visitor(recorded.url).show("recordings")
    tab.find("tbody").get_by_role("link", name="Report on drive.pcapng").click()
    frame = tab.page.frame_locator("iframe")
    expect(frame.locator("h1")).to_be_visible()
    expect(frame.locator("body")).to_contain_text("M71 PROG")
    with tab.page.expect_popup() as opened:
        tab.page.get_by_role("link", name="Open in a new tab").click()
    expect(opened.value.locator("body")).to_contain_text("M71 PROG")


def test_with_a_recording_open_the_report_is_of_that_and_says_so(recorded, visitor):
    tab = visitor(recorded.url)
    tab.show("recordings").press("Open")
    expect(tab.page.get_by_role("slider")).to_be_visible()
    tab.page.get_by_role("navigation").get_by_role("link", name="Report").click()
    heading, frame = tab.page.locator("h1"), tab.page.frame_locator("iframe")
    expect(heading).to_have_text("Report: recording drive")
    expect(frame.locator("header")).to_contain_text("From the recording drive.pcapng")
    tab.page.get_by_label("Source").select_option("live")
    expect(heading).to_have_text("Report: live car")
    expect(frame.locator("header")).not_to_contain_text("drive.pcapng")


def test_the_report_has_the_alarm_and_doubts_no_sensor_without_a_fault_of_it(own, visitor):
    """195 is of the fan's relay, 71 of the idle speed: neither makes a value doubtful; 13 does."""
    own.garage.set("TWAT", "9D")
    own.garage.car.faults[:] = [13, 71, 195]
    own.until(lambda: own.state()["alarms"] and own.state()["fault_count"] == 3)
    body = visitor(own.url).show("report").page.frame_locator("iframe").locator("body")
    expect(body).to_contain_text("coolant temperature above 100 °C (highest 117 °C)")
    expect(body).to_contain_text("still on at the end")
    expect(body).to_contain_text("measured: Air flow 15.0 kg/h (perhaps a substitute value)")
    measured = body.get_by_text("measured: ")
    expect(measured.filter(has_text="Coolant temperature 117 °C")).not_to_contain_text("perhaps")
    expect(measured.filter(has_text="at idle")).not_to_contain_text("perhaps")


def test_statistics_of_what_is_drawn(recorded, visitor):
    tab = visitor(recorded.url)
    tab.show("recordings").press("Open")
    expect(tab.page.get_by_role("slider")).to_be_visible()
    tab.show("chart").page.get_by_role("button", name="More").click()
    tab.page.get_by_text("Statistics…").click()
    coolant = tab.page.get_by_role("dialog").get_by_role("region", name="Coolant temperature")
    expect(coolant).to_contain_text(re.compile(r"Lowest\s*87 °C"))
    expect(coolant).to_contain_text(re.compile(r"Highest\s*88 °C"))
    expect(coolant).to_contain_text(re.compile(r"Mean\s*87\.\d °C"))
    expect(coolant).to_contain_text(re.compile(r"Above 100 °C\s*0\.0 s \(0 %\)"))
    coolant.get_by_role("textbox").fill("87,5")
    expect(coolant).to_contain_text(re.compile(r"Above 87\.5 °C\s*\d+\.\d s \([1-9]\d? %\)"))


def test_statistics_between_the_cursors_are_copied(recorded, visitor):
    tab = visitor(recorded.url, permissions=["clipboard-read", "clipboard-write"])
    tab.show("recordings").press("Open")
    expect(tab.page.get_by_role("slider")).to_be_visible()
    box = tab.show("chart").find(".panes .plot").first.bounding_box()
    height, left, width = box["y"] + box["height"] / 2, box["x"] + 58, box["width"] - 116
    tab.page.mouse.click(left + 0.05 * width, height)
    tab.page.keyboard.press("c")
    tab.page.mouse.click(left + 0.2 * width, height)  # within the first half: 87 °C
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.press("More tools")
    tab.page.get_by_text("Statistics…").click()
    sheet = tab.page.get_by_role("dialog")
    expect(sheet).to_contain_text("Between the cursors")
    coolant = sheet.get_by_role("region", name="Coolant temperature")
    expect(coolant).to_contain_text(re.compile(r"Highest\s*87 °C"))
    sheet.get_by_role("button", name="Copy as a table").click()
    tab.says("Copied")
    copied = tab.page.evaluate("navigator.clipboard.readText()")
    head, *rows = [line.split("\t") for line in copied.splitlines()]
    (row,) = [dict(zip(head, row, strict=False)) for row in rows if row[0] == "TWAT"]
    assert [row[name] for name in ("Unit", "Lowest", "Highest", "Mean")] == ["°C", "87", "87", "87"]
    assert max(len(cell) for cell in row.values()) < 12


def test_a_recording_is_deleted_only_after_a_confirmation(recorded, visitor):
    tab = visitor(recorded.url).show("recordings")
    tab.press("Delete drive.pcapng")
    sheet = tab.page.get_by_role("dialog")
    sheet.get_by_role("button", name="Cancel").click()
    assert len(recorded.get("/recordings")["recordings"]) == 1
    tab.press("Delete drive.pcapng")
    sheet.get_by_role("button", name="Delete", exact=True).click()
    tab.says("No recordings yet")
    assert recorded.get("/recordings")["recordings"] == []


def test_other_presets_during_a_recording_leave_no_gap_in_the_file(own, visitor):
    """At full speed, by requests, where the values on the screen come first."""
    own.put("/plan", {"wanted": own.state()["plan"]["wanted"], "method": "batch"})
    own.nobody_controls()
    tab = visitor(own.url).show("live")
    tab.press("Record")
    tab.says("Recording all values")
    for preset, name in (("Fuel", "UGB"), ("Ignition", "UOZ"), ("Idle", "TWAT"), ("All", "TAIR")):
        tab.page.get_by_role("tab", name=preset, exact=True).click()
        own.until(lambda shown=name: shown in own.state()["plan"]["first"])
        _more(own)
    tab.press("Stop recording")
    (made,) = own.get("/recordings")["recordings"]
    assert gaps_of(own, made) == []
    detail = own.get(f"/recordings/{made['id']}")
    assert set(detail["channels"]) == {it["name"] for it in own.state()["plan"]["wanted"]}
    assert not [event for event in detail["events"] if event["kind"] == "state"][1:]
    rows = own.get(f"/recordings/{made['id']}/rows?points=20000")
    for name, column in zip(rows["names"], rows["values"], strict=True):
        read = [time for time, v in zip(rows["times"], column, strict=True) if v is not None]
        assert max(b - a for a, b in pairwise(read)) < 1, name
