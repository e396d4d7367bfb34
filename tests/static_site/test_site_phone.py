"""The site on an Android phone: touch only, upright and on its side, the cable by WebUSB.

Chromium's own WebUSB opens a model of a chip; the person's part, its list, is played.
"""

from __future__ import annotations

import json

import pytest
from playwright.sync_api import expect

from browser.test_browser_screens import AXE, violations

from .site_rig import SiteTab
from .usb_sockets_rig import usb_cable

pytestmark = pytest.mark.realtime

UPRIGHT, LYING = {"width": 390, "height": 844}, {"width": 844, "height": 390}
NOTCH = {"upright": {"top": 40, "bottom": 24}, "lying": {"left": 40, "right": 24, "bottom": 20}}
ANDROID = "Mozilla/5.0 (Linux; Android 10; K) AppleWebKit/537.36 Chrome/148.0.0.0 Mobile"
LIST_OF_DEVICES = """
navigator.usb.requestDevice = async () => {
  if (window.declines) throw new DOMException("No device selected.", "NotFoundError")
  await plugIn()
  for (;;) {
    const [device] = await navigator.usb.getDevices()
    if (device) return device
    await new Promise(again => setTimeout(again, 20))
  }
}
"""
"""The person plugs the cable in, and touches it in the browser's list."""
PHONE = """
window.buzzes = []
navigator.vibrate = pattern => window.buzzes.push(pattern)
window.battery = Object.assign(new EventTarget(), { level: 0.64, charging: false })
navigator.getBattery = async () => window.battery
window.away = false
Object.defineProperty(document, "hidden", { get: () => window.away })
"""
BATTERY = "level => { battery.level = level; battery.dispatchEvent(new Event('levelchange')) }"
AWAY = "is => { window.away = is; document.dispatchEvent(new Event('visibilitychange')) }"
SMALL = """() => [...document.querySelectorAll(
  "button, a[href], select, summary, input:not([type=checkbox], [type=radio]), label:has(input)")]
  .filter(it => it.checkVisibility({ visibilityProperty: true }))
  .filter(it => !it.closest("p, td, [data-opens]"))
  .map(it => [it.getBoundingClientRect(), it.outerHTML.slice(0, 120)])
  .filter(([box]) => box.width > 1 && Math.min(box.width, box.height) < 43.5)
  .map(([box, html]) => `${Math.round(box.width)} x ${Math.round(box.height)}: ${html}`)"""
"""What a finger is to hit and may miss. Links within a text are as high as its lines; the name of a
value stands for its whole tile.
"""
HIDDEN = """([left, top, right, bottom]) => [...document.querySelectorAll(
  "header[data-line] *, nav *, #screen [data-tile], #screen button, #screen select")]
  .filter(it => it.checkVisibility() && it.getBoundingClientRect().width > 1)
  .filter(it => {
    const box = it.getBoundingClientRect()
    const below = it.closest("nav, header") && box.bottom > innerHeight - bottom + 0.5
    return box.left < left - 0.5 || box.right > innerWidth - right + 0.5 || box.top < top - 0.5
      || below
  })
  .map(it => it.outerHTML.slice(0, 120))"""


@pytest.fixture(scope="module")
def cable(usb_sockets, tmp_path_factory):
    """A CH340 on the virtual unit, lying beside the phone."""
    with usb_cable(usb_sockets, tmp_path_factory.mktemp("phone"), "CH340") as made:
        made.pull()
        yield made


@pytest.fixture(scope="module")
def phone(chromium, site, cable):
    """The site on a phone, just opened, which the tests of this module share."""
    context = chromium.new_context(
        viewport=UPRIGHT, has_touch=True, is_mobile=True, user_agent=ANDROID, locale="en-GB"
    )
    context.add_init_script(LIST_OF_DEVICES + PHONE)
    context.expose_function("plugIn", cable.put_back)
    tab = SiteTab(context.new_page(), site.url)
    tab.page.goto(site.url)
    tab.runs()
    yield tab
    context.close()
    assert not tab.complaints, tab.complaints


@pytest.fixture
def driven(phone, cable):
    """That tab, upright, on Live, with the values of the car."""
    phone.page.set_viewport_size(UPRIGHT)
    if phone.state()["line"] == "off":
        phone.show("connection").press("Choose the cable…")
    phone.show("live")
    phone.is_line("sampling")
    expect(phone.value("TWAT")).to_have_text("87")
    return phone


def inset(tab: SiteTab, **sides: int) -> list[int]:
    """Give the screen what a notch and a bar of gestures cover; return it as the test looks."""
    session = tab.page.context.new_cdp_session(tab.page)
    session.send("Emulation.setSafeAreaInsetsOverride", {"insets": sides})
    return [sides.get(side, 0) for side in ("left", "top", "right", "bottom")]


def test_a_list_without_the_cable_leads_from_live_to_the_advice(phone):
    phone.show("live").page.evaluate("() => { window.declines = true }")
    phone.button("Choose the cable…").tap()
    expect(phone.find("h1")).to_have_text("Connection")
    phone.says("The cable was not in the list?")
    phone.show("live").find("#screen").get_by_role("link", name="Connection").tap()
    expect(phone.find("h1")).to_have_text("Connection")
    phone.page.evaluate("() => { window.declines = false }")


