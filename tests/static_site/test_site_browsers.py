"""What the site says where something is missing; both languages; axe."""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from browser.rig import LAPTOP, SCREENS
from browser.test_browser_screens import AXE, violations

from .computer_rig import PORT
from .site_rig import PORT as PORT_URL
from .site_rig import SiteTab, site_tab

pytestmark = pytest.mark.realtime

WITHOUT = {
    "serial": "delete Navigator.prototype.serial",
    "jspi": "delete WebAssembly.Suspending; delete WebAssembly.promising",
    "wasm": "delete globalThis.WebAssembly",
    "storage": """StorageManager.prototype.getDirectory = () =>
      Promise.reject(new DOMException("no", "SecurityError"))""",
}


ONLINE = "Object.defineProperty(Navigator.prototype, 'onLine', { get: () => true })"
"""The network of the tests leads nowhere else."""


@pytest.fixture
def lacking(chromium, site):
    """Opens the site in a browser that lacks something: `lacking("serial", locale="ru-RU")`."""
    contexts = []

    def visit(what: str, locale: str = "en-GB") -> SiteTab:
        contexts.append(chromium.new_context(locale=locale))
        contexts[-1].add_init_script(WITHOUT[what])
        tab = SiteTab(contexts[-1].new_page(), site.url)
        tab.page.goto(f"{site.url}/#/connection")
        return tab

    yield visit
    for each in contexts:
        each.close()


def has_no_violations(tab, name):
    tab.page.evaluate(AXE.read_text("utf-8"))
    assert violations(tab, name) == {}


def test_without_jspi_the_page_says_which_browsers_have_it(lacking):
    tab = lacking("jspi")
    tab.says("Chrome or Edge 137 or newer")
    tab.press("Русский")
    tab.says("Chrome или Edge 137 или новее")
    has_no_violations(tab, "jspi")


def test_without_webassembly_the_page_says_so(lacking):
    tab = lacking("wasm", "ru-RU")
    tab.says("В этом браузере mikas не работает")
    tab.says("нет WebAssembly")
    has_no_violations(tab, "wasm")


@pytest.mark.parametrize("answer", [{"status": 404}, {"status": 200, "body": "damaged"}])
def test_a_broken_load_says_what_to_do_and_can_be_repeated(chromium, site, answer):
    with chromium.new_context(locale="en-GB") as context:
        context.add_init_script(ONLINE)
        tab = SiteTab(context.new_page(), site.url)
        context.route("**/program.pack", lambda route: route.fulfill(**answer))
        tab.page.goto(tab.url)
        tab.says("mikas could not start")
        tab.says("load the page anew")
        expect(tab.page.locator("details p")).to_be_hidden()
        has_no_violations(tab, "broken")
        context.unroute_all()
        tab.press("Load the page anew")
        tab.runs()


def test_without_web_serial_the_virtual_car_works(lacking):
    tab = lacking("serial")
    tab.runs()
    tab.says("This browser can't use the cable")
    expect(tab.button("Choose the cable…")).to_have_count(0)
    has_no_violations(tab, "serial")
    tab.press("Start the virtual car")
    tab.is_line("sampling")
    expect(tab.value("FREQ")).to_be_visible()  # it leads to the gauges
    tab.show("connection").press("Русский")
    tab.says("Этот браузер не умеет работать с кабелем")


def test_where_nothing_can_be_kept_the_page_says_so(lacking):
    tab = lacking("storage")
    tab.runs()
    tab.says("This browser keeps no recordings")
    tab.press("Start the virtual car")
    tab.is_line("sampling")


def test_over_plain_http_from_another_computer_the_virtual_car_works(chromium, site):
    context = chromium.new_context(locale="ru-RU")
    tab = SiteTab(context.new_page(), f"http://{LAPTOP}:{PORT}")
    tab.page.goto(f"{tab.url}/#/connection")
    tab.says("Страница открыта по http с другого компьютера")
    has_no_violations(tab, "http")
    tab.press("Запустить виртуальный автомобиль")
    tab.is_line("sampling")
    context.close()


def test_axe_has_nothing_against_the_sites_own(visit, car, site, profile):
    visit.show("connection")
    visit.page.evaluate(AXE.read_text("utf-8"))
    findings = violations(visit, "connection")
    with site_tab(profile, site.url) as second:
        second.page.goto(second.url)
        second.says("mikas is open in another tab")
        second.page.evaluate(AXE.read_text("utf-8"))
        findings |= violations(second, "another tab")
    assert findings == {}


def test_every_screen_is_there_in_russian(chromium, site, car):
    with chromium.new_context(locale="ru-RU") as context, site_tab(context, site.url) as tab:
        tab.page.goto(f"{tab.url}/#/connection")
        tab.says("mikas в этом браузере")
        tab.says("Ничего не уходит с этого компьютера")
        tab.press(f"Подключить {PORT_URL}")
        tab.is_line("sampling")
        for screen in SCREENS:
            tab.show(screen)
            tab.until("() => document.querySelector('#screen h1, #screen h2, #screen [role=tab]')")
