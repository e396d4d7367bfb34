"""Language and theme are kept; two tabs share one seat; an adapter is pulled out and put back."""

from __future__ import annotations

from datetime import UTC, datetime

from playwright.sync_api import expect

from browser.rig import Tab, gaps_of


def test_language_and_theme_outlive_a_reload(dash, visitor):
    tab = visitor(dash.url, color_scheme="light").show("live")
    expect(tab.value("UACC")).to_have_text("13.8")
    html = tab.find("html")
    expect(html).to_have_attribute("lang", "en")
    expect(html).to_have_attribute("data-theme", "day")
    tab.press("Русский")
    tab.press("Дневные или ночные цвета")
    for _ in range(2):
        expect(html).to_have_attribute("lang", "ru")
        expect(html).to_have_attribute("data-theme", "night")
        expect(tab.value("UACC")).to_have_text("13,8")
        tab.page.reload()


def test_one_controls_and_the_other_watches(own, visitor):
    first = visitor(own.url).show("live")
    first.press("Record")
    first.is_line("recording")
    second = visitor(own.url).show("live")
    second.is_line("recording")
    second.says("Controlled by")
    expect(second.value("TWAT")).to_have_text("87")
    second.show("faults")
    expect(second.button("Erase…")).to_be_disabled()
    second.press("Take control")
    expect(second.button("Erase…")).to_be_enabled()
    first.says("Controlled by")
    second.press("Stop recording")
    first.is_line("sampling")
    assert len(own.get("/recordings")["recordings"]) == 1


def test_an_adapter_that_was_pulled_comes_back_by_itself(own, visitor):
    tab = visitor(own.url).show("live")
    tab.press("Record")
    tab.is_line("recording")
    own.until(lambda: own.state()["recording"]["samples"] > 3)
    own.garage.pull()
    tab.is_line("no-port")
    expect(tab.find("header [role=alert]")).to_be_visible()
    expect(tab.value("TWAT")).to_have_text("–")  # never the last number
    own.garage.set("TWAT", "80")
    own.garage.put_back()
    tab.is_line("recording")
    expect(tab.value("TWAT")).to_have_text("88")
    tab.press("Stop recording")
    tab.is_line("sampling")
    (made,) = own.get("/recordings")["recordings"]
    assert len(gaps_of(own, made)) == 1


def test_the_controls_of_a_tab_that_was_left_go_to_the_next_of_that_browser(
    own, visitor, monkeypatch
):
    """Within the time that is granted for it, however long the browser takes."""
    monkeypatch.setattr("mikas.dashboard.security.control.AFTER_SOCKET", 3600)
    first = visitor(own.url).show("live")
    first.page.context.clock.set_fixed_time(datetime.now(UTC))
    first.press("Record")
    first.is_line("recording")
    held = own.state()["controller"]
    first.page.goto("about:blank")
    second = Tab(first.page.context.new_page(), own.url).show("live")
    second.is_line("recording")
    second.press("Stop recording")
    second.is_line("sampling")
    assert own.state()["controller"] == held
    first.show("live")
    first.is_line("sampling")
    first.says("Controlled by")
    assert not second.complaints
