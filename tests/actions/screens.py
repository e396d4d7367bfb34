"""What a person opens on each screen: views, sheets, menus, what is drawn of a reference.

Each row begins with its screen as it is first shown, on a program that samples and has a recording
that is its latest; `close` leaves the screen so again.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from playwright.sync_api import Locator, expect

from browser.rig import Tab

Act = Callable[[Tab], object]
VIRTUAL = "Virtual car 7.1: warm idle"
PROBLEMS = "#screen .notice.signal-danger, dialog .notice.signal-danger, .toasts .signal-warning"
"""What the page shows of an error."""


def escape(tab: Tab) -> None:
    tab.page.keyboard.press("Escape")


@dataclass(frozen=True)
class Action:
    """`name`: with the screen's, that of its picture."""

    screen: str
    name: str
    open: Act
    close: Act = escape


def pressing(*names: str | re.Pattern[str]) -> Act:
    """Press buttons, one after the other, and wait for what they open, if that is a sheet."""

    def act(tab: Tab) -> None:
        for name in names:
            tab.page.get_by_role("button", name=name).first.click()

    return act


def exactly(*names: str) -> Act:
    return pressing(*(re.compile(f"^{re.escape(name)}$") for name in names))


def sheet(tab: Tab) -> Locator:
    return tab.page.get_by_role("dialog")


def menu(item: str) -> Act:
    """Choose from the chart's menu."""

    def act(tab: Tab) -> None:
        tab.press("More tools")
        tab.find("#screen .menu li").get_by_role("button", name=item).click()

    return act


def view(name: str) -> Act:
    def act(tab: Tab) -> None:
        tab.page.get_by_role("tab", name=name).click()
        expect(tab.find("#screen .small").first).to_be_visible()

    return act


def show_time(tab: Tab) -> None:
    tab.page.get_by_role("tab", name="Time").click()


def add_tile(tab: Tab) -> None:
    exactly("Edit")(tab)
    tab.press("Add…")


def end_editing(tab: Tab) -> None:
    escape(tab)
    exactly("Cancel")(tab)


def choose_carburettor(tab: Tab) -> None:
    tab.find("summary").get_by_text("Choose a car and its defect").click()
    exactly("Carburettor")(tab)
    expect(tab.find("#screen")).to_contain_text("controls the ignition alone")


def open_card(tab: Tab) -> None:
    tab.find('[data-opens="TWAT"]').first.click()
    expect(sheet(tab)).to_contain_text(re.compile("warm idle"))


def show_reference(tab: Tab) -> None:
    menu("Range of a reference")(tab)
    bar = tab.page.get_by_role("group", name="Reference")
    expect(bar).to_contain_text("computed, not measured on an engine")


def compare_with_virtual(tab: Tab) -> None:
    tab.page.get_by_label(re.compile("^Compare ")).first.click()
    sheet(tab).get_by_role("button", name=VIRTUAL).click()
    expect(tab.page.get_by_role("group", name="Comparison")).to_contain_text(VIRTUAL)
    expect(tab.find('[data-second="TWAT"] b')).to_have_text(re.compile("8[5-9]"))


def back_to_live(tab: Tab) -> None:
    tab.find("header[data-shown]").get_by_role("button", name="Back to live").click()


def ask_to_erase(tab: Tab) -> None:
    tab.press("Erase…")
    expect(sheet(tab)).to_be_visible()


def start_test(tab: Tab) -> None:
    tab.find("[data-test=idle]").get_by_role("button", name="Start").click()
    expect(tab.find(".todo")).to_be_visible()


def complain(tab: Tab) -> None:
    tab.find("#screen [role=group] .segment").first.click()
    expect(tab.find("[data-verdict]")).to_be_visible()


def of_a_recording(tab: Tab) -> None:
    """Choose the newest recording, which is shown as a reader computes it."""
    source = tab.find("#screen select").first
    name = source.locator("option").nth(1).get_attribute("value") or ""
    source.select_option(name)
    expect(tab.find("h1")).to_contain_text("recording")
    expect(tab.find("[data-verdict]")).to_be_visible()


def of_the_car(tab: Tab) -> None:
    tab.find("#screen select").first.select_option("live")
    expect(tab.find("[data-verdict]")).to_be_visible()


def read_memory(tab: Tab) -> None:
    tab.page.get_by_role("tab", name="XRAM").click()
    tab.find(".bar input").first.fill("8000")
    tab.find(".bar [type=submit]").click()
    expect(tab.find("[role=grid] [role=gridcell]").first).to_be_visible()


def of_recording(label: str) -> Act:
    def act(tab: Tab) -> None:
        tab.page.get_by_label(re.compile(f"^{label} ")).first.click()
        expect(sheet(tab)).to_be_visible()

    return act


def play(tab: Tab) -> None:
    tab.find("#screen").get_by_role("button", name="Open", exact=True).first.click()
    expect(tab.page.get_by_role("region", name="Player")).to_be_visible()


def stop_playing(tab: Tab) -> None:
    player = tab.page.get_by_role("region", name="Player")
    player.get_by_role("button", name="Close the recording").click()


def read_report(tab: Tab) -> None:
    expect(tab.page.frame_locator("#screen iframe").locator("h1")).to_be_visible()


def nothing(_: Tab) -> None:
    """Leave it so."""


ACTIONS = (
    Action("live", "editing", exactly("Edit"), exactly("Cancel")),
    Action("live", "add", add_tile, end_editing),
    Action("live", "big", pressing("Big numbers"), pressing("All tiles")),
    Action(
        "live",
        "big-values",
        pressing("Big numbers", "Values of the big numbers…"),
        lambda tab: (escape(tab), tab.press("All tiles")),
    ),
    Action("live", "card", open_card),
    Action("live", "keys", lambda tab: tab.page.keyboard.press("?")),
    Action("chart", "traces", pressing("Traces…")),
    Action("chart", "find", pressing("Find…")),
    Action("chart", "menu", pressing("More tools"), pressing("More tools")),
    Action("chart", "statistics", menu("Statistics…")),
    Action("chart", "markers", menu("Markers…")),
    Action("chart", "image", menu("Image…")),
    Action("chart", "reference", show_reference, menu("Range of a reference")),
    Action("chart", "scatter", view("Scatter"), nothing),
    Action("chart", "table", view("Table"), show_time),
    Action("connection", "carburettor", choose_carburettor, nothing),
    Action("faults", "erase", ask_to_erase),
    Action("tests", "running", start_test, pressing("End the test")),
    Action("causes", "complained", complain, complain),
    Action("causes", "recorded", of_a_recording, of_the_car),
    Action("passport", "shown", lambda tab: expect(tab.find("#screen dl").first).to_be_visible()),
    Action("memory", "read", read_memory, nothing),
    Action("recordings", "export", of_recording("Export")),
    Action("recordings", "compare", of_recording("Compare")),
    Action("recordings", "car", of_recording("Car details of")),
    Action("recordings", "delete", of_recording("Delete")),
    Action("recordings", "played", play, stop_playing),
    Action("recordings", "compared", compare_with_virtual, back_to_live),
    Action("report", "read", read_report, nothing),
)


def each_opened(tab: Tab) -> Iterator[str]:
    """Open what each row opens, and yield its name; the page must show no error meanwhile."""
    for action in ACTIONS:
        tab.show(action.screen)
        action.open(tab)
        expect(tab.find("#screen [aria-busy=true]")).to_have_count(0)
        expect(tab.find(PROBLEMS)).to_have_count(0)
        yield f"{action.screen}-{action.name}"
        action.close(tab)
