"""The Connection screen: one click to connect; each obstacle has a message of its own."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from browser.rig import FT232, dashboard
from mikas.client.doctor import examine


@pytest.fixture(scope="module")
def unconnected(chromium, tmp_path_factory):
    with dashboard(tmp_path_factory.mktemp("off"), begin=False, baud="57600") as dash:
        dash.garage.plug("/dev/ttyUSB8", "CH340", supplied="0")
        dash.garage.plug("/dev/ttyUSB5", "CH340", least_pause="0.1")
        dash.garage.plug("/dev/ttyUSB9", "CP2102", adapter="elm327")
        dash.garage.plug("/dev/ttyUSB6", "PL2303", scenario=dash.garage.key_off())
        yield dash


@pytest.fixture
def off(unconnected):
    unconnected.post("/control/take", {"force": True})
    unconnected.post("/disconnect")
    unconnected.post("/control/release")
    return unconnected


def test_an_adapter_is_one_click_away(off, visitor):
    tab = visitor(off.url).show("live")
    tab.says("Not connected")
    tab.find("#screen").get_by_role("link", name="Connect").click()
    expect(tab.find("#screen ul li").first).to_contain_text("FT232R")
    tab.press(f"Connect to {FT232.url}")
    tab.is_line("sampling")
    expect(tab.find("header[data-line]")).to_contain_text("Mikas 7.1")
    tab.show("live")
    expect(tab.value("TWAT")).to_have_text("87")


def test_the_virtual_car_is_offered_where_it_stays(off, visitor):
    """A card that moved away when the adapters came took a click with it."""
    tab = visitor(off.url).show("live")
    held = []

    def hold(scan):
        held.append(scan)

    tab.page.route("**/api/ports", hold)
    tab.show("connection").says("Scanning for adapters")
    car = tab.button("Start the virtual car")
    expect(car).to_have_count(0)
    for scan in held:
        scan.continue_()
    expect(car).to_be_visible()


def test_the_virtual_car_leads_to_its_gauges(own, visitor):
    tab = visitor(own.url).show("connection")
    tab.press("Disconnect")
    tab.press("Start the virtual car")
    expect(tab.find('nav a[data-screen="live"]')).to_have_attribute("aria-current", "page")
    expect(tab.value("FREQ")).to_be_visible()


@pytest.mark.parametrize(
    ("port", "said", "line"),
    [
        ("/dev/ttyUSB8", "No response, not even an echo", "no-echo"),
        ("/dev/ttyUSB9", "This is an ELM327: the wrong kind of adapter", "off"),
        ("/dev/ttyUSB6", "The adapter works, the ECU does not answer", "echo-only"),
    ],
)
def test_each_obstacle_has_its_own_message(off, visitor, port, said, line):
    tab = visitor(off.url).show("connection")
    tab.refused = True
    tab.press(f"Connect to {port}")
    tab.says(said)
    tab.is_line(line)


def test_a_missing_port_is_shown_and_waited_for(off, visitor, tmp_path):
    tab = visitor(off.url, locale="ru-RU").show("connection")
    tab.refused = True
    tab.find("summary", has_text="Другой порт").click()
    tab.find("form input").fill(str(tmp_path / "ttyUSB0"))
    tab.find("form [type=submit]").click()
    tab.is_line("no-port")
    expect(tab.find("#screen [role=alert]").first).to_be_visible()


@pytest.fixture
def deliberate(monkeypatch):
    """A doctor that takes no step behind that of the speed until its port is taken away."""

    def examined(open_port, create_ecu, *, others=None):
        opened = []

        def open_and_note():
            opened.append(open_port())
            return opened[0]

        for step in examine(open_and_note, create_ecu):
            yield step
            if step.name == "baud":
                opened[0].gather(opened[0].now() + 3600)

    monkeypatch.setattr("mikas.dashboard.session.port_threads.examine", examined)


def test_the_examination_is_drawn_step_by_step(deliberate, off, visitor):
    tab = visitor(off.url).show("connection")
    tab.press(f"Connect to {FT232.url}")
    tab.is_line("sampling")
    tab.press("Run check")
    steps = tab.find("ol[aria-busy] li")
    expect(steps).to_have_count(7)
    for step in ("Port", "Echo"):
        expect(steps.filter(has_text=step).first).to_contain_class("ok")
    measured = re.compile(r"\b(ok|bad|unsure)\b")  # on a busy computer the echo comes late
    expect(steps.nth(2)).to_have_class(measured)
    expect(steps.nth(3)).to_contain_class("running")
    tab.is_line("off")
    now = tab.find("#screen .now")
    expect(now).to_contain_text("being checked")
    expect(now).to_contain_text(FT232.url)
    expect(now.locator("li")).to_contain_text(["✓ works", "✓ works", "? unknown", "? unknown"])
    tab.press("Stop")
    tab.says("The check was stopped")
    tab.is_line("sampling")


def test_headline_picture_and_steps_of_a_check_agree(off, visitor):
    tab = visitor(off.url).show("connection")
    tab.refused = True
    tab.press("Connect to /dev/ttyUSB8")  # without 12 V
    tab.is_line("no-echo")
    tab.press("Run check")
    tab.says("Failed at: Echo")
    steps = tab.find("ol[aria-busy] li")
    expect(steps.nth(0)).to_contain_class("ok")
    expect(steps.nth(1)).to_contain_class("bad")
    now = tab.find("#screen .now")
    expect(now).to_contain_text("No response, not even an echo")
    expect(now).to_contain_text("/dev/ttyUSB8")
    expect(now.locator("li")).to_contain_text(["✓ works", "! check", "! check", "? unknown"])
    expect(tab.find("li.here")).to_contain_text("open, waiting for a response")
    tab.press(f"Connect to {FT232.url}")
    tab.is_line("sampling")
    expect(now).to_contain_text("The ECU answers")
    expect(now.locator("li")).to_contain_text(["✓ works"] * 4)


def test_opening_a_port_raises_no_alarm(off, visitor):
    tab = visitor(off.url).show("connection")
    tab.page.evaluate(
        """() => {
            window.seen = [];
            new MutationObserver(() => {
                const alert = document.querySelector("[role=alert]");
                const { line } = document.querySelector("header[data-line]").dataset;
                if (alert && line !== "sampling") window.seen.push(alert.textContent);
            }).observe(document.body, { subtree: true, childList: true, characterData: true });
        }"""
    )
    tab.press(f"Connect to {FT232.url}")
    tab.is_line("sampling")
    tab.says("The ECU answers")
    assert tab.page.evaluate("window.seen") == []


@pytest.mark.parametrize(
    ("port", "said"),
    [
        ("{folder}/ttyUSB0", "There is no such port"),
        ("{folder}/a-file", "The port can't be opened"),
        ("socket://127.0.0.1:1", "No adapter at this address"),
    ],
)
def test_a_port_that_does_not_open_is_not_called_unplugged(off, visitor, tmp_path, port, said):
    (tmp_path / "a-file").write_text("no port", "utf-8")
    tab = visitor(off.url).show("connection")
    tab.refused = True
    tab.find("summary", has_text="Another port").click()
    tab.find("form input").fill(port.format(folder=tmp_path))
    tab.find("form [type=submit]").click()
    expect(tab.find("#screen [role=alert]").first).to_contain_text(said)
    expect(tab.page.get_by_text(off.state()["reason"]["en"])).to_have_count(1)
    expect(tab.find("#screen")).not_to_contain_text("unplugged")
    expect(tab.find("#screen")).not_to_contain_text("● in use")


def test_leaving_amid_a_recording_asks(off, visitor):
    tab = visitor(off.url).show("connection")
    tab.press(f"Connect to {FT232.url}")
    tab.is_line("sampling")
    tab.press("Record")
    tab.is_line("recording")
    sheet = tab.page.get_by_role("dialog")
    tab.press("Disconnect")
    expect(sheet).to_contain_text("ends the recording")
    sheet.get_by_role("button", name="Cancel").click()
    tab.is_line("recording")
    tab.press("Disconnect")
    sheet.get_by_role("button", name="Disconnect").click()
    tab.is_line("off")
    tab.says("Recording saved")


def test_the_pause_that_a_unit_needs_is_found_shown_and_can_be_set(off, visitor):
    """D14. A recording goes on."""
    tab = visitor(off.url, locale="ru-RU").show("connection")
    tab.press("Подключить /dev/ttyUSB5")
    pause = tab.find("[data-pause]")
    expect(pause).to_contain_text("100 мс, найдена подбором")
    tab.press("Запись")
    tab.is_line("recording")
    pause.locator("summary").click()
    tab.press("Своя")
    expect(pause.get_by_label("Пауза, мс")).to_have_value("100")
    pause.locator("input").fill("2500")
    tab.says("Целое число от 0 до 2000.")
    expect(tab.button("Задать паузу")).to_be_disabled()
    pause.locator("input").fill("130")
    tab.press("Задать паузу")
    expect(pause).to_contain_text("130 мс, задана")
    tab.is_line("recording")
    assert off.state()["pause"] == {"chosen": 0.13, "seconds": 0.13}
    tab.press("Сама")
    tab.press("Задать паузу")
    expect(pause).to_contain_text("100 мс, найдена подбором")


@pytest.mark.parametrize(
    ("locale", "end", "ended"),
    [("en-GB", "End mikas", "mikas has ended"), ("ru-RU", "Завершить mikas", "mikas завершён")],
)
def test_a_program_on_its_icon_is_ended_by_the_page(visitor, tmp_path, locale, end, ended):
    with dashboard(tmp_path, begin=False, desktop=True) as dash:
        tab = visitor(dash.url, locale=locale).show("connection")
        tab.refused = True
        tab.press(end)
        tab.find("dialog").get_by_role("button", name=end).click()
        tab.says(ended)
    expect(tab.find("#screen h2").first).to_have_text(ended)


def test_a_program_in_a_terminal_has_no_such_button(off, visitor):
    tab = visitor(off.url).show("connection")
    tab.says("Phone or tablet")
    expect(tab.button("End mikas")).to_have_count(0)


def test_a_virtual_car_is_chosen_with_its_defect_or_blind(off, visitor):
    tab = visitor(off.url).show("connection")
    tab.find("summary").get_by_text("Choose a car and its defect").click()
    tab.find("#screen").get_by_label("Defect").select_option("Coolant sensor shows too little")
    tab.says("−20 °C")
    tab.find("#screen").get_by_label("Drive").select_option("Warm engine at idle, the car standing")
    tab.press("Start this car")
    tab.is_line("sampling")
    expect(tab.find('nav a[data-screen="live"]')).to_have_attribute("aria-current", "page")
    tab.show("connection").says("warm-idle coolant_sensor:-20")
    tab.find("summary").get_by_text("Choose a car and its defect").click()
    tab.press("Find out what is wrong")
    tab.find("#screen").get_by_role("textbox", name="Number").fill("4711")
    tab.press("Start this car")
    expect(tab.find('nav a[data-screen="live"]')).to_have_attribute("aria-current", "page")
    tab.show("connection").says("Car blind:4711: find out what is wrong with it.")
    tab.is_line("sampling")
    expect(tab.find("#screen")).not_to_contain_text("sticks: moves only after")
    tab.press("Show the answer")
    tab.says("sticks: moves only after")
