"""Chart: it moves with the data; a frozen view does not stop what is recorded."""

from __future__ import annotations

from playwright.sync_api import expect

PAINTED = "document.querySelector('.panes canvas')?.toDataURL()"
"""Nothing until the plot is made: that is after the legend, when the pane knows how large it is."""


def test_new_values_are_drawn(dash, visitor):
    tab = visitor(dash.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    before = tab.until(PAINTED)
    assert tab.until(f"before => {PAINTED} !== before", before)
    dash.garage.set("TWAT", "80")
    expect(tab.traced("TWAT")).to_have_text("88")
    dash.garage.set("TWAT", "7F")
    expect(tab.traced("TWAT")).to_have_text("87")


def test_a_frozen_view_stands_and_the_recording_goes_on(own, visitor):
    tab = visitor(own.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.page.keyboard.press("r")
    tab.is_line("recording")
    tab.page.keyboard.press("Space")
    tab.says("View frozen")
    own.garage.set("TWAT", "80")
    began = own.state()["recording"]["samples"]
    own.until(lambda: own.state()["recording"]["samples"] > began + 5)
    expect(tab.traced("TWAT")).to_have_text("87")
    standing = tab.until(PAINTED)
    own.until(lambda: own.state()["recording"]["samples"] > began + 15)
    assert tab.page.evaluate(PAINTED) == standing
    tab.page.keyboard.press("Space")
    expect(tab.traced("TWAT")).to_have_text("88")


def test_a_marker_is_a_flag_over_the_panes(own, visitor):
    tab = visitor(own.url).show("chart")
    expect(tab.traced("TWAT")).to_have_text("87")
    tab.page.keyboard.press("m")
    expect(tab.find(".flags button.marker")).to_have_count(1)


def test_the_legend_tells_the_values_at_the_cursor(dash, visitor):
    tab = visitor(dash.url).show("chart")
    dash.garage.set("INJ", "E8 03")
    expect(tab.traced("INJ")).to_have_text("8.00")
    dash.garage.set("INJ", "F4 01")
    expect(tab.traced("INJ")).to_have_text("4.00")
    tab.press("10 s")
    tab.page.keyboard.press("Space")
    tab.find(".panes").focus()
    for _ in range(120):  # from the middle of the window on, to where it was 8 ms
        tab.page.keyboard.press("ArrowRight")
        if tab.traced("INJ").inner_text() == "8.00":
            break
    expect(tab.traced("INJ")).to_have_text("8.00")
    tab.page.keyboard.press("Escape")
    expect(tab.traced("INJ")).to_have_text("4.00")
