"""The survey for the project on the desktop: led, reloaded, without its cable, shown, saved."""

from __future__ import annotations

from playwright.sync_api import expect

from mikas.survey import read_survey

from .rig import dashboard


def needs_no_scrolling(tab, name):
    tab.page.set_viewport_size({"width": 1280, "height": 720})
    expect(tab.button(name, exact=True)).to_be_in_viewport(ratio=1)


def test_a_survey_outlives_a_reload_and_a_lost_cable_and_is_saved(chromium, tmp_path, visitor):
    with dashboard(tmp_path, scenario="survey") as own:
        tab = visitor(own.samples().url).show("connection")
        tab.find("#screen a:has-text('Have a look')").click()
        needs_no_scrolling(tab, "Start")
        tab.find("#screen").get_by_label("I can start the engine here").uncheck()
        tab.find("#screen").get_by_label("Voltmeter at the battery").fill("12,4")
        tab.press("Start", exact=True)
        todo = tab.find(".todo")
        expect(todo).to_have_text("Ignition on, engine off")
        expect(tab.find("#screen")).to_contain_text("codes 00–FF")
        tab.is_line("off")
        tab.page.reload()
        expect(todo).to_have_text("Ignition on, engine off")
        own.garage.pull()
        tab.says("It broke off. What was measured is kept.")
        expect(tab.find(".answers .found")).not_to_have_count(0)
        own.garage.put_back()
        tab.press("Go on")
        expect(tab.find("#screen")).to_contain_text("codes 00–FF")
        tab.press("Stop", exact=True)
        tab.says("Stopped. What was measured is kept.")
        tab.find("summary:has-text('unit.json')").click()
        expect(tab.find("details[open] pre")).to_contain_text('"passports": null')
        tab.press("Save the file")
        with tab.page.expect_download() as saving:
            tab.find("#screen a:has-text('Download')").click()
        saving.value.save_as(tmp_path / "got.zip")
        kept = read_survey(tmp_path / "got.zip")
        assert kept.measured["engine"] is False
        assert kept.measured["done"][:3] == ["least_pause", "turn_round", "unknown"]
        assert tab.complaints == []
        own.samples()  # the connection has its port again


def test_a_car_that_is_not_ready_is_waited_for(own, visitor):
    tab = visitor(own.url, locale="ru-RU").show("connection/survey")  # its engine runs
    needs_no_scrolling(tab, "Начать")
    tab.press("Начать", exact=True)
    expect(tab.find(".acts .todo")).to_contain_text("двигатель ЗАГЛУШЕН")
    tab.press("Прервать", exact=True)
    tab.says("Прервано. Измеренное сохранено.")
    tab.press("Забыть")
    tab.find("dialog[open]").get_by_role("button", name="Забыть").click()
    tab.says("Зажигание ВКЛЮЧИТЬ")
