"""What a person does about the unit: its faults, guided tests, causes, passport, memory."""

from __future__ import annotations

from playwright.sync_api import FilePayload, expect

from browser.rig import Tab

from .on_live import BAND, CLOSE, TOASTS
from .on_writing import WRITING
from .steps import (
    CLOSED,
    SHEET,
    Repeats,
    Shot,
    Step,
    fill,
    front,
    go,
    gone,
    on_screen,
    press,
    row,
    saves,
    says,
    shows,
    tick,
)  # fmt: skip

FAULT = "ol.cards article"
TEST = "[data-test=idle]"
VERDICT = "section.verdict"
CANCEL = press("dialogs/Confirm cancel")
DUMP = "article:has-text('XRAM 8100–813F')"
LONG = "article:has-text('XRAM 0000–7FFF')"
DIFFERS = f"{SHEET} .pair:has-text('9000') .differs"


def choose_other(tab: Tab) -> None:
    """Choose the other dump of those bytes."""
    select = front(tab).get_by_label("Compare with another dump")
    other = select.locator("option", has_text="9000").get_attribute("value")
    select.select_option(value=other)


DUMP_FORM = "form:has-text('Start the dump')"
WRITTEN = "article:has-text('XRAM 9000–903F')"


def dumped(first: str, last: str) -> tuple[Step, ...]:
    """Start a dump of XRAM."""
    return (
        lambda tab: tab.find(DUMP_FORM).get_by_label("Space").select_option(label="XRAM"),
        lambda tab: tab.find(DUMP_FORM).get_by_label("From").fill(first),
        lambda tab: tab.find(DUMP_FORM).get_by_label("To").fill(last),
        press("memory/dumps/DumpForm dump_start"),
    )


def refused(content: bytes, why: str) -> tuple[Step, ...]:
    """Choose a file that is no dump."""
    file = FilePayload(name="no.bin", mimeType="application/octet-stream", buffer=content)
    return (
        lambda tab: tab.find(f"{SHEET} [type=file]").set_input_files(file),
        shows(f"{SHEET} .notice", why),
        gone(f"{SHEET} .pair"),
    )


FAULTS = (
    row(
        "faults",
        "faults are read, explained and copied",
        shows(FAULT),
        press("faults/Screen again"),
        press(
            "faults/FaultCard {localized(catalog.get(name)?.text) || name}", css=f"{FAULT} .reading"
        ),
        shows(f"{SHEET} [data-card]"),
        CLOSE,
        press("faults/Screen copy"),
        shows(TOASTS, "opied"),
        press("faults/Screen causes", within="#screen"),
        on_screen("causes"),
    ),
    row(
        "faults",
        "faults are erased in two steps",
        press("faults/Screen erase"),
        shows(f"{SHEET} li", "17"),
        Shot("erase"),
        CANCEL,
        CLOSED,
        shows(FAULT),
        press("faults/Screen erase"),
        press("faults/EraseSheet erase_running"),
        CLOSED,
        says("No faults are stored"),
        press("faults/Journal journal"),
        shows("#screen details li", "Faults"),
    ),
)
TESTS = (
    row(
        "tests",
        "a test runs, is judged and repeated",
        press("tests/TestCard start", within=TEST),
        shows(".todo"),
        Shot("running"),
        press("tests/RunView skip"),
        press(
            "tests/Watched {channel ? localized(channel.short) : name}",
            css="#screen .values button",
        ),
        shows(f"{SHEET} [data-card]"),
        CLOSE,
        Repeats("tests/RunView skip", until=VERDICT),
        press("tests/Verdict copy"),
        shows(TOASTS, "opied"),
        press("tests/Screen to_report"),
        press("tests/Screen in_report"),
        press("tests/Verdict back"),
        press("tests/TestCard last", css=f"{TEST} a.last"),
        shows(VERDICT),
        press("tests/Screen repeat"),
        shows(".todo"),
        press("tests/RunView cancel"),
        press("tests/TestCard last", css=f"{TEST} a.last"),
        press("tests/Screen causes", within="#screen"),
        on_screen("causes"),
    ),
    row(
        "tests",
        "a test measures the car while a recording is shown",
        press("tests/TestCard start", within=TEST),
        shows(".todo"),
        go("recordings"),
        press("recordings/RowActions open", within="tbody tr"),
        on_screen("live"),
        go("tests"),
        press("tests/Screen to_live", within="#screen"),
        gone("section[aria-label=Player]"),
        press("tests/RunView cancel"),
        shows(TEST),
    ),
    row(
        "tests",
        "CO is set by a meter, a step is declined, another is written and put back",
        press("tests/Screen open"),
        shows("#screen", "Warm idle"),
        press("writing/Lock unlock"),
        press("writing/Lock unlock_yes"),
        CLOSED,
        fill("Figure to reach", "0.8"),
        Shot("co-begin"),
        press("tests/co/Begin begin"),
        fill("Wait until the meter is steady", "2.0"),
        press("tests/co/Figure next"),
        shows("[data-proposal]"),
        Shot("co"),
        press("tests/co/Screen not_now"),
        fill("Wait until the meter is steady", "2.0"),
        press("tests/co/Figure next"),
        press("tests/co/Screen write"),
        shows("[data-now]", "80"),
        press("tests/co/Screen back_to"),
        shows("[data-now]", "88"),
        press("tests/co/Screen again"),
        press("writing/Lock lock"),
        press("tests/co/Screen back"),
        shows(TEST),
    ),
)


