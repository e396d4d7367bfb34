"""Every sentence of the fleet's report has a rule: it stands on the page exactly when that holds.

docs/how-to/fleet.md has the rules in words, `RULES` as functions.
"""

from __future__ import annotations

import ast
import html
import re
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mikas.fleet.report.sentences as module
from mikas.catalog import shipped
from mikas.causes.result import CauseVerdict
from mikas.fleet.cars import KnownBy
from mikas.fleet.report.causes import JudgedDrive
from mikas.fleet.report.comparing import FEWEST_DRIVES, FEWEST_OF_TREND, Peers, trend, value_of
from mikas.fleet.report.figures import CarFigures, DatedFaults, FleetFigures
from mikas.fleet.report.findings import FleetFindings, find
from mikas.fleet.report.measures import MEASURES
from mikas.fleet.report.page import render
from mikas.report.measurements.statistics import is_inside

DOCUMENT = Path(__file__).parents[2] / "docs" / "how-to" / "fleet.md"
NOW = datetime(2026, 6, 1)
FIRST = datetime(2026, 3, 1, 8)
CATALOG = shipped()
MEASURE = {measure.key: measure for measure in MEASURES}


def car(name: str = "A", readings=((),), known_by: str = "plate", **series) -> CarFigures:
    """A car with drives a day apart; `series`: the values of its measures."""
    at = [FIRST + timedelta(days=number) for number in range(100)]
    valued = {key: list(zip(at, values, strict=False)) for key, values in series.items()}
    heard = [DatedFaults(*it) for it in zip(at, readings, strict=False)]
    count = max((len(values) for values in series.values()), default=1)
    return CarFigures(
        name, frozenset({KnownBy(known_by)}), "Волга", count, 0, 0, 3600.0 * count, at[0],
        at[max(0, count - 1)], valued, heard, bool(heard),
    )  # fmt: skip


def fleet(*cars: CarFigures, unknown: int = 0, refused: int = 0) -> FleetFindings:
    return find(FleetFigures(cars, unknown, NOW, refused), CATALOG)


# The rules, from the figures: the findings are not asked


def values(f: FleetFindings, key: str) -> dict[str, float]:
    every = {it.figures.car: value_of(it.figures.values(key)) for it in f.cars}
    return {name: value for name, value in every.items() if value is not None}


def differs(f: FleetFindings, name: str, key: str) -> bool:
    every = values(f, key)
    found = (
        Peers(every.values()).outlier(every[name], MEASURE[key].least) if name in every else None
    )
    return found is not None


def is_off(f: FleetFindings, name: str, key: str) -> bool:
    reference = MEASURE[key].channel(CATALOG).reference
    value = values(f, key).get(name)
    return reference is not None and value is not None and not is_inside(value, reference)


def drifts(it: CarFigures, key: str) -> bool:
    return trend(it.values(key), MEASURE[key].least) is not None


def stored(it: CarFigures) -> bool:
    return bool(it.readings and it.readings[-1].codes)


def needs(f: FleetFindings, it: CarFigures) -> bool:
    return stored(it) or any(
        differs(f, it.car, key) or is_off(f, it.car, key) or drifts(it, key) for key in MEASURE
    )


def some(rule: Callable[[FleetFindings, CarFigures], bool]) -> Callable[[FleetFindings], bool]:
    return lambda f: any(rule(f, it.figures) for it in f.cars)


def followed(f: FleetFindings) -> int:
    every = [[len(it.figures.values(key)) for key in MEASURE] for it in f.cars]
    return sum(max(each) >= FEWEST_OF_TREND for each in every)


def compared(f: FleetFindings) -> list[str]:
    return [key for key in MEASURE if len(values(f, key)) >= 5]


def seen(it: CarFigures) -> bool:
    return any(reading.codes for reading in it.readings)


def gone(it: CarFigures) -> bool:
    before = {code for reading in it.readings for code in reading.codes}
    return bool(before - set(it.readings[-1].codes)) if it.readings else False


