"""The report on paper: as many sheets as it says, and each test's curves below its heading."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from mikas.catalog import shipped
from mikas.client.cars import CarDetails
from mikas.guided.engine import TestEngine
from mikas.guided.loading import load
from mikas.guided.result import TestResult
from mikas.report.findings import Findings, find
from mikas.report.page import render
from report.report_harness import GOOD, found, rows

CAR = CarDetails(
    "ГАЗ-3110 Волга", "А123ВС 52", 184_500, "Автосервис «У Петровича», Нижний Новгород"
)
REST = {
    "JQT": 1.4, "DET": 0.0, "BITPOW": 0.0, "RDET": 0.0, "VALF": 1.0, "RCOK": -0.5, "RCOD": -0.469,
    "UOZOC": 0.0, "SSM": 36.0, "FSM": 36.0, "MINERR": 0.0, "UGB": 14.8, "TWATI": 20.0,
}  # fmt: skip
"""What else a unit has, so that the page is as long as a drive's."""


def findings(*tests: TestResult, faults: tuple[int, ...] = (), **changed: float) -> Findings:
    made = found(rows(120, **REST, **changed), faults=faults)
    return find(replace(made.subject, car=CAR, tests=tests), made.measured)


def sensors(coolant: float) -> TestResult:
    engine = TestEngine(load(shipped()).tests["sensors"], shipped())
    for number in range(60):
        values = {**GOOD, "FREQ": 0.0, "TWAT": coolant + number % 2, "TAIR": 15.0, "JAIR": 0.0}
        engine.add_row(number / 5, values)
    assert engine.result is not None
    return engine.result


FAULTS = (17, 22, 41, 55)
REPORTS = {
    "sound": (findings(), 2),
    "faulty": (findings(faults=FAULTS, UACC=12.6, INJ=6.0), 2),
    "two tests": (findings(sensors(30), sensors(15), faults=FAULTS, UACC=12.6), 3),
}


@pytest.fixture
def printing(chromium):
    tab = chromium.new_page()
    yield tab
    tab.close()


@pytest.mark.parametrize("language", ["en", "ru"])
@pytest.mark.parametrize("kind", REPORTS)
def test_a_report_prints_on_as_many_sheets_as_it_says(printing, kind, language) -> None:
    made, most = REPORTS[kind]
    printing.set_content(render(made, language))
    printed = printing.pdf(prefer_css_page_size=True)
    sheets = len(re.findall(rb"/Type\s*/Page\b", printed))
    assert 1 <= sheets <= most


def test_the_curves_of_a_test_are_on_the_sheet_of_its_heading(printing) -> None:
    """The block is not divided, and is shorter than a sheet, else it would be all the same."""
    printing.set_content(render(REPORTS["two tests"][0], "ru"))
    printing.emulate_media(media="print")
    printing.set_viewport_size({"width": 703, "height": 1047})  # A4 without its margins
    blocks = printing.locator(".test")
    assert blocks.count() == 2
    for block in blocks.all():
        assert block.locator("h3").count() == 1
        assert block.locator("polyline").count() > 0
        assert block.evaluate("each => getComputedStyle(each).breakInside") == "avoid"
        assert block.bounding_box()["height"] < 1047