def test_two_touches_lead_from_the_cable_to_its_gauges(phone):
    phone.show("connection")
    phone.button("Choose the cable…").first.tap()  # the second touch is in the browser's list
    expect(phone.value("TWAT")).to_have_text("87")
    assert phone.page.url.endswith("#/live")
    assert phone.state()["port"] == "webusb:1a86:7523"


def test_a_cable_that_the_browser_remembers_needs_no_touch(driven):
    asked = []
    driven.page.once("dialog", lambda dialog: (asked.append(dialog.type), dialog.accept()))
    driven.page.reload()
    expect(driven.value("TWAT")).to_have_text("87")
    assert asked == ["beforeunload"]  # the phone had the cable


def test_on_its_side_big_numbers_are_shown_and_another_choice_is_kept(driven):
    driven.page.set_viewport_size(LYING)
    expect(driven.find("#screen [data-tile]")).to_have_count(4)
    sizes = driven.find("#screen [data-value]").evaluate_all(
        "them => them.map(it => parseFloat(getComputedStyle(it).fontSize))"
    )
    assert min(sizes) >= 44
    driven.button("All tiles").tap()
    expect(driven.find("#screen [data-gauge]").first).to_be_visible()
    driven.page.set_viewport_size(UPRIGHT)
    driven.page.set_viewport_size(LYING)
    expect(driven.find("#screen [data-gauge]").first).to_be_visible()
    driven.button("Big numbers").tap()
    expect(driven.find("#screen [data-gauge]")).to_have_count(0)


def test_everything_is_a_fingers_size_and_nothing_lies_behind_the_camera(driven):
    driven.page.evaluate(f"() => {{ if (!window.axe) {{ {AXE.read_text('utf-8')} }} }}")
    found = {}
    for held, size in (("upright", UPRIGHT), ("lying", LYING)):
        driven.page.set_viewport_size(size)
        covered = inset(driven, **NOTCH[held])
        for screen in ("live", "connection", "faults", "recordings", "chart"):
            driven.show(screen)
            expect(driven.find("#screen [aria-busy=true]")).to_have_count(0)
            found[f"{held} {screen}: small"] = driven.page.evaluate(SMALL)
            found[f"{held} {screen}: covered"] = driven.page.evaluate(HIDDEN, covered)
            if screen in ("live", "connection"):
                found |= violations(driven, f"{held} {screen}")
    inset(driven)
    assert {what: them for what, them in found.items() if them} == {}


def test_back_closes_a_dialog_before_it_leaves_the_screen(driven):
    driven.show("faults").show("live")
    driven.find('#screen [data-opens="TWAT"]').first.tap()
    card = driven.page.get_by_role("dialog")
    expect(card).to_be_visible()
    driven.page.evaluate("() => history.back()")
    expect(card).to_have_count(0)
    assert driven.page.url.endswith("#/live")
    driven.page.evaluate("() => history.back()")
    expect(driven.find("h1")).to_have_text("Faults")


def test_an_alarm_is_felt_once_when_it_begins(driven, cable):
    driven.page.evaluate("() => { buzzes.length = 0 }")
    cable.set("UACC", "5E")
    expect(driven.find('[data-tile="UACC"]')).to_contain_class("warning")
    driven.until("() => buzzes.length")
    cable.set("UACC", "5D")
    expect(driven.value("UACC")).to_have_text("9.3")
    cable.set("UACC", "8A")
    expect(driven.value("UACC")).to_have_text("13.8")
    assert json.loads(driven.page.evaluate("() => JSON.stringify(buzzes)")) == [[250]]


def test_values_that_were_lost_in_the_background_are_said_on_return(driven, cable):
    driven.page.evaluate(AWAY, True)
    cable.pull()
    driven.page.wait_for_timeout(2500)  # the call
    cable.put_back()
    driven.until("async () => (await (await fetch('api/state')).json()).line === 'sampling'")
    driven.page.evaluate(AWAY, False)
    driven.says("While the page was in the background no values came for")
    driven.find(".toast", has_text="background").get_by_role("button", name="Close").tap()


def test_a_recording_survives_a_page_that_the_browser_freezes(driven):
    driven.record()
    before = driven.recorded(1)
    session = driven.page.context.new_cdp_session(driven.page)
    session.send("Page.setWebLifecycleState", {"state": "frozen"})
    driven.page.wait_for_timeout(2500)
    session.send("Page.setWebLifecycleState", {"state": "active"})
    driven.is_line("recording")
    assert driven.recorded(before + 3) > before
    driven.stop_recording()
    latest = driven.recordings()[0]
    assert (latest["open"], latest["problem"]) == (False, None)


def test_a_nearly_empty_battery_closes_the_recording_in_time(driven):
    driven.says("battery 64 %")
    driven.record()
    driven.recorded(1)
    driven.page.evaluate(BATTERY, 0.2)
    driven.says("Battery at 20 %. The phone does not charge while the cable is in it")
    driven.page.evaluate(BATTERY, 0.1)
    driven.says("was closed in time and is kept")
    driven.is_line("sampling")
    latest = driven.recordings()[0]
    assert (latest["open"], latest["problem"]) == (False, None)
