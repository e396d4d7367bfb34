"""The page over the network: the link with its token, who only watches, who may control, who comes
and goes. What is refused is said in words.
"""

from __future__ import annotations

from contextlib import ExitStack, contextmanager

import pytest
from playwright.sync_api import expect

from browser.rig import LAPTOP, SCREENS, dashboard


@pytest.fixture(scope="module")
def lan(chromium, tmp_path_factory):
    with dashboard(tmp_path_factory.mktemp("lan"), lan=True) as dash:
        yield dash.samples()


@pytest.fixture(scope="module")
def shared_control(chromium, tmp_path_factory):
    with dashboard(tmp_path_factory.mktemp("control"), lan=True, lan_control=True) as dash:
        yield dash.samples()


def by_the_link(dash, visitor, **wishes):
    """A tab that was opened by the link with the token in it."""
    tab = visitor(f"https://{LAPTOP}:{dash.port}", **wishes)
    tab.page.goto(dash.access.lan_url)
    return tab


@contextmanager
def no_wish_sent(tab):
    """Nothing that would change anything is even asked for."""
    sent = []

    def note(request):
        if request.method != "GET":
            sent.append(f"{request.method} {request.url}")

    tab.page.on("request", note)
    yield
    tab.page.remove_listener("request", note)
    assert sent == []


def test_by_the_link_one_sees_live_values(lan, visitor):
    tab = by_the_link(lan, visitor)
    tab.is_line("sampling")
    assert "token" not in tab.page.url  # it is a cookie now
    assert tab.page.evaluate("() => isSecureContext") is True
    tab.show("live")
    lan.garage.set("TWAT", "7F")
    expect(tab.value("TWAT")).to_have_text("87")
    lan.garage.set("TWAT", "80")
    expect(tab.value("TWAT")).to_have_text("88")
    expect(tab.find("header[data-line]")).to_contain_text("view only")
    lan.garage.set("TWAT", "7F")
    tab.page.reload()
    expect(tab.value("TWAT")).to_have_text("87")


def test_a_switch_that_is_refused_is_not_shown_as_on(own, visitor):
    tab = visitor(own.url).show("connection")
    switch = tab.page.get_by_role("switch")
    expect(switch).not_to_be_checked()
    tab.refused = True
    refusal = {"error": {"code": "Busy", "en": "No port is free.", "ru": "Нет свободного порта."}}
    tab.page.route("**/api/network", lambda route: route.fulfill(status=503, json=refusal))
    switch.click()
    tab.says("No port is free.")
    expect(switch).not_to_be_checked()


def test_one_switch_lets_a_phone_in_and_shuts_it_out(own, visitor):
    tab = visitor(own.url).show("connection")
    switch = tab.page.get_by_role("switch")
    expect(switch).not_to_be_checked()
    place = switch.bounding_box()
    switch.check()
    expect(switch).to_be_focused()
    square = tab.page.get_by_role("img", name="QR code of the address")
    expect(square).to_be_visible()
    assert tab.until("() => document.querySelector('img[alt^=QR]').naturalWidth > 0")
    link = own.access.lan_url
    assert switch.bounding_box() == place
    tab.says(link)
    tab.says(own.access.fingerprint)
    tab.press("Copy the link")
    expect(tab.find(".toast")).to_be_visible()
    phone = visitor(f"https://127.0.0.2:{own.port}", viewport={"width": 390, "height": 844})
    phone.refused = True
    phone.page.goto(link)
    phone.is_line("sampling")
    expect(phone.find("header[data-line]")).to_contain_text("view only")
    phone.show("connection")
    expect(phone.page.get_by_role("switch")).to_have_count(0)
    switch.uncheck()
    expect(square).to_have_count(0)
    phone.is_line("lost")
    tab.page.get_by_role("switch").check()
    expect(square).to_be_visible()
    tab.says(own.access.lan_url)
    assert phone.page.goto(link).status == 401  # its token is void
    phone.says("scan its QR code")


