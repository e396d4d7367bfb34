"""What a person does with recordings: in their list, the player, a comparison, a report."""

from __future__ import annotations

from dataclasses import dataclass

from playwright.sync_api import expect

from browser.rig import Tab

from .on_live import BAND, CLOSE
from .steps import (
    CLOSED,
    ESCAPE,
    SHEET,
    Press,
    Shot,
    choose,
    fill,
    go,
    gone,
    key,
    laptop,
    on_screen,
    phone,
    press,
    row,
    saves,
    says,
    shows,
)  # fmt: skip

FIRST = "tbody tr"
PLAYER = "section[aria-label=Player]"
BAR = "[role=group][aria-label=Comparison]"
OPEN = press("recordings/RowActions open", within=FIRST)
SHUT = press("recordings/player/PlayerBar close_player", within=PLAYER)
VIRTUAL = "^Virtual car 7.1: warm idle"
LOOP = "recordings/player/PlayerBar loopWord"


@dataclass(frozen=True)
class Opens(Press):
    """Press it, and a tab opens that shows something."""

    def __call__(self, tab: Tab) -> None:
        with tab.page.expect_popup() as popup:
            super().__call__(tab)
        expect(popup.value.locator("h1")).to_be_visible()
        popup.value.close()


@dataclass(frozen=True)
class AddsAgain(Press):
    """Save the recording whose export is shown, add the file; the list has one more."""

    def __call__(self, tab: Tab) -> None:
        before = tab.find(FIRST).count()
        with tab.page.expect_download() as saved:
            tab.page.get_by_role("link", name=".pcapng", exact=True).click()
        file = saved.value.path()
        tab.page.keyboard.press("Escape")
        with tab.page.expect_file_chooser() as chooser:
            super().__call__(tab)
        data = {"name": "again.pcapng", "mimeType": "application/octet-stream"}
        chooser.value.set_files([{**data, "buffer": file.read_bytes()}])
        expect(tab.find(FIRST)).to_have_count(before + 1)


FOREIGN = "t;AFR;gear\n0;14,7;R\n500;13,9;1\n1000;14,1;1\n"


@dataclass(frozen=True)
class OpensLog(Press):
    """Press it, and choose a log of another program."""

    def __call__(self, tab: Tab) -> None:
        with tab.page.expect_file_chooser() as chooser:
            super().__call__(tab)
        data = {"name": "wideband.csv", "mimeType": "text/csv", "buffer": FOREIGN.encode("cp1251")}
        chooser.value.set_files([data])


def shares(tab: Tab) -> None:
    """Let the browser share files, as on a phone; Chromium on Linux can't."""
    tab.page.evaluate(
        """() => {
          const share = async ({ files }) => { navigator.shared = files[0].name }
          const more = { canShare: () => true, share, userActivation: { isActive: true } }
          for (const [name, value] of Object.entries(more)) {
            Object.defineProperty(navigator, name, { value, configurable: true })
          }
        }"""
    )


def is_late(tab: Tab) -> None:
    tab.page.evaluate("() => { navigator.userActivation.isActive = false }")


def is_in_time(tab: Tab) -> None:
    tab.page.evaluate("() => { navigator.userActivation.isActive = true }")


def shares_no_more(tab: Tab) -> None:
    tab.page.evaluate(
        "() => ['canShare', 'share', 'userActivation'].forEach(it => delete navigator[it])"
    )


@dataclass(frozen=True)
class Shares(Press):
    """Press it, and a file whose name ends so is shared."""

    end: str = ""

    def __call__(self, tab: Tab) -> None:
        super().__call__(tab)
        tab.until("end => navigator.shared?.endsWith(end)", self.end)


