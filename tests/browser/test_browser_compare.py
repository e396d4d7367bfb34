"""Compare: two recordings over the same clock; gaps with their whole reason."""

from __future__ import annotations

import re

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

BOTH = ("FREQ", "THR", "INJ", "JAIR", "TWAT", "UACC")
REASON = Text(
    "The unit is silent. Is the ignition on? Turn the key, and look whether the lamp lights.",
    "Блок молчит. Включено ли зажигание? Поверните ключ и посмотрите, загорается ли лампа.",
)
GAP = 4.0  # s


def _drive(path, scenario, names, raws, gap=0.0):
    """A recording of about 5 s with each of the coolant's raw values, one after the other; `gap`
    seconds without an answer between them.
    """
    url = f"sim:?clock=simulated&scenario={scenario}"
    coolant = shipped().parameter("TWAT").code
    with CaptureWriter(path, url=url) as sink, mikas.connect(url, sink=sink) as ecu:
        link = ecu.tester.link
        write_session_header(
            sink,
            link.now(),
            version_code=ecu.version_code,
            passports=ecu.passport().pieces,
            catalog_version=ecu.catalog.version,
        )
        for number, raw in enumerate(raws):
            if number:
                sink.note(note_of(Marker(link.now(), "changed")))
                if gap:
                    began = link.now()
                    link.gather(began + gap)
                    sink.note(note_of(Gap(began, began, link.now(), REASON)))
            link.link.bus.ecu.responder.car.write(coolant, bytes([raw]))
            until = link.now() + 5
            for _ in ecu.watch(*names, method="batch"):
                if link.now() >= until:
                    break
    return path


@pytest.fixture(scope="module")
def drives(chromium, tmp_path_factory):
    """good: 87 °C, then 89; bad: 55, a gap, then 60, and no ignition advance. No line."""
    folder = tmp_path_factory.mktemp("drives")
    recordings = folder / "recordings"
    recordings.mkdir()
    scenario = folder / "still.toml"
    scenario.write_text(CAR, "utf-8")
    _drive(recordings / "good.pcapng", scenario, (*BOTH, "UOZ"), (0x7F, 0x81))
    _drive(recordings / "bad.pcapng", scenario, BOTH, (0x5F, 0x64), gap=GAP)
    with dashboard(folder, begin=False) as dash:
        yield dash


@pytest.fixture
def compared(drives, visitor):
    """The bad one beside the good one."""
    tab = visitor(drives.url).show("recordings")
    tab.press("Compare good.pcapng with…")
    tab.page.get_by_role("dialog").get_by_role("button", name="bad.pcapng").click()
    expect(bar(tab)).to_be_visible()
    return tab


def bar(tab):
    return tab.page.get_by_role("group", name="Comparison")


def second(tab, name):
    return tab.find(f'[data-second="{name}"] b')


def more(tab, name):
    """How much more it is in the first one."""
    return tab.find(f'[data-more="{name}"]')


def place(tab):
    return tab.page.get_by_role("slider", name="Position in the recording")


def moved(tab, seconds):
    expect(bar(tab).get_by_role("button", name=f"moved by {seconds} s")).to_be_visible()


def test_both_values_and_their_difference_are_shown(compared):
    expect(bar(compared)).to_contain_text(re.compile("good.pcapng Mikas 7.1.*bad.pcapng Mikas 7.1"))
    expect(compared.traced("TWAT")).to_have_text("87")
    expect(second(compared, "TWAT")).to_have_text("55")
    expect(more(compared, "TWAT")).to_have_text("+32")
    expect(more(compared, "UACC")).to_have_text("0.0")
    place(compared).press("End")
    expect(compared.traced("TWAT")).to_have_text("89")
    expect(second(compared, "TWAT")).to_have_text("60")
    expect(more(compared, "TWAT")).to_have_text("+29")


def test_a_small_laptop_has_room_for_every_difference(compared):
    compared.page.set_viewport_size({"width": 1366, "height": 768})
    for name in (*BOTH, "UOZ"):
        expect(compared.find(f'[data-second="{name}"]')).to_be_in_viewport(ratio=1)


def test_a_channel_missing_in_the_second_recording_is_named(compared):
    expect(compared.traced("UOZ")).to_have_text("−3.5")
    expect(compared.find('[data-second="UOZ"]')).to_contain_text("not recorded")
    expect(second(compared, "UOZ")).to_have_count(0)


