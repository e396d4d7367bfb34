"""Alarms: a value beyond its limit shows on its gauge, in the band and in the list, on both sides
and both levels; it ends with hysteresis, and all of it is in the recording.
"""

from __future__ import annotations

import pytest
from playwright.sync_api import expect

from browser.rig import dashboard

VOLTS = {  # as the catalog has it: warning below 10 V, danger above 18 V, over 0.5 V inside
    "good": ("8A", "13.8"),
    "low": ("63", "9.9"),
    "still low": ("68", "10.4"),
    "no longer low": ("6A", "10.6"),
    "high": ("B5", "18.1"),
    "still high": ("B0", "17.6"),
    "no longer high": ("AE", "17.4"),
}


@pytest.fixture(scope="module")
def watched(chromium, tmp_path_factory):
    with dashboard(tmp_path_factory.mktemp("alarms")) as dash:
        yield dash.samples()


@pytest.fixture
def car(watched):
    watched.nobody_controls()
    for name, raw in (("UACC", "8A"), ("TWAT", "7F"), ("FREQ", "15")):
        watched.garage.set(name, raw)
    watched.until(lambda: watched.state()["alarms"] == [])
    return watched


def volts(dash, tab, which):
    raw, text = VOLTS[which]
    dash.garage.set("UACC", raw)
    expect(tab.value("UACC")).to_have_text(text)


def band(tab, count):
    """The band's button that shows how many alarms there are."""
    return tab.find("header[data-line]").get_by_role("button", name=count)


def listed(tab, count):
    """The lines of the alarm list."""
    band(tab, count).click()
    lines = tab.page.get_by_role("dialog").locator("li")
    expect(lines.first).to_be_visible()
    return lines


def shut(tab):
    tab.page.keyboard.press("Escape")
    expect(tab.page.get_by_role("dialog")).to_have_count(0)


@pytest.mark.parametrize(
    ("beyond", "still", "over", "level", "word", "said"),
    [
        ("low", "still low", "no longer low", "warning", "low", "9.9 V, below 10 V"),
        ("high", "still high", "no longer high", "danger", "high", "18.1 V, above 18 V"),
    ],
)
def test_a_value_beyond_its_limit_is_seen_until_it_is_well_inside(
    car, visitor, beyond, still, over, level, word, said
):
    tab = visitor(car.url).show("live")
    tile = tab.find('[data-tile="UACC"]')
    volts(car, tab, "good")
    expect(tile).not_to_contain_class(level)
    expect(band(tab, "alarm")).to_have_count(0)
    volts(car, tab, beyond)
    expect(tile).to_contain_class(level)
    expect(tile.locator(".gauge")).to_contain_class(level)
    expect(tile.locator("h2")).to_contain_text(word)
    expect(band(tab, "1 alarm")).to_contain_class(f"signal-{level}")
    lines = listed(tab, "1 alarm")
    expect(lines).to_have_count(1)
    expect(lines).to_contain_class(f"signal-{level}")
    expect(lines).to_contain_text(said)
    shut(tab)
    volts(car, tab, still)  # inside the limit, not yet by the hysteresis
    expect(tile).to_contain_class(level)
    expect(band(tab, "1 alarm")).to_be_visible()
    volts(car, tab, over)
    expect(tile).not_to_contain_class(level)
    expect(tile.locator("h2")).not_to_contain_text(word)
    expect(band(tab, "alarm")).to_have_count(0)


def test_of_two_alarms_the_worse_one_is_shown(car, visitor):
    tab = visitor(car.url, locale="ru-RU").show("live")
    car.garage.set("TWAT", "91")
    car.garage.set("UACC", "B5")
    expect(band(tab, "2 тревоги")).to_contain_class("signal-danger")
    lines = listed(tab, "2 тревоги")
    expect(lines).to_have_count(2)
    expect(lines.filter(has_text="105 °C, выше 100 °C")).to_contain_class("signal-warning")
    expect(lines.filter(has_text="18,1 В, выше 18 В")).to_contain_class("signal-danger")
    shut(tab)
    car.garage.set("UACC", "8A")
    expect(band(tab, "1 тревога")).to_contain_class("signal-warning")


def test_an_alarm_is_kept_in_the_recording(car, visitor):
    tab = visitor(car.url).show("live")
    volts(car, tab, "good")
    tab.press("Record")
    tab.is_line("recording")
    volts(car, tab, "low")
    expect(band(tab, "1 alarm")).to_be_visible()
    volts(car, tab, "no longer low")
    expect(band(tab, "alarm")).to_have_count(0)
    tab.press("Stop recording")
    tab.is_line("sampling")
    (made,) = car.get("/recordings")["recordings"]
    events = car.get(f"/recordings/{made['id']}")["events"]
    alarms = [it for it in events if it["kind"] == "alarm"]
    changes = [(it["name"], it["before"], it["level"], it["side"], it["limit"]) for it in alarms]
    assert changes == [
        ("UACC", "none", "warning", "low", 10),
        ("UACC", "warning", "none", "low", 10),
    ]
    assert [it["value"] for it in alarms] == [9.9, 10.6]
    assert alarms[0]["text"]["en"].endswith("9.9 V is below 10 V: warning")
