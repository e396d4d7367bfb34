"""Chart: what can be seen of each line, and where the window is."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from playwright.sync_api import expect

import mikas
from browser.rig import CAR, dashboard
from mikas.catalog import shipped
from mikas.i18n import Text
from mikas.recording import CaptureWriter
from mikas.recording.annotations.events import note_of
from mikas.sampling.events import Gap, Marker
from session_header_harness import write_session_header

REASON = Text("The unit is silent. Is the ignition on?", "Блок молчит. Включено ли зажигание?")

HEIGHT_OF = """name => {
  const row = document.querySelector(`[data-trace="${name}"]`)?.closest("button");
  const canvas = row?.closest(".pane").querySelector("canvas");
  if (!canvas) return null;
  const colour = getComputedStyle(row.querySelector(".line")).backgroundColor;
  const [red, green, blue] = colour.match(/\\d+/g).map(Number);
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const left = 70;
  const width = canvas.width - 140;
  const { data } = context.getImageData(left, 0, width, canvas.height);
  let best = null;
  let most = 20;
  const rows = [];
  for (let row = 0; row < canvas.height; row += 1) {
    let found = 0;
    for (let at = row * width * 4; at < (row + 1) * width * 4; at += 4) {
      found += data[at] === red && data[at + 1] === green && data[at + 2] === blue;
    }
    if (found > most) [best, most] = [row, found];
    if (found > 0) rows.push(row);
  }
  return best && { row: best, height: canvas.height, extent: rows.at(-1) - rows[0] };
}"""
"""The row of pixels that has most of the trace's colour; null while it has none."""
STEP_OF = f"""name => {{
  const found = ({HEIGHT_OF})(name);
  return found?.extent > 3 && found;
}}"""
"""The same, once the line is no longer a flat one."""


def height_of(tab, name):
    found = tab.until(HEIGHT_OF, name)
    return found["row"], found["height"]