def test_a_link_in_a_message_opens_the_page(lan, dash, visitor):
    """Pressed on another site's page, as in a messenger's; a bookmark as well."""
    tab = visitor(dash.url).show("live")
    tab.page.evaluate(
        "link => document.body.append(Object.assign(document.createElement('a'),"
        " {href: link, textContent: 'the car'}))",
        lan.access.lan_url,
    )
    tab.page.get_by_role("link", name="the car").click(force=True)
    fingerprint = lan.access.lan_url.partition("#")[2]
    expect(tab.page).to_have_url(f"https://{LAPTOP}:{lan.port}/#{fingerprint}")  # without the token
    tab.is_line("sampling")


def test_the_owner_s_page_shows_what_the_phone_s_certificate_is_compared_with(lan, visitor):
    tab = visitor(lan.url).show("connection")
    tab.says(lan.access.fingerprint)
    tab.says("continue only if it is the same")


@pytest.mark.parametrize("query", ["", "?token=", "?token=wrong"])
def test_without_the_token_a_page_in_words_says_what_to_do(lan, visitor, query):
    tab = visitor(f"https://{LAPTOP}:{lan.port}")
    tab.refused = True
    answer = tab.page.goto(f"https://{LAPTOP}:{lan.port}/{query}")
    assert answer.status == 401
    tab.says("scan its QR code")
    tab.says("отсканируйте QR-код")
    assert tab.find("header[data-line]").count() == 0


SHUT = {
    "faults": "Erase…",
    "passport": "Forget and measure again",
    "memory": "Unlock writing for 5 minutes…",
    "recordings": "Delete drive.pcapng",
    "connection": "Disconnect",
}
"""A control of each screen that only who has rights may use."""


def test_every_screen_says_that_a_viewer_only_watches(lan, visitor):
    lan.get("/passport")  # every client gets the last reading
    lan.post("/recording/start", {"name": "drive"})
    lan.until(lambda: lan.state()["recording"]["samples"] > 3)
    lan.post("/recording/stop")
    lan.nobody_controls()
    tab = by_the_link(lan, visitor)
    with no_wish_sent(tab):
        for screen in SCREENS:
            tab.show(screen)
            expect(tab.find("header[data-line]")).to_contain_text("view only")
            if screen in SHUT:
                expect(tab.button(SHUT[screen])).to_be_disabled()
                tab.says("This page can only watch")
        tab.show("live")
        expect(tab.value("TWAT")).to_have_text("87")
        expect(tab.button("Record", exact=True)).to_have_count(0)
        expect(tab.button("Edit")).to_have_count(0)


def test_a_key_that_would_change_something_says_why_it_does_not(lan, visitor):
    tab = by_the_link(lan, visitor)
    tab.refused = True
    tab.show("live")
    tab.is_line("sampling")
    tab.page.keyboard.press("r")
    tab.says("This page may only view")
    assert lan.state()["recording"] is None


def test_with_control_given_the_network_may_control(shared_control, visitor):
    tab = by_the_link(shared_control, visitor)
    tab.is_line("sampling")
    expect(tab.find("header[data-line]")).not_to_contain_text("view only")
    tab.press("Record")
    tab.is_line("recording")
    tab.press("Stop recording")
    tab.is_line("sampling")
    assert len(shared_control.get("/recordings")["recordings"]) == 1


HOUR = 3600


def choose(tab, preset):
    tab.page.get_by_role("tab", name=preset, exact=True).click()


def test_who_comes_while_another_controls_has_values_as_soon_as_that_one_is_gone(
    own, visitor, monkeypatch
):
    monkeypatch.setattr("mikas.dashboard.security.control.AFTER_SOCKET", HOUR)
    first = visitor(own.url).show("live")
    choose(first, "Fuel")
    # Or its request may come after the script has control.
    own.until(lambda: "UOZ" not in names_first(own))
    expect(first.value("INJ")).to_have_text("4.64")
    reduce(own)
    second = visitor(own.url).show("live")
    second.says("Controlled by")
    expect(second.value("INJ")).to_have_text("4.64")  # in the reduced plan
    expect(second.value("UOZ")).to_have_text("–")
    expect(second.find('[data-tile="UOZ"]')).to_contain_text("not sampled now")
    first.page.close()
    own.until(lambda: own.state()["viewers"] == 2)  # the second, and who waits here
    expect(second.value("UOZ")).to_have_text("–")  # the first may come back: a reload, a lid
    own.later(HOUR)
    expect(second.value("UOZ")).to_have_text("−3.5")
    expect(second.find("header[data-line]")).not_to_contain_text("Controlled by")


