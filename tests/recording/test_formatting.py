"""Numbers and counts in both languages."""

from __future__ import annotations

import pytest

from mikas.catalog import Confidence, shipped
from mikas.i18n import Text, counted
from mikas.recording.formatting import (
    CONFIDENCE,
    band,
    clock,
    date_of,
    duration,
    number,
    percent,
    with_unit,
    within,
)
from mikas.report.labels import LABELS, Labels


@pytest.mark.parametrize(
    ("count", "en", "ru"),
    [(0, "0 faults", "0 ошибок"), (1, "1 fault", "1 ошибка"), (2, "2 faults", "2 ошибки"),
     (5, "5 faults", "5 ошибок"), (11, "11 faults", "11 ошибок"), (14, "14 faults", "14 ошибок"),
     (21, "21 faults", "21 ошибка"), (22, "22 faults", "22 ошибки"),
     (111, "111 faults", "111 ошибок"), (104, "104 faults", "104 ошибки")],
)  # fmt: skip
def test_a_count_has_the_plural_form_of_each_language(count, en, ru) -> None:
    assert counted(count, ("fault", "faults"), ("ошибка", "ошибки", "ошибок")) == Text(en, ru)


@pytest.mark.parametrize(
    ("value", "decimals", "en", "ru"),
    [(14.25, 1, "14.2", "14,2"), (-3.5, 1, "−3.5", "−3,5"), (-0.04, 1, "0.0", "0,0"),
     (850, 0, "850", "850"), (float("nan"), 1, "–", "–"), (float("inf"), 0, "–", "–")],
)  # fmt: skip
def test_numbers_are_written_as_in_the_language(value, decimals, en, ru) -> None:
    assert number(value, decimals, "en") == en
    assert number(value, decimals, "ru") == ru


def test_units_and_bands_are_written_as_in_the_language() -> None:
    catalog = shipped()
    assert with_unit(14.1, catalog.parameter("UACC"), "ru") == "14,1\N{NO-BREAK SPACE}В"
    assert with_unit(0.9, catalog.parameter("VALF"), "en") == "0.900"
    assert band(catalog.parameter("INJ"), "ru") == "4 … 5,5"
    assert band(catalog.parameter("THR"), "en") == "0"
    assert band(catalog.parameter("TAIR"), "en") == ""


@pytest.mark.parametrize(
    ("share", "message"), [(0, "0"), (0.0001, "1"), (0.5, "50"), (0.999, "99"), (1, "100")]
)
def test_all_and_nothing_are_said_only_of_all_and_nothing(share, message) -> None:
    assert percent(share) == f"{message}\N{NO-BREAK SPACE}%"


def test_times_and_durations_are_written_in_both_languages() -> None:
    assert [clock(s) for s in (0, 59.6, 425, 4025)] == ["0:00", "1:00", "7:05", "1:07:05"]
    assert duration(45) == Text("45 s", "45 с")
    assert duration(425) == Text("7 min 5 s", "7 мин 5 с")
    assert duration(420) == Text("7 min", "7 мин")
    assert duration(7800) == Text("2 h 10 min", "2 ч 10 мин")
    assert duration(36000) == Text("10 h", "10 ч")


def test_inside_a_sentence_only_a_plain_word_begins_small() -> None:
    assert within(Text("Air flow", "Расход")) == Text("air flow", "расход")
    assert within(Text("CO factor", "УОЗ")) == Text("CO factor", "УОЗ")


def test_every_confidence_has_words() -> None:
    assert set(CONFIDENCE) == set(Confidence)


def test_every_label_speaks_both_languages() -> None:
    english, russian = Labels("en"), Labels("ru")
    for name in LABELS.keys() - {"date"}:
        assert english(name) != russian(name), name
    assert russian("sample_rate", count=3, rate="1,5") == "3, 1,5 опр/с"


def test_a_time_beyond_the_calendar_has_no_date():
    for time in (1e300, 2.6e11, float("inf"), float("nan"), None, 5.0):
        assert date_of(time) is None
    assert date_of(1.79e9) is not None
