"""The section on guided tests, and the headline and summary with one that found something."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from mikas.catalog import shipped
from mikas.guided.definition import VerdictKind as OfTest
from mikas.guided.engine import TestEngine
from mikas.guided.loading import load
from mikas.guided.result import TestResult
from mikas.report.findings import Outcome, find
from mikas.report.measurements.measurements import MeasurementCollector
from mikas.report.page import render
from mikas.report.subject import ReportSubject


def result(coolant: float) -> TestResult:
    engine = TestEngine(load(shipped()).tests["sensors"], shipped())
    for number in range(60):
        values = {"FREQ": 0.0, "TWAT": coolant + number % 2, "TAIR": 15.0, "THR": 0.0, "JAIR": 0.0}
        engine.add_row(number / 5, values)
    assert engine.result is not None
    return engine.result


def page(*tests: TestResult) -> tuple[Outcome, str, str]:
    subject = ReportSubject(catalog=shipped(), tests=tests)
    found = find(subject, MeasurementCollector(shipped(), ()).measured)
    return found.outcome, render(found, "en"), render(found, "ru")


def test_a_test_that_found_something_is_in_headline_and_section() -> None:
    outcome, en, ru = page(result(15), result(30))
    assert outcome is Outcome.ATTENTION
    assert "the guided test “Sensors at rest (cold engine)” found: the temperatures disagree" in en
    assert "Guided tests" in en
    assert "Rule: (APART &gt; 7 or APART &lt; -7) and WATER &lt;= 45; confidence: medium." in en
    assert "Check next: Lay a thermometer" in en
    assert "Проверки по шагам" in ru
    assert en.count("<polyline") == 2


def test_noise_does_not_fill_the_drawing_of_a_course() -> None:
    _, en, _ = page(result(15))
    drawing = re.findall(r"<polyline class='course' points='([^']*)'", en)[0]
    heights = [float(point.split(",")[1]) for point in drawing.split()]
    assert 0 < max(heights) - min(heights) < 20  # of 120: one degree up and down


def test_a_later_good_result_cures_an_earlier_one() -> None:
    later = replace(result(15), ended=1e3)
    outcome, en, _ = page(result(30), later)
    assert outcome is Outcome.OPEN
    assert "found: the temperatures" not in en


def test_an_undecided_test_names_its_reasons_and_is_no_fault() -> None:
    undecided = result(60)
    assert undecided.outcome is OfTest.UNKNOWN
    outcome, en, _ = page(undecided)
    assert outcome is Outcome.OPEN
    assert "The coolant shows 60 °C, so the engine is not cold" in en


@pytest.mark.parametrize("text", ["<script>", "{{ 7 }}"])
def test_hostile_texts_stay_texts(text: str) -> None:
    named = result(30)
    hostile = replace(named, title=type(named.title)(text, text))
    _, en, _ = page(hostile)
    assert text not in en or text == "{{ 7 }}"