def test_the_second_line_is_drawn_below_the_first(compared):
    """That of 55 °C, in the pane and the colour of the one of 87 °C."""
    expect(second(compared, "TWAT")).to_have_text("55")
    assert compared.until(_HEIGHTS.replace("ASKED", "rows => rows.some(at => at < 0.3)"))
    assert compared.until(_HEIGHTS.replace("ASKED", "rows => rows.some(at => at > 0.6)"))
    compared.press("End the comparison")
    expect(second(compared, "TWAT")).to_have_count(0)
    assert compared.until(_HEIGHTS.replace("ASKED", "rows => rows.length > 0"))


# Whether the rows of the coolant's pane with its colour, as shares of the height, are as ASKED.
_HEIGHTS = """() => {
  const pane = document.querySelector('[data-trace="TWAT"]').closest(".pane");
  const line = pane.querySelector('button:has([data-trace="TWAT"]) .line');
  const [red, green, blue] = getComputedStyle(line).backgroundColor.match(/\\d+/g).map(Number);
  const canvas = pane.querySelector("canvas");
  if (!canvas) return false;
  const copy = new OffscreenCanvas(canvas.width, canvas.height);
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const { data } = context.getImageData(0, 0, canvas.width, canvas.height);
  const near = (at) => Math.abs(data[at] - red) + Math.abs(data[at + 1] - green)
    + Math.abs(data[at + 2] - blue) < 60 && data[at + 3] > 100;
  const rows = [];
  for (let row = 0; row < canvas.height; row += 1) {
    let found = 0;
    for (let x = 70; x < canvas.width - 70; x += 1) found += near(4 * (row * canvas.width + x));
    if (found > 40) rows.push(row / canvas.height);
  }
  return (ASKED)(rows);
}"""


def test_it_is_moved_by_buttons_and_keys(compared):
    expect(second(compared, "TWAT")).to_have_text("55")
    bar(compared).get_by_role("button", name="Second one 0.1 s to the right").click()
    moved(compared, "+0.1")
    expect(second(compared, "TWAT")).to_have_text("–")
    for _ in range(10):
        compared.page.keyboard.press("Shift+BracketLeft")
    moved(compared, "−9.9")
    expect(second(compared, "TWAT")).to_have_text("60")
    expect(more(compared, "TWAT")).to_have_text("+27")
    bar(compared).get_by_role("button", name="Both from their start").click()
    moved(compared, "0.0")
    expect(second(compared, "TWAT")).to_have_text("55")


def test_it_is_aligned_by_a_moment_of_each(compared):
    """The middle of the second one's gap, 7 s from its beginning, with the first one's marker."""
    compared.page.keyboard.press("Shift+BracketRight")  # markers of one moment hide each other
    moved(compared, "+1.0")
    bar(compared).get_by_role("button", name="Align…").click()
    compared.says("Touch a moment on a dashed line")
    compared.find(".flags button.gap.second").click()
    compared.says("Now the same moment on the solid line")
    compared.find(".flags button.marker:not(.second)").click()
    moved(compared, "−1.999")
    compared.page.keyboard.press("a")
    compared.says("Touch a moment on a dashed line")
    compared.page.keyboard.press("Enter")  # where the cursor stands: in the gap again
    compared.find(".flags button.marker.second").click()  # the gap's beginning, 2 s before
    moved(compared, "−3.999")
    compared.page.keyboard.press("a")
    compared.page.keyboard.press("Escape")
    expect(compared.page.get_by_text("Touch a moment")).to_have_count(0)


def test_it_goes_on_while_the_first_one_plays(compared):
    compared.page.get_by_role("combobox", name="Speed").select_option("16")
    compared.press("Play")
    expect(second(compared, "TWAT")).to_have_text("60")
    expect(compared.traced("TWAT")).to_have_text("89")


def test_its_gap_is_a_gap_with_its_reason(compared):
    expect(compared.traced("TWAT")).to_have_text("87")
    for _ in range(6):
        place(compared).press("ArrowRight")
    expect(second(compared, "TWAT")).to_have_text("–")
    expect(compared.traced("TWAT")).to_have_text("89")
    compared.says(REASON.en)
    place(compared).press("End")
    expect(compared.page.get_by_text(REASON.en)).to_have_count(0)