def test_two_constant_traces_are_both_seen(own, visitor):
    """Coolant in alarm and voltage, and a standing engine with its throttle closed."""
    own.garage.set("TWAT", "9D")
    own.garage.set("FREQ", "00")
    tab = visitor(own.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("117")
    expect(tab.traced("FREQ")).to_have_text("0")
    began = own.state()["samples"]
    own.until(lambda: own.state()["samples"] > began + 20)
    for one, other in (("TWAT", "UACC"), ("FREQ", "THR")):
        (above, height), (below, _) = height_of(tab, one), height_of(tab, other)
        assert abs(above - below) > 0.04 * height
        assert 0 < min(above, below) < max(above, below) < height - 2
    own.garage.set("UACC", "8B")  # one raw step
    found = tab.until(STEP_OF, "UACC")
    assert found["extent"] < 0.15 * found["height"]


STRIPED = """name => {
  const pane = document.querySelector(`[data-trace="${name}"]`)?.closest(".pane");
  const canvas = pane?.querySelector("canvas");
  if (!canvas) return null;
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(Math.round(canvas.width * 0.6) + 1, 0, 1, canvas.height);
  let rows = 0;
  for (let at = 3; at < data.length; at += 4) rows += data[at] > 20 && data[at] < 60;
  return rows > 5;
}"""
"""Whether the trace's pane has rows that are tinted: the lines and the grid are opaque."""


def test_a_references_range_is_a_stripe_behind_the_live_trace(own, visitor):
    own.post("/recording/start", {"name": "good"})
    began = own.state()["samples"]
    own.until(lambda: own.state()["samples"] > began + 5)
    own.garage.set("TWAT", "7A")  # 82 °C, before 87: the range of the recording
    own.until(lambda: own.get("/history?seconds=1&names=TWAT")["values"][0][-1] == 82)
    own.post("/recording/stop")
    (recording,) = own.get("/recordings")["recordings"]
    own.put(f"/recordings/{recording['id']}/reference", {"on": True})

    tab = visitor(own.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("82")
    assert not tab.page.evaluate(STRIPED, "TWAT")
    tab.press("More tools")
    tab.press("Range of a reference")
    bar = tab.page.get_by_role("group", name="Reference")
    chosen = bar.get_by_role("combobox")
    expect(chosen.locator("option:checked")).to_have_text("Virtual car, warm idle")
    expect(bar).to_contain_text("computed, not measured on an engine")
    tab.until(STRIPED, "TWAT")

    chosen.select_option(recording["id"])
    tab.until(STRIPED, "TWAT")
    tab.page.reload()
    expect(chosen).to_have_value(recording["id"])
    tab.until(STRIPED, "TWAT")
    tab.press("More tools")
    tab.press("Image…")
    with tab.page.expect_download() as download:
        tab.page.get_by_role("dialog").get_by_role("button", name="Save SVG").click()
    svg = Path(download.value.path()).read_text("utf-8")
    assert "fill-opacity" in svg
    # The day is the page's own: of the window's start, without a zero, “Sept” in full.
    assert re.search(r"<title>live values · \d{1,2} [A-Z][a-z]{2,3} 20\d\d, \d\d:\d\d</title>", svg)
    assert f"stripes: range of ★ {recording['id']}" in svg
    tab.page.keyboard.press("Escape")

    bar.get_by_role("button", name="Remove the stripes").click()
    expect(bar).to_have_count(0)
    tab.until(f"name => !({STRIPED})(name)", "TWAT")


def _trip(folder):
    """A recording of 60 s: 87 °C, from its middle on 100 °C, where a marker and a gap are."""
    scenario = folder / "still.toml"
    scenario.write_text(CAR, "utf-8")
    folder = folder / "recordings"
    folder.mkdir()
    url = f"sim:?clock=simulated&scenario={scenario}"
    with (
        CaptureWriter(folder / "trip.pcapng", url=url) as sink,
        mikas.connect(url, sink=sink) as ecu,
    ):
        link = ecu.tester.link
        write_session_header(
            sink,
            link.now(),
            version_code=ecu.version_code,
            passports=ecu.passport().pieces,
            catalog_version=ecu.catalog.version,
        )
        for raw in (0x7F, 0x8C):
            link.link.bus.ecu.responder.car.write(shipped().parameter("TWAT").code, bytes([raw]))
            until = link.now() + 30
            for _ in ecu.watch("FREQ", "THR", "TWAT", "UACC", method="batch"):
                if link.now() >= until:
                    break
            if raw == 0x7F:
                sink.note(note_of(Marker(link.now(), "")))
                began = link.now()
                link.gather(began + 3)
                sink.note(note_of(Gap(began, began, link.now(), REASON)))


@pytest.fixture(scope="module")
def stored(chromium, tmp_path_factory):
    """The program with that recording, and no line."""
    folder = tmp_path_factory.mktemp("trip")
    _trip(folder)
    with dashboard(folder, begin=False) as dash:
        yield dash


def opened(stored, visitor, **wishes):
    """The chart of that recording."""
    stored.nobody_controls()
    tab = visitor(stored.url, **wishes).show("recordings")
    tab.find("#screen").get_by_role("button", name="Open").first.click()
    expect(tab.page.get_by_role("region", name="Player")).to_be_visible()
    tab.show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    expect(tab.find(".panes canvas").first).to_be_visible()
    return tab


def span(tab, name):
    return tab.find(".spans").get_by_role("button", name=name, exact=True)


def position(tab):
    """Seconds from the beginning, of the player."""
    slider = tab.page.get_by_role("slider", name="Position in the recording")
    return float(slider.get_attribute("aria-valuenow"))


def at(tab, share):
    """A point of the first plot, that share of its width from its left axis."""
    box = tab.find(".panes .plot").first.bounding_box()
    return box["x"] + 58 + share * (box["width"] - 116), box["y"] + box["height"] / 2


def test_the_window_of_a_recording_stays_in_it_and_keeps_the_position(stored, visitor):
    tab = opened(stored, visitor)
    mouse = tab.page.mouse
    expect(span(tab, "all")).to_have_attribute("aria-pressed", "true")
    expect(span(tab, "5 min")).to_have_count(0)  # longer than the recording
    mouse.click(*at(tab, 0.25))
    tab.until("() => document.querySelector('[role=slider]').ariaValueNow > 10")
    assert 12 <= position(tab) <= 19
    span(tab, "10 s").click()
    expect(span(tab, "10 s")).to_have_attribute("aria-pressed", "true")
    expect(span(tab, "all")).to_have_attribute("aria-pressed", "false")
    expect(tab.find(".panes .head")).to_have_count(4)  # the position is in view
    before = position(tab)
    mouse.click(*at(tab, 0.0))
    tab.until("before => document.querySelector('[role=slider]').ariaValueNow < before", before)
    assert position(tab) > before - 10
    mouse.move(*at(tab, 0.9))
    for _ in range(12):
        mouse.wheel(0, 200)
    expect(span(tab, "all")).to_have_attribute("aria-pressed", "true")
    mouse.click(*at(tab, 0.999))
    tab.until("() => document.querySelector('[role=slider]').ariaValueNow > 60")
    mouse.click(*at(tab, 0.001))
    tab.until("() => document.querySelector('[role=slider]').ariaValueNow < 1")


def test_what_is_said_at_the_cursor_covers_no_trace(stored, visitor):
    tab = opened(stored, visitor)
    tab.page.keyboard.press("g")
    line = tab.find(".top .at")
    expect(line).to_contain_text("Gap from")
    expect(line).to_contain_text("s from the start")
    box = line.bounding_box()
    first = tab.find(".panes").bounding_box()
    assert box["y"] + box["height"] <= first["y"] + 1


@pytest.mark.parametrize(("width", "height"), [(390, 844), (844, 390)])
def test_on_a_phone_the_chart_has_the_room(stored, visitor, width, height):
    tab = opened(stored, visitor, viewport={"width": width, "height": height}, has_touch=True)
    player = tab.page.get_by_role("region", name="Player")
    assert player.bounding_box()["height"] <= 60
    screen, plot = tab.find("main").bounding_box(), tab.find(".panes .plot").first.bounding_box()
    assert plot["y"] - screen["y"] <= 200
    last = tab.find(".panes .plot").last
    last.scroll_into_view_if_needed()
    box = last.bounding_box()
    assert screen["y"] <= box["y"]
    assert box["y"] + box["height"] <= screen["y"] + screen["height"] + 1
    assert tab.page.evaluate("document.documentElement.scrollWidth") <= width
    for name, title in (("Statistics…", "Statistics"), ("Find…", "Find moments")):
        tab.find("main").evaluate("it => it.scrollTo(0, 0)")
        tab.press("More tools")
        tab.page.get_by_role("button", name=name, exact=True).tap()
        sheet = tab.page.get_by_role("dialog")
        sheet.get_by_role("heading", name=title).first.wait_for()
        tab.page.keyboard.press("Escape")
        expect(sheet).to_have_count(0)
    info = tab.find(".legend .card").first.bounding_box()
    assert min(info["width"], info["height"]) >= 44
    player.get_by_role("button", name="More player controls").click()
    expect(player.get_by_role("button", name="Close the recording")).to_be_visible()


def test_a_marker_is_named_at_once_and_another_time(own, visitor):
    """It has the moment of the key, whatever the name takes; the recording has the name, too."""
    tab = visitor(own.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.page.keyboard.press("r")
    tab.is_line("recording")
    own.until(lambda: own.state()["recording"]["samples"] > 5)
    file = own.state()["recording"]["file"]
    tab.page.keyboard.press("m")
    field = tab.page.get_by_role("textbox", name="Its name")
    expect(field).to_be_focused()
    began = own.state()["samples"]
    own.until(lambda: own.state()["samples"] > began + 10)
    tab.page.keyboard.type("rattle")
    tab.page.keyboard.press("Enter")
    expect(field).to_have_count(0)
    expect(tab.find(".flags button.marker")).to_contain_text("rattle")
    (mark,) = [it for it in own.get("/history")["events"] if it["kind"] == "marker"]
    assert mark["label"] == "rattle"
    tab.page.keyboard.press("r")
    tab.is_line("sampling")
    detail = own.get(f"/recordings/{file}")
    assert [it for it in detail["events"] if it["kind"] == "marker"] == [mark]


def test_markers_of_a_recording_are_found_and_named(stored, visitor):
    tab = opened(stored, visitor)
    tab.page.keyboard.press("n")
    tab.until("() => document.querySelector('[role=slider]').ariaValueNow > 25")
    assert 28 <= position(tab) <= 32
    tab.find(".top").get_by_role("button", name="Markers…").click()
    sheet = tab.page.get_by_role("dialog")
    sheet.get_by_role("textbox").fill("valve sticks")
    sheet.get_by_role("textbox").press("Enter")
    expect(tab.find(".flags button.marker")).to_contain_text("valve sticks")

    def kept():
        events = stored.get("/recordings/trip.pcapng")["events"]
        return [it["label"] for it in events if it["kind"] == "marker"]

    assert kept() == ["valve sticks"]
    sheet.get_by_role("button", name="Delete the marker").click()
    expect(tab.find(".flags button.marker")).to_have_count(0)
    assert kept() == []
    sheet.get_by_role("button", name="Undo").click()
    expect(tab.find(".flags button.marker")).to_contain_text("valve sticks")
    assert kept() == ["valve sticks"]


def test_an_open_recording_is_marked_where_it_stands(stored, visitor):
    tab = opened(stored, visitor)
    tab.page.keyboard.press("m")
    field = tab.page.get_by_role("textbox", name="Its name")
    field.fill("rattle")
    field.press("Enter")
    expect(tab.find(".flags button.marker").filter(has_text="rattle")).to_have_count(1)
    events = stored.get("/recordings/trip.pcapng")["events"]
    marks = [it for it in events if it["kind"] == "marker" and it["label"] == "rattle"]
    assert len(marks) == 1
    assert not stored.get("/history")["events"]  # no marker of live data
    place = f"/api/recordings/trip.pcapng/marker?time={marks[0]['time']!r}"
    stored.api.delete(place).raise_for_status()


def test_the_chart_is_saved_as_vectors_and_as_an_image_and_copied(stored, visitor):
    car = {"car": "Volga 3110", "plate": "А123ВС 52", "mileage": None, "workshop": ""}
    stored.put("/recordings/trip.pcapng/car", car)
    tab = opened(stored, visitor)
    tab.page.context.grant_permissions(["clipboard-read", "clipboard-write"], origin=tab.url)
    tab.press("More tools")
    tab.press("Image…")
    sheet = tab.page.get_by_role("dialog")
    with tab.page.expect_download() as download:
        sheet.get_by_role("button", name="Save SVG").click()
    assert download.value.suggested_filename == "trip.svg"
    svg = Path(download.value.path()).read_text("utf-8")
    root = ET.fromstring(svg)
    drawn = {child.tag.partition("}")[2] for child in root.iter()}
    assert "path" in drawn
    assert "image" not in drawn
    texts = [child.text for child in root.iter() if child.tag.endswith("text")]
    assert any(text.startswith("Volga 3110 · А123ВС 52 · trip.pcapng") for text in texts)
    assert any("Mikas 7.1" in text for text in texts)
    assert "87 °C" in texts
    assert any("Coolant" in text for text in texts)
    assert "13.8 V" in texts
    with tab.page.expect_download() as download:
        sheet.get_by_role("button", name="Save PNG").click()
    png = Path(download.value.path()).read_bytes()
    width, height = (int.from_bytes(png[at : at + 4], "big") for at in (16, 20))
    assert png.startswith(b"\x89PNG")
    assert (width, height) == (2 * int(root.get("width")), 2 * int(root.get("height")))
    sheet.get_by_role("button", name="Copy").click()
    tab.says("Image copied")
    kinds = "async () => (await navigator.clipboard.read()).flatMap((it) => it.types)"
    assert tab.page.evaluate(kinds) == ["image/png"]
