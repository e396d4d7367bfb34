"""Take the pictures of what goes on beside the unit's values, in both languages.

A λ meter and a GPS receiver on Connection, Live and Chart, on a phone too; actions on conditions; a
parameter written by buttons, before and after; the trip in the report. A virtual car drives in town
with both instruments. It takes six minutes. Run from the repository's root:
python docs/pictures/beside_screens.py [NAME …]
"""

from __future__ import annotations

import json
import sys
import time

import served_car
from served_car import DESKTOP, GPS, METER, PHONE, Tab, ask

SECONDS = 240  # of the drive that is recorded: a trip of more than a kilometre
SETTLED = 25  # s at warm idle: the small lines on the gauges have a course
PRESET = {
    "id": "own-lambda",
    "name": {"en": "λ and GPS", "ru": "λ и GPS"},
    "tiles": [
        {"kind": "gauge", "names": ["LAMBDA"], "span": 2},
        {"kind": "gauge", "names": ["FREQ"]},
        {"kind": "number", "names": ["VALF"]},
        {"kind": "number", "names": ["AFR"]},
        {"kind": "number", "names": ["GPS_SPEED"]},
        {"kind": "strip", "names": ["LAMBDA", "FREQ"], "span": 3},
    ],
}
PANES = (("LAMBDA", "VALF"), ("FREQ", "THR"), ("GPS_SPEED",))
ACTIONS = {
    "rules": [
        {
            "name": "hot", "when": "TWAT > 105", "hold": 3, "until": "TWAT < 100", "again": 60,
            "sound": True,
            "mark": {"en": "hot: {TWAT}", "ru": "перегрев: {TWAT}"},
            "speak": {"en": "Coolant {TWAT}", "ru": "Температура {TWAT}"},
        },
        {
            "name": "lean", "when": "LAMBDA > 1.15 and THR > 20", "hold": 1, "sound": True,
            "mark": {"en": "lean: {LAMBDA}", "ru": "бедно: {LAMBDA}"},
        },
        {"name": "start", "when": "FREQ > 600", "hold": 2, "once": True, "record": "start"},
    ]
}  # fmt: skip


def prepare(tab: Tab) -> None:
    """Let the tab show the instruments' channels on Live and Chart."""
    colours = iter(range(1, 9))
    panes = [
        {
            "id": at,
            "traces": [{"name": it, "colour": next(colours), "hidden": False} for it in names],
        }
        for at, names in enumerate(PANES)
    ]
    tab.page.evaluate("it => localStorage.setItem('mikas.chart', it)", json.dumps(panes))
    tab.page.evaluate("it => localStorage.setItem('mikas.preset', it)", PRESET["id"])
    tab.page.reload()
    tab.page.locator("#screen .columns").wait_for()


def card(tab: Tab) -> None:
    """Take the instruments' card on Connection."""
    tab.show("connection")
    shown = tab.page.locator("[data-instruments]")
    for name in ("aem", "nmea"):
        shown.locator(f"[data-instrument={name}][data-state=values]").wait_for()
    tab.take("instruments-card", shown)


def instruments(tab: Tab) -> None:
    """Take Live and the chart with the instruments' values."""
    tab.show("live")
    tab.page.locator('#screen [data-value="LAMBDA"]').first.wait_for()
    tab.take("instruments-live")
    tab.show("chart")
    tab.page.locator(".panes canvas").first.wait_for()
    tab.take("instruments-chart")


def on_a_phone(tab: Tab) -> None:
    """Take Live on a phone."""
    tab.show("live")
    tab.page.locator('#screen [data-value="LAMBDA"]').first.wait_for()
    tab.take("phone-instruments")


def actions(tab: Tab) -> None:
    """Take the list of actions, and the form of one."""
    tab.show("live")
    tab.press("Actions on conditions", "Действия по условиям")
    tab.page.locator("[data-action=hot]").wait_for()
    tab.take("actions")
    tab.page.keyboard.press("Escape")