SHARE = "share/ShareButton share"
LIST = (
    row(
        "recordings",
        "the list, a note, the car, a reference",
        press("recordings/Screen refresh"),
        press("recordings/EditText {label}: {text || none}", name="^Note of "),
        lambda tab: tab.find(f"{FIRST} form input").fill("uphill"),
        press("recordings/Note note_save"),
        shows(FIRST, "uphill"),
        press("recordings/EditText {label}: {text || none}", name="^Car details of"),
        Shot("car"),
        ESCAPE,
        press("recordings/RowActions mark"),
        press("recordings/RowActions unmark"),
        shows(f"{FIRST} [aria-label^=Make]"),
        press("recordings/Screen causes_of", within=FIRST),
        on_screen("causes"),
        go("recordings"),
        press("recordings/Screen trip_of", within=FIRST),
        shows("[data-sum=litres]"),
        Shot("trip"),
        fill("Mass with driver", "1600"),
        fill("Speed at 1000 rpm", "23"),
        press("recordings/trip/Power compute"),
        says("There is no pull in this recording"),
        press("recordings/trip/Screen back"),
        shows(FIRST),
    ),
    row(
        "recordings",
        "the trip of the connected car, from a mark on",
        press("recordings/Screen live_trip"),
        shows("[data-sum=ran]"),
        press("recordings/trip/Screen reset"),
        shows("#screen .options", "mark trip"),
        press("recordings/trip/Screen refresh"),
        shows("[data-sum=ran]"),
    ),
    row(
        "recordings",
        "an export in every form",
        press("recordings/RowActions export_of"),
        Shot("export"),
        press("recordings/ExportSheet export_some"),
        *(
            saves("recordings/ExportSheet .{format}", name=form)
            for form in (r"^\.csv$", r"^\.csv \(Excel\)$", r"^\.msl$", r"^\.mlg$")
        ),
        saves("recordings/ExportSheet .pcapng", name=r"^\.pcapng$"),
        press("recordings/ExportSheet close", css="dialog .foot button"),
        CLOSED,
    ),
    row(
        "recordings",
        "a recording is shared, and its table",
        shares,
        press("recordings/RowActions export_of"),
        Shares(SHARE, name=r"^Share .*\.pcapng$", end=".pcapng.txt"),
        is_late,
        press(SHARE, name=r"^Share .*\.csv$"),
        shows("dialog [aria-label^='Share now']"),
        is_in_time,
        Shares("share/ShareButton share_now", end=".csv"),
        Shot("share"),
        ESCAPE,
        CLOSED,
        shares_no_more,
    ),
    row(
        "recordings",
        "a recording is deleted once that was confirmed, and added again",
        press("recordings/RowActions export_of"),
        AddsAgain("recordings/AddButton add"),
        press("recordings/RowActions delete_of"),
        Shot("delete"),
        press("dialogs/Confirm cancel"),
        CLOSED,
        press("recordings/RowActions delete_of"),
        press("dialogs/ConfirmDelete delete"),
        CLOSED,
    ),
)
PLAYED = (
    row(
        "recordings",
        "a recording is played",
        OPEN,
        shows(PLAYER),
        Shot("played"),
        press("recordings/player/PlayerBar step", within=PLAYER),
        press("recordings/player/PlayerBar step_back", within=PLAYER),
        press(LOOP, css=f"{PLAYER} button[aria-pressed]"),
        key("."),
        press(LOOP, css=f"{PLAYER} button[aria-pressed]"),
        # In the loop it plays until it is paused; the recording would end after two seconds.
        press("recordings/player/PlayerBar play", within=PLAYER),
        press("recordings/player/PlayerBar pause", within=PLAYER),
        press(LOOP, css=f"{PLAYER} button[aria-pressed]"),
        press("recordings/player/PlayerBar mark", within=PLAYER),
        fill("Its name", "afterwards"),
        press("frame/MarkerName save"),
        SHUT,
        gone(PLAYER),
    ),
    row(
        "recordings",
        "what a recording says of faults, and its report",
        OPEN,
        shows(PLAYER),
        go("faults"),
        press("faults/RecordedFaults causes", within="#screen"),
        on_screen("causes"),
        go("faults"),
        press("faults/RecordedFaults recorded_report"),
        on_screen("report"),
        go("faults"),
        press("faults/RecordedFaults recorded_live", within="#screen"),
        gone(PLAYER),
    ),
    row(
        "recordings",
        "the moment of a fault in a recording",
        press("recordings/RowActions open", within="tbody tr:has-text('fault')"),
        shows(PLAYER),
        go("faults"),
        press("faults/FreezeFrame frame"),
        shows("#screen details svg path"),
        press("faults/FreezeFrame {text(value.name)}", css="#screen details th button"),
        shows(f"{SHEET} [data-card]"),
        CLOSE,
        press("faults/FreezeFrame frame_all"),
        press("faults/FreezeFrame frame_fewer"),
        press("faults/FreezeFrame frame_chart"),
        on_screen("chart"),
        shows("#screen .moments", "Fault 13"),
        press("chart/time/moments/MomentsBar clear"),
        SHUT,
    ),
    row(
        "recordings",
        "a test over a recording",
        OPEN,
        shows(PLAYER),
        go("tests"),
        press("tests/TestCard test_recording", within="[data-test=idle]"),
        press("tests/RecordedView back"),
        press("tests/Screen close", within="#screen"),
        gone(PLAYER),
    ),
    row(
        "recordings",
        "two recordings are compared",
        press("recordings/RowActions compare_of"),
        Shot("compare"),
        press("recordings/compare/CompareSheet {localized(titleOf(it))}", name=VIRTUAL),
        shows(BAR, "Virtual car 7.1: warm idle"),
        Shot("compared"),
        press("recordings/compare/CompareBar later"),
        press("recordings/compare/CompareBar earlier"),
        press("recordings/compare/CompareBar later"),
        press("recordings/compare/CompareBar zero", css=f"{BAR} button.offset"),
        press("recordings/compare/CompareBar align"),
        press("recordings/compare/CompareBar align_stop"),
        go("live"),
        press("recordings/compare/CompareBar in_chart"),
        on_screen("chart"),
        press("recordings/compare/CompareBar end"),
        gone(BAR),
        press("recordings/player/PlayerBar compare", within=PLAYER),
        press(
            'recordings/compare/CompareSheet {it.reference ? "★ " : ""}',
            css="dialog li button:enabled",
        ),
        shows(BAR),
        press("recordings/compare/CompareBar moved", css=f"{BAR} button.offset"),
        press("recordings/compare/CompareBar end"),
        go("recordings"),
        press("recordings/RowActions compare_to"),
        shows(BAR),
        press("band/StateBand toLive", within=BAND),
        gone(BAR),
        go("recordings"),
        press("recordings/RowActions report_of", name="^Report"),
        on_screen("report"),
    ),
)
LOGS = (
    row(
        "recordings",
        "another program's log is compared with",
        press("recordings/RowActions compare_of"),
        OpensLog("recordings/compare/CompareSheet open"),
        shows("dialog .samples", "0 · 500"),
        Shot("columns"),
        press("recordings/compare/ForeignSheet cancel"),
        OpensLog("recordings/compare/CompareSheet open"),
        choose("Which column is the time", "t: 0"),
        choose("What it counts", "milliseconds"),
        press("recordings/compare/ForeignSheet all"),
        press("recordings/compare/ForeignSheet none"),
        press("recordings/compare/ForeignSheet all"),
        press("recordings/compare/ForeignSheet compare"),
        shows(BAR, "wideband.csv"),
        shows('[data-second="log:AFR"]', "14.7"),
        Shot("log"),
        press("recordings/compare/CompareBar remarks", within=BAR),
        shows(f"{BAR} details p", "gear: cells that are no number"),
        press("recordings/compare/CompareBar end"),
        gone(BAR),
        gone('[data-second="log:AFR"]'),
        SHUT,
    ),
)
REPORT = (
    row(
        "report",
        "the report is made, saved and opened",
        shows("iframe"),
        Shot("read"),
        press("report/Screen refresh"),
        shows("iframe"),
        saves("report/Screen save"),
        shares,
        press("report/Screen refresh"),
        Shares(SHARE, end=".html"),
        shares_no_more,
        press("report/Screen edit"),
        press("car/CarSheet cancel"),
        press("report/Screen print"),
        press("report/Screen causes", within="#screen"),
        on_screen("causes"),
    ),
    row("report", "it opens in a new tab", Opens("report/Screen open"), homes=("desktop",)),
)
PHONE = (
    row(
        "recordings",
        "on a phone",
        phone,
        press("recordings/RowActions trip_of", name="^Trip", within="#screen article"),
        shows("[data-sum=litres]"),
        Shot("trip-phone"),
        go("recordings"),
        press("recordings/RowActions causes_of", name="^Causes", within="#screen article"),
        on_screen("causes"),
        go("recordings"),
        press("recordings/RowActions open", within="#screen article"),
        shows(PLAYER),
        press("recordings/player/PlayerBar player_more"),
        shows(f"{PLAYER} .speed"),
        SHUT,
        laptop,
    ),
)
RECORDINGS = (*PLAYED, *LOGS, *REPORT, *LIST, *PHONE)
