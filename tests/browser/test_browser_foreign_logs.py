"""Another program's log beside a recording: its columns are chosen, and stay its own."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import expect

from browser.rig import dashboard
from dashboard.recordings_rig import record

# Windows-1251, semicolons, decimal commas, a line of units, one cell that is no number.
LOG = "Лямбда-метр 2.1;;\nt;AFR;Топливо\n;ед.;бар\n" + "".join(
    f"{at * 100};{14 + at % 10 / 10:.1f};{3.0 if at != 7 else 'обрыв'}\n".replace(".", ",")
    for at in range(100)
)
FILE = LOG.encode("cp1251")
PHONE = {"width": 390, "height": 844}


@pytest.fixture(scope="module")
def drive(chromium, tmp_path_factory):
    folder = tmp_path_factory.mktemp("drive")
    (folder / "recordings").mkdir()
    record(folder / "recordings" / "drive.pcapng", count=60)
    with dashboard(folder, begin=False) as dash:
        yield dash


@pytest.fixture
def tab(drive, visitor):
    return visitor(drive.url).show("recordings")


def dialog(tab):
    return tab.page.get_by_role("dialog")


def bar(tab):
    return tab.page.get_by_role("group", name="Comparison")


def choose_file(tab, data=FILE, name="bench.csv"):
    if not dialog(tab).is_visible():
        tab.press("Compare drive.pcapng with…")
    with tab.page.expect_file_chooser() as chooser:
        dialog(tab).get_by_role("button", name="Another program’s log…").click()
    chooser.value.set_files([{"name": name, "mimeType": "text/csv", "buffer": data}])


def column(tab, name):
    box = tab.page.get_by_role("checkbox", name=re.compile(f"^{name}"))
    return dialog(tab).locator("li", has=box)


def compare(tab):
    return dialog(tab).get_by_role("button", name="Compare", exact=True)


def test_a_log_is_drawn_with_its_own_names_and_units(tab):
    choose_file(tab)
    expect(dialog(tab)).to_contain_text("Columns of bench.csv")
    expect(dialog(tab).get_by_label("Encoding")).to_have_value("windows-1251")
    expect(dialog(tab).get_by_label("Titles in line")).to_have_value("2")
    expect(dialog(tab).get_by_label("Units in line")).to_have_value("3")
    expect(column(tab, "Топливо").get_by_label("Unit of Топливо")).to_have_value("бар")
    expect(compare(tab)).to_be_disabled()  # nothing says what the time counts
    dialog(tab).get_by_label("Which column is the time").select_option(label="t: 0")
    expect(column(tab, "t")).to_have_count(0)
    expect(compare(tab)).to_be_disabled()
    dialog(tab).get_by_label("What it counts").select_option(label="milliseconds")
    dialog(tab).get_by_label("Unit of AFR").fill("AFR")
    compare(tab).click()

    expect(bar(tab)).to_contain_text("bench.csv")
    expect(tab.find('[data-second="log:AFR"] b')).to_have_text("14.0")
    expect(tab.find('[data-second="log:Топливо"] b')).to_have_text("3")
    legend = tab.find(".trace", has=tab.page.locator('[data-second="log:Топливо"]'))
    expect(legend).to_contain_text("бар")
    expect(tab.find('[data-second="FREQ"]')).to_contain_text("not recorded")
    bar(tab).get_by_text("1 remark on the file").click()
    expect(bar(tab)).to_contain_text("Топливо: cells that are no number, left empty: 1")
    expect(bar(tab)).to_contain_text("line 11")

    bar(tab).get_by_role("button", name="End the comparison").click()
    expect(tab.find('[data-second="log:AFR"]')).to_have_count(0)
    tab.page.reload()
    expect(tab.find("header[data-line]")).to_be_visible()
    assert "log:" not in (tab.page.evaluate("localStorage['mikas.chart']") or "")


def test_a_wrong_setting_says_so_and_is_taken_back(tab):
    tab.refused = True
    choose_file(tab)
    dialog(tab).get_by_label("Between cells").select_option(label="|")
    expect(dialog(tab).get_by_role("alert")).to_contain_text("another delimiter")
    dialog(tab).get_by_label("Another one").fill(";")
    dialog(tab).get_by_label("Another one").press("Tab")
    expect(dialog(tab).get_by_role("alert")).to_have_count(0)
    expect(column(tab, "AFR")).to_be_visible()


def test_a_damaged_file_says_where(tab):
    tab.refused = True
    choose_file(tab, b"Time (s),x\n0,1\n1,2,3\n2,3\n", "broken.csv")
    expect(dialog(tab).get_by_label("What it counts")).to_have_value("s")  # the file says it
    compare(tab).click()
    expect(dialog(tab).get_by_role("alert")).to_contain_text("broken.csv, line 3: 3 cells here")
    dialog(tab).get_by_role("button", name="Cancel").click()
    expect(dialog(tab)).to_contain_text("Compare drive.pcapng with")


def test_our_own_export_comes_back_with_the_same_values(tab, drive):
    address = "/api/recordings/drive.pcapng/export?format=mlg&names=TWAT"
    choose_file(tab, drive.api.get(address).raise_for_status().content, "again.mlg")
    expect(column(tab, "CLT")).to_be_visible()
    expect(dialog(tab).get_by_label("Encoding")).to_have_count(0)
    compare(tab).click()
    expect(tab.find('[data-second="log:CLT"] b')).to_have_text(tab.traced("TWAT").inner_text())


def test_on_a_phone(drive, visitor):
    tab = visitor(drive.url, viewport=PHONE, locale="ru-RU").show("recordings")
    tab.find("#screen article").get_by_role("button", name="Сравнить").click()
    with tab.page.expect_file_chooser() as chooser:
        dialog(tab).get_by_role("button", name="Лог другой программы…").click()
    file = {"name": "стенд.csv", "mimeType": "text/csv", "buffer": FILE}
    chooser.value.set_files([file])
    dialog(tab).get_by_label("Какой столбец — время").select_option(label="t: 0")
    dialog(tab).get_by_label("В чём оно").select_option(label="миллисекунды")
    expect(column(tab, "AFR")).to_be_visible()
    wide = "() => document.scrollingElement.scrollWidth - innerWidth"
    assert tab.page.evaluate(wide) <= 0
    dialog(tab).get_by_role("button", name="Сравнить", exact=True).click()
    expect(tab.find('[data-second="log:AFR"] b')).to_have_text("14,0")