def of_a_recording(tab: Tab) -> None:
    """Choose the newest recording, which is shown as a reader computes it."""
    source = tab.find("#screen select").first
    name = source.locator("option").nth(1).get_attribute("value") or ""
    source.select_option(name)
    expect(tab.find("h1")).to_contain_text("recording")
    expect(tab.find("[data-verdict]")).to_be_visible()


CAUSES = (
    row(
        "causes",
        "the causes of a complaint",
        shows("[data-verdict]"),
        press("causes/Screen {localized(it.text)}", css="#screen [role=group] .complaint"),
        shows("#screen .complaint[aria-pressed=true]"),
        Shot("complained"),
        press("causes/Screen refresh"),
        shows("[data-verdict]"),
        press("causes/Screen {localized(it.text)}", css="#screen [role=group] .complaint"),
    ),
    row(
        "causes",
        "the next measurement is started",
        go("causes/fault.pcapng"),
        shows("[data-verdict]"),
        press("causes/Screen start"),
        on_screen("tests"),
        shows(".todo"),
        press("tests/RunView cancel"),
        go("causes"),
    ),
    row(
        "causes",
        "the causes in a recording",
        of_a_recording,
        Shot("recorded"),
        lambda tab: tab.find("#screen select").first.select_option("live"),
        shows("[data-verdict]"),
    ),
)
PASSPORT = (
    row(
        "passport",
        "the passport is read, copied and saved",
        shows("#screen dl"),
        Shot("shown"),
        press("passport/Screen again"),
        press("passport/Screen copy"),
        shows(TOASTS, "opied"),
        saves("passport/Screen save_text"),
        saves("passport/Screen save_json"),
    ),
    row(
        "passport",
        "whose car",
        press("passport/Screen edit"),
        fill("Number plate", "А123ВС 52"),
        press("car/CarSheet cancel"),
        CLOSED,
        press("passport/Screen edit"),
        fill("Number plate", "А123ВС 52"),
        press("car/CarSheet save"),
        CLOSED,
    ),
    row(
        "passport",
        "commands are tried, methods measured",
        press("passport/Screen probe"),
        shows("#screen .answer.yes"),
        press("passport/Screen probe_again"),
        shows("#screen button:has-text('Try again'):enabled"),
        press("passport/Screen relearn"),
    ),
)
MEMORY = (
    row(
        "memory",
        "bytes are read and copied",
        press("memory/Screen spaces", name="^XRAM$"),
        fill("Address", "8000"),
        press("memory/Screen go"),
        shows("[role=grid] [role=gridcell]"),
        Shot("read"),
        press("memory/Screen forward"),
        shows("[role=grid] [data-at='33024']"),
        press("memory/Screen back"),
        shows("[role=grid] [data-at='32768']"),
        press("memory/Screen copy"),
        shows(TOASTS, "opied"),
    ),
    row(
        "memory",
        "a cell is watched",
        press("memory/cells/WatchList watch_add"),
        press("memory/cells/CellSheet cancel"),
        CLOSED,
        lambda tab: tab.find("[data-at='32768']").click(),
        press("memory/cells/ByteLine watch_this"),
        fill("Name", "first"),
        press("memory/cells/CellSheet watch_save"),
        CLOSED,
        press("memory/cells/WatchList watch_live"),
        shows("#screen td .value", "[0-9]"),
        press("memory/cells/WatchList watch_stop"),
        press("memory/cells/WatchList watch_change", within="#screen tbody .do"),
        press("memory/cells/CellSheet watch_save"),
        press("memory/cells/WatchList watch_remove", within="#screen tbody .do"),
        says("Watch"),
    ),
    row(
        "memory",
        "bytes are written behind the lock",
        press("writing/Lock unlock"),
        CANCEL,
        press("writing/Lock unlock"),
        press("writing/Lock unlock_yes"),
        CLOSED,
        press("band/BandFigures unlocked", within=BAND),
        on_screen("memory"),
        press("memory/Screen spaces", name="^XRAM$"),
        fill("Address", "9000"),
        press("memory/Screen go"),
        shows("[role=grid] [data-at='36864']"),
        press("memory/Screen write_begin"),
        press("memory/cells/WriteSheet cancel"),
        lambda tab: tab.find("[data-at='36865']").click(),
        press("memory/cells/ByteLine edit_this"),
        fill("Bytes, hex", "0D 40"),
        press("memory/cells/WriteSheet write_ask"),
        shows(f"{SHEET} dl", "9001"),
        press("memory/cells/WriteSheet write_no"),
        CLOSED,
        press("memory/Screen write_begin"),
        fill("Bytes, hex", "0D 40"),
        press("memory/cells/WriteSheet write_ask"),
        tick("The car stands still"),
        press("memory/cells/WriteSheet write_yes"),
        shows(TOASTS, "Written and read back"),
        press("writing/Lock lock"),
        shows("#screen", "Unlock writing"),
    ),
    row(
        "memory",
        "what was written is dumped",
        *dumped("9000", "903F"),
        shows(WRITTEN, "complete"),
    ),
    row(
        "memory",
        "a dump is paused, resumed and deleted",
        *dumped("0000", "7FFF"),
        press("memory/dumps/DumpCard pause", within=LONG),
        shows(LONG, "paused"),
        press("memory/dumps/DumpCard resume", within=LONG),
        press("memory/dumps/DumpCard pause", within=LONG),
        press("memory/dumps/DumpCard remove", within=LONG),
        CANCEL,
        press("memory/dumps/DumpCard remove", within=LONG),
        press("dialogs/ConfirmDelete delete"),
        CLOSED,
        gone(LONG),
    ),
    row(
        "memory",
        "a dump is saved and compared",
        *dumped("8100", "813F"),
        shows(DUMP, "complete"),
        saves("memory/dumps/DumpCard download", within=DUMP),
        press("memory/dumps/DumpCard compare_verb", within=DUMP),
        shows(f"{SHEET} [type=file]"),
        press("memory/dumps/CompareSheet close", css="dialog .foot button"),
        CLOSED,
    ),
)
LACKING = (
    row(
        "tests",
        "a result that is kept no more",
        lambda tab: tab.page.evaluate("() => { location.hash = '/tests/idle-1' }"),
        says("no longer kept"),
        press("tests/Screen back"),
        shows(TEST),
    ),
    row(
        "live",
        "what failed is tried again",
        lambda tab: tab.page.route("**/api/passport", lambda route: route.fulfill(status=503)),
        go("passport"),
        press("passport/Screen again"),
        shows("#screen .notice.signal-danger"),
        lambda tab: tab.page.unroute_all(),
        press("notices/ErrorNotice again"),
        gone("#screen .notice.signal-danger"),
        homes=("desktop",),
    ),
)
ANOTHER_CAR = (
    row(
        "memory",
        "the dumps of two cars are compared",
        *dumped("9000", "903F"),
        lambda tab: expect(tab.find(WRITTEN)).to_have_count(2),
        gone(f"{WRITTEN}:not(:has-text('complete'))"),
        press("memory/dumps/DumpCard compare_verb", within=WRITTEN),
        choose_other,
        shows(SHEET, "2 bytes differ"),
        lambda tab: expect(tab.find(DIFFERS)).to_have_count(4),
        says("0D"),
        *refused(b"", "This file is empty"),
        *refused(bytes(0x10001), "larger than a memory space"),
        CLOSE,
        CLOSED,
    ),
)
UNIT = (FAULTS[0], *TESTS, *CAUSES, *PASSPORT, *MEMORY, *WRITING, *FAULTS[1:], *LACKING)