RULES: dict[str, Callable[[FleetFindings], bool]] = {
    "{} of {} cars: attention needed": some(needs),
    "No car stands out": lambda f: not some(needs)(f) and bool(compared(f)),
    "Not enough data for a comparison": lambda f: not some(needs)(f) and not compared(f),
    "Fault {} is stored: {}.": some(lambda _, it: stored(it)),
    "{}: {}, outside the normal range ({}).": some(
        lambda f, it: any(is_off(f, it.car, key) for key in MEASURE)
    ),
    "{}: {}; the other {} cars: {}, from {} to {}.": some(
        lambda f, it: any(differs(f, it.car, key) for key in MEASURE)
    ),
    "{} has changed over {} drives: from {} to {}.": some(
        lambda _, it: any(drifts(it, key) for key in MEASURE)
    ),
    "stored at the latest reading; first seen {}": some(lambda _, it: stored(it)),
    "no longer stored at the latest reading; seen from {} to {}": some(lambda _, it: gone(it)),
    "unknown fault number": some(lambda _, it: any(99 in reading.codes for reading in it.readings)),
    "Its stored faults were never read.": some(lambda _, it: not it.read),
    (
        "Known by its unit's passport only: several cars with the same program would be one here."
    ): some(lambda _, it: it.known_by == {KnownBy.UNIT}),
    "Not compared: no value in {} drives or more.": some(
        lambda _, it: all(len(it.values(key)) < FEWEST_DRIVES for key in MEASURE)
    ),
    "Left out: {} dated in the future, so the clock was wrong.": some(lambda _, it: it.ahead > 0),
    "Left out: {} without a date.": some(lambda _, it: it.undated > 0),
    "A car's value is the median of its latest {} drives, and of {} at least; a drive's value is "
    "the median of its readings.": lambda _: True,
    "Compared with the other cars: {}.": lambda f: bool(compared(f)),
    "Followed over time, with {} drives or more: {}.": lambda f: followed(f) > 0,
    "Too few cars to compare ({} are needed): {}.": lambda f: len(compared(f)) < len(MEASURE),
    "Too few drives for changes over time ({} are needed): {}.": lambda f: (
        len(f.cars) > followed(f)
    ),
    (
        "Causes are ranked for each drive by itself, known from a model of the engine and service "
        "literature, not from cars. They don't decide on attention."
    ): some(lambda _, it: bool(it.judged)),
    "The causes in {}: an earlier version of mikas added them. Add the same recordings again.": (
        some(lambda _, it: it.unjudged > 0)
    ),
    "Of which car: {} have neither a plate nor a name nor a unit's passport.": lambda f: (
        f.figures.unknown > 0
    ),
    "Left out: {} of the dataset whose files can't be used.": lambda f: f.figures.refused > 0,
    "Why a car differs. Cars with other equipment, other loads or another program do too: a "
    "difference is a reason to check, not a proof.": lambda _: True,
}


def english(node: ast.expr) -> str:
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(english(it) if isinstance(it, ast.Constant) else "{}" for it in node.values)
    return ""


def test_every_sentence_has_a_rule_in_words_and_one_that_is_evaluated() -> None:
    tree = ast.parse(Path(module.__file__).read_text("utf-8"))
    said = {
        english(node.args[0])
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Text" and node.args
    }
    assert {text for text in said if re.search("[A-Za-z]{3}", text)} == set(RULES)
    documented = re.findall(r"^\| `(.+?)` \| (.+) \|$", DOCUMENT.read_text("utf-8"), re.MULTILINE)
    assert {sentence for sentence, rule in documented if rule.strip()} >= set(RULES)


def page_of(f: FleetFindings) -> str:
    text = re.sub(r"(?s)<style>.*?</style>|<svg.*?</svg>", "", render(f, "en"))
    return re.sub(r"\s+", " ", html.unescape(re.sub("<[^>]+>", "\n", text)).replace("\n", " | "))


def pattern(sentence: str) -> re.Pattern[str]:
    parts = [re.escape(part) for part in sentence.split("{}")]
    return re.compile(r"[^|]{1,900}?".join(parts).removeprefix(r"[^|]{1,900}?"))


PATTERNS = {sentence: pattern(sentence) for sentence in RULES} | {
    "{}: {}, outside the normal range ({}).": re.compile(r"outside the normal range \("),
    "{}: {}; the other {} cars: {}, from {} to {}.": re.compile(r"; the other \d+ cars: "),
    "{} has changed over {} drives: from {} to {}.": re.compile("has changed over"),
}