def test_one_press_ends_the_comparison(compared):
    compared.page.keyboard.press("Shift+Slash")
    sheet = compared.page.get_by_role("dialog", name="Keys")
    expect(sheet).to_contain_text("End the comparison")
    sheet.get_by_role("button", name="Close").click()
    compared.page.keyboard.press("x")
    expect(bar(compared)).to_have_count(0)
    expect(second(compared, "TWAT")).to_have_count(0)
    expect(compared.traced("TWAT")).to_have_text("87")


def test_a_second_one_is_chosen_while_one_is_played(drives, visitor):
    tab = visitor(drives.url).show("recordings")
    tab.find("tr", has_text="bad.pcapng").get_by_role("button", name="Open").click()
    tab.press("Compare with…")
    sheet = tab.page.get_by_role("dialog")
    expect(sheet.get_by_role("button", name="bad.pcapng")).to_have_count(0)
    sheet.get_by_role("button", name="Close").click()
    tab.show("recordings").press("Compare bad.pcapng with good.pcapng")
    expect(tab.traced("TWAT")).to_have_text("55")
    expect(more(tab, "TWAT")).to_have_text("−32")


def test_a_gap_says_all_of_its_reason_to_keys_and_touch(drives, visitor):
    tab = visitor(drives.url).show("recordings")
    tab.find("tr", has_text="bad.pcapng").get_by_role("button", name="Open").click()
    expect(tab.value("TWAT")).to_have_text("55")
    tab.show("chart")
    expect(tab.traced("TWAT")).to_have_text("55")
    tab.page.keyboard.press("g")
    tab.says(REASON.en)
    tab.says("4.0 s.")
    expect(tab.traced("TWAT")).to_have_text("–")
    tab.page.keyboard.press("Escape")
    expect(tab.page.get_by_text(REASON.en)).to_have_count(0)
    tab.find(".flags button.gap").press("Enter")
    tab.says(REASON.en)


LEGENDS = """() => [...document.querySelectorAll(".legend")].flatMap((legend) => [
  legend.scrollHeight - legend.clientHeight,
  ...[...legend.querySelectorAll(".name")].map((it) => it.getClientRects()[0].height > 40),
]).filter(Number)"""
"""Legends that must be scrolled, and names broken into letters."""


@pytest.mark.parametrize("locale", ["en-GB", "ru-RU"])
def test_a_laptop_shows_all_values_of_its_legends(drives, visitor, locale):
    tab = visitor(drives.url, locale=locale, viewport={"width": 1366, "height": 768})
    tab.show("recordings")
    ru = locale == "ru-RU"
    tab.press("Сравнить good.pcapng с…" if ru else "Compare good.pcapng with…")
    tab.page.get_by_role("dialog").get_by_role("button", name="bad.pcapng").click()
    expect(more(tab, "TWAT")).to_have_text("+32")
    assert tab.page.evaluate(LEGENDS) == []
    # As much less as a message in the band takes.
    tab.page.set_viewport_size({"width": 1366, "height": 711})
    tab.page.wait_for_function(f"() => ({LEGENDS})().length === 0")
    tab.page.set_viewport_size({"width": 1366, "height": 768})
    tab.page.keyboard.press("x")  # no comparison any more
    tab.page.keyboard.press("c")
    expect(tab.find(".legend .more").first).to_be_visible()
    assert tab.page.evaluate(LEGENDS) == []


@pytest.mark.parametrize(("width", "height"), [(390, 844), (844, 390)])
def test_a_phone_has_room_for_it_in_russian(drives, visitor, width, height):
    viewport = {"width": width, "height": height}
    tab = visitor(drives.url, locale="ru-RU", viewport=viewport, has_touch=True)
    tab.show("recordings").press("Сравнить good.pcapng с…")
    tab.page.get_by_role("dialog").get_by_role("button", name="bad.pcapng").tap()
    group = tab.page.get_by_role("group", name="Сравнение")
    expect(group).to_be_visible()
    expect(more(tab, "TWAT")).to_have_text("+32")
    assert tab.find("#screen").bounding_box()["height"] > 160
    for button in group.get_by_role("button").all():
        box = button.bounding_box()
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= width
        assert box["height"] >= 40
    group.get_by_role("button", name="Закончить сравнение").tap()
    expect(group).to_have_count(0)