def writing(tab: Tab) -> None:
    """Take the proposal of a write, before and after, and the way back."""
    ask("/control/take", {"force": True})  # from the tab before
    ask("/control/release")
    tab.show("live")
    tab.page.locator('[data-opens="RCOD"]').first.click()
    tab.press("Write to the unit…", "Записать в блок…")
    tab.page.locator("[data-now] b").wait_for()
    tab.press("Unlock writing for 5 minutes…", "Разрешить запись на 5 минут…")
    tab.press("Unlock", "Разрешить")
    tab.press("0.0391 more", "больше на 0,0391")
    tab.press("Write…", "Записать…")
    tab.page.locator("[data-after]").wait_for()
    tab.take("write-before")
    tab.press("Write −0.4297", "Записать −0,4297")
    tab.page.get_by_role("button", name=tab.say("Back to", "Вернуть")).wait_for()
    tab.take("write-after")
    tab.press("Back to −0.4688", "Вернуть −0,4688")
    tab.page.get_by_role("button", name=tab.say("Back to", "Вернуть")).wait_for(state="detached")
    tab.press("Lock now", "Запретить сейчас")
    for _ in range(2):
        tab.page.keyboard.press("Escape")


def setting_co(tab: Tab) -> None:
    """Take the first step of CO by the meter, before it is written."""
    ask("/control/take", {"force": True})
    ask("/control/release")
    tab.show("tests/co")
    screen = tab.page.locator("#screen")
    screen.locator(".text-ok").wait_for()
    screen.locator(".lock button").click()
    tab.press("Unlock", "Разрешить")
    for figure in ("0.8", "2.0"):  # the target, and what the meter shows
        screen.locator("form input").first.fill(figure)
        screen.locator("form [type=submit]").click()
    screen.locator("[data-proposal]").wait_for()
    tab.take("co")


def trip(tab: Tab) -> None:
    """Take the trip of the recording, on its own screen and in the report."""
    recording = ask("/recordings", method="GET")["recordings"][0]["id"]
    tab.show(f"recordings/trip/{recording}")
    way = tab.page.locator("[data-way] path").first
    way.wait_for()
    tab.page.set_viewport_size({"width": 1280, "height": 1000})
    tab.take("trip")
    tab.page.set_viewport_size(DESKTOP)
    tab.show("recordings")
    tab.page.locator('#screen tbody a[href*="report"]').first.click()
    page = tab.page.frame_locator("iframe")
    heading = page.get_by_role("heading", name=tab.say("Trip", "Поездка"))
    heading.wait_for(timeout=60_000)
    tab.take("report-trip", page.locator("section", has=heading).last)


def add(meter: str, gps: str) -> None:
    """Add the instruments at these ports."""
    ask("/control/take", {"force": True})
    for definition, port in (("aem", meter), ("nmea", gps)):
        ask("/instruments", {"definition": definition, "port": port})
    ask("/control/release")


def main(wanted: list[str]) -> None:
    """Take all pictures, or those that are named."""
    with served_car.program_at_ports("city"):
        add(METER, GPS)
        with served_car.tabs(wanted) as tabs:
            for tab in tabs:
                card(tab)
    with served_car.program("city"):
        add("sim:", "sim:")
        ask("/control/take", {"force": True})
        ask("/presets", {"presets": [PRESET]}, "PUT")
        ask("/actions", ACTIONS, "PUT")
        ask("/recording/start")
        ask("/control/release")
        time.sleep(SECONDS)  # the real program drives in real time: charts are to be full
        for size, shown in ((DESKTOP, (instruments, actions)), (PHONE, (on_a_phone,))):
            with served_car.tabs(wanted, size) as tabs:
                for tab in tabs:
                    prepare(tab)
                    for each in shown:
                        each(tab)
        ask("/control/take", {"force": True})
        ask("/recording/stop")
        ask("/control/release")
        with served_car.tabs(wanted) as tabs:
            for tab in tabs:
                trip(tab)
    with served_car.program("warm-idle"):
        time.sleep(SETTLED)  # real time, too
        with served_car.tabs(wanted) as tabs:
            for tab in tabs:
                writing(tab)
                setting_co(tab)


if __name__ == "__main__":
    main(sys.argv[1:])