def agree(f: FleetFindings) -> set[str]:
    page = page_of(f)
    there = {sentence for sentence, found in PATTERNS.items() if found.search(page)}
    holding = {sentence for sentence, rule in RULES.items() if rule(f)}
    assert there == holding, f"said without a rule {there - holding}; not said {holding - there}"
    return there


SOUND = [14.1, 14.0, 14.2, 14.1, 14.1]


def cases() -> list[FleetFindings]:
    five = [car(name, idle_voltage=SOUND) for name in "ABCDE"]
    long = [14.1, 14.0] * 5
    return [
        fleet(), fleet(*five), fleet(*five[:4]), fleet(car()),
        fleet(*five[:4], car("E", idle_voltage=[12.0] * 5)),
        fleet(car(idle_voltage=[12.0] * 3)), fleet(car(idle_voltage=[12.0] * 2)),
        fleet(car(idle_valve=[30.0 + 3 * n for n in range(10)])),
        fleet(car(idle_voltage=long), unknown=3), fleet(car(), refused=2),
        fleet(*five, car("F", readings=((), (13,)))), fleet(car(readings=((13,), ()))),
        fleet(car(readings=((99, 13), (99,)))), fleet(car(readings=())),
        fleet(replace(car(readings=()), read=True, undated=1)),
        fleet(car(known_by="unit")), fleet(replace(car(), undated=2, ahead=1)),
        fleet(replace(car(), unjudged=2)),
        fleet(replace(car(), judged=[JudgedDrive(FIRST, 60.0, CauseVerdict.SOUND)])),
        fleet(*(car(name, **{key: [10.0] * 8 for key in MEASURE}) for name in "ABCDEF")),
    ]  # fmt: skip


def test_a_sentence_is_there_when_its_rule_holds_and_absent_when_it_does_not() -> None:
    said = [agree(each) for each in cases()]
    always = {sentence for sentence, rule in RULES.items() if all(rule(each) for each in cases())}
    for sentence in RULES:
        assert any(sentence in each for each in said), f"in no case: {sentence}"
        assert (sentence in always) == all(sentence in each for each in said)
    assert len(always) == 2


series = st.lists(
    st.sampled_from((11.0, 12.5, 13.4, 13.5, 14.0, 14.5, 14.6, 34.0, 60.0)), max_size=12
)
codes = st.sets(st.sampled_from((13, 17, 53, 99)), max_size=2).map(lambda it: tuple(sorted(it)))


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.dictionaries(st.sampled_from(tuple(MEASURE)), series), st.lists(codes, max_size=4)
        ),
        max_size=7,
    )
)
def test_sentences_and_page_agree_on_any_fleet(drawn) -> None:
    cars = (car(f"C{n}", tuple(heard), **valued) for n, (valued, heard) in enumerate(drawn))
    agree(fleet(*cars))


def test_the_page_is_self_contained_and_escapes_what_a_recording_says() -> None:
    hostile = replace(car("<script>alert(1)</script>", idle_voltage=SOUND), name='"><img src=x>')
    for language in ("en", "ru"):
        page = render(fleet(hostile), language)
        assert "<script" not in page
        assert "<img" not in page
        assert "http" not in re.sub("http-equiv", "", page)
        assert "Content-Security-Policy" in page
    assert "Отчёт по автопарку" in page
    assert "машина" in page or "машин" in page


def test_numbers_are_in_the_page_s_language() -> None:
    page = render(fleet(car(idle_voltage=[12.0] * 3)), "ru")
    assert "12,0\N{NO-BREAK SPACE}В, вне нормы (13,5 … 14,5)" in html.unescape(page)


def test_a_large_fleet_has_charts_where_attention_is_needed() -> None:
    cars = [car(f"C{number}", idle_voltage=SOUND) for number in range(60)]
    cars.append(car("BAD", idle_voltage=[12.0] * 5))
    page = render(fleet(*cars), "en")
    assert page.count("<figure>") == 1
    assert page.count("<h2>C") == 61  # and “Cars”


def test_a_measure_has_its_range_only_at_warm_idle() -> None:
    for measure in MEASURES:
        channel = measure.channel(CATALOG)
        assert (channel.reference is not None) == (
            measure.state == "warm-idle" and CATALOG.parameter(measure.name).reference is not None
        )
        if channel.reference is not None:
            width = channel.reference[1] - channel.reference[0]
            assert measure.least == pytest.approx(width / 2)