def names_first(dash):
    return dash.state()["plan"]["first"]


def reduce(dash):
    """A script's plan, without the advance."""
    wanted = [it for it in dash.state()["plan"]["wanted"] if it["name"] != "UOZ"]
    dash.post("/control/take", {"force": True})
    dash.put("/plan", {"wanted": wanted, "method": "batch", "rate": 12})


def test_free_control_is_taken_when_no_other_viewer_is_there(own, visitor):
    """A tab that was closed may count as a viewer for a while: a lid, a network that went away."""
    before = visitor(own.url).show("live")
    choose(before, "Fuel")
    own.until(lambda: "UOZ" not in names_first(own))
    with own.onlooker():
        before.page.close()
        own.nobody_controls()
        reduce(own)
        own.nobody_controls()
        after = visitor(own.url).show("live")
        after.is_line("sampling")
        expect(after.value("INJ")).to_have_text("4.64")
        expect(after.find('[data-tile="UOZ"]')).to_contain_text("not sampled now")
        assert own.state()["controller"] is None
    expect(after.value("UOZ")).to_have_text("−3.5")


def test_tab_after_tab_has_values(own, visitor):
    """One is still being closed when the next one comes."""
    for preset, name in (("Fuel", "UGB"), ("Idle", "UOZ")):
        before = visitor(own.url).show("live")
        choose(before, preset)
        own.until(lambda wanted=name: wanted in names_first(own))
        before.page.close()
        own.nobody_controls()
        after = visitor(own.url).show("live")
        expect(after.value("UOZ")).to_have_text("−3.5")
        after.page.close()
        own.nobody_controls()


def test_a_page_comes_back_by_itself_when_the_program_is_started_again(visitor, tmp_path):
    with ExitStack() as running:
        began = running.enter_context(dashboard(tmp_path)).samples()
        garage, port = began.garage, began.port
        tab = visitor(began.url).show("live")
        expect(tab.value("TWAT")).to_have_text("87")
        late = visitor(began.url)
        late.refused = tab.refused = True
        # The page has arrived, the program has not an answer left for it.
        late.page.route("**/api/**", lambda route: route.abort())
        late.page.goto(f"{began.url}/#/live")
        running.close()
        tab.says("Program does not answer")
        tab.says("Start it again; this page reconnects by itself")
        expect(tab.value("TWAT")).to_have_text("–")  # nothing on the screen is of now
        garage.set("TWAT", "80")
        running.enter_context(dashboard(tmp_path, port=port, garage=garage)).samples()
        late.page.unroute("**/api/**")
        for each in (tab, late):
            each.is_line("sampling")
            expect(each.value("TWAT")).to_have_text("88")
            expect(each.value("UOZ")).to_have_text("−3.5")


def test_each_address_of_the_computer_has_its_code_and_the_page_says_which_works(own, visitor):
    settings = own.dashboard.settings
    object.__setattr__(settings, "addresses", lambda: ("127.0.0.2", "127.0.0.3", "car"))
    tab = visitor(own.url).show("connection")
    tab.page.get_by_role("switch").check()
    tab.page.get_by_role("radio", name="127.0.0.3").check()
    link = own.access.lan_links[1].url
    tab.says(link)
    assert tab.until("() => document.querySelector('img[alt^=QR]').naturalWidth > 0")
    phone = visitor(f"https://127.0.0.3:{own.port}")
    phone.refused = True
    phone.page.goto(link)
    phone.is_line("sampling")
    expect(tab.page.get_by_role("radio", name="127.0.0.3 · works")).to_be_checked()
    expect(tab.page.get_by_role("radio", name="127.0.0.2")).not_to_be_checked()
