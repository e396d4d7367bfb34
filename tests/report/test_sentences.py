"""Every sentence of the report has a rule: it stands on the page exactly when that holds.

docs/reference/report.md and docs/ru/reference/report.md have the rules in words, `sentence_rules`
as functions.
"""

from __future__ import annotations

import ast
import html
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from report_harness import GOOD, START, found, measured, rows
from sentence_rules import ALWAYS, RULES
from test_report_alarms import event
from test_report_causes import NOTHING, SEVERAL, leaking, with_causes

import mikas.report
from mikas.catalog import Level, load, shipped
from mikas.causes.result import CauseVerdict
from mikas.guided.definition import Certainty as GuidedConfidence
from mikas.guided.definition import VerdictKind
from mikas.guided.result import Finding, TestResult
from mikas.i18n import Text
from mikas.recording.freeze_frames import AppearedFault, frame_of
from mikas.report.findings import BandPosition, Findings, Outcome, find
from mikas.report.page import render
from mikas.report.sections.summary import summary_sentence
from mikas.report.subject import ClearedFaults, ReportedUnit
from mikas.sampling.events import ClockChanged, Gap

DOCS = Path(__file__).parents[2] / "docs"
RULED = (
    "sections/summary", "sections/limitations", "sections/alarm_texts", "sections/conditions",
    "sections/freeze_frames", "labels", "../recording/formatting",
)  # fmt: skip

WORDS = {
    "", "below", "above", "lowest", "highest", "normal", "low", "high", "not rated", "erased",
    "no longer stored",
    "fault {} was", "faults {} were", "no values ({})", "{} was {}", "at {}", "on {}", "{} s",
    "{} min{}",
    "at {} of the measurement", "{} ({}): {}.", "Engine report", "Car", "Number plate", "Mileage",
    "Workshop",
    "Control unit", "Model",
    "Program", "Calibration", "Alarms", "Stored faults", "measured", "Values at warm idle",
    "Value", "Median", "90 % within", "Normal", "Rating", "Charts", "How it was measured",
    "Length", "Samples", "Method", "Adapter", "Echo", "yes", "no", "Gaps", "Clock",
    "Line errors",
    "Catalog", "Warm idle", "What remains unknown", "Made by {}", "%d.%m.%Y %H:%M",
    "{}, {} readings/s", "one request per parameter (61)", "several parameters per request (61)",
    "a list in the unit (64, 63)", "a stream from the unit (71)",
    "a response every engine cycle (7F–83)", "Freeze frames", "Then", "In between",
    "between {} and {}", "on {} between {} and {}", "between {} and {} of the measurement",
}  # fmt: skip
"""Titles, names and parts of sentences."""


# The sentences in the code and on the page


def written(node: ast.expr) -> str:
    if isinstance(node, ast.Constant):
        return re.sub(r"\{\w*\}", "{}", str(node.value))
    if isinstance(node, ast.JoinedStr):
        return "".join(written(it) if isinstance(it, ast.Constant) else "{}" for it in node.values)
    return ""


def sentences() -> dict[str, str]:
    """The texts of the report's modules, Russian by English, without mere combinations of parts."""
    folder, found_ = Path(mikas.report.__file__).parent, {}
    for name in RULED:
        for node in ast.walk(ast.parse((folder / f"{name}.py").read_text("utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Text" and node.args:
                english, *others = map(written, node.args)
                found_[english] = "".join(others)
    return {
        english: russian
        for english, russian in found_.items()
        if re.search("[A-Za-z]{3}", english) and english not in WORDS
    }


def documented(page: Path) -> list[tuple[str, str]]:
    """The rows of the tables: a sentence and its rule."""
    return re.findall(r"^\| `(.+?)` \| (.+) \|$", page.read_text("utf-8"), re.MULTILINE)


def test_every_sentence_has_a_rule_in_words_and_one_that_is_evaluated() -> None:
    said = sentences()
    assert set(said) == set(RULES)
    english = documented(DOCS / "reference" / "report.md")
    russian = documented(DOCS / "ru" / "reference" / "report.md")
    assert {sentence for sentence, _ in english} == set(RULES)
    assert [sentence for sentence, _ in russian] == [said[sentence] for sentence, _ in english]
    assert all(rule.strip() for _, rule in english + russian)


def page_of(f: Findings, language="en") -> str:
    text = re.sub(r"(?s)<style>.*?</style>|<svg.*?</svg>", "", render(f, language))
    return re.sub(r"\s+", " ", html.unescape(re.sub("<[^>]+>", " ", text))) + " "


def _pattern(sentence: str) -> re.Pattern[str]:
    parts = [re.escape(part) for part in sentence.split("{}")]
    return re.compile(r".{1,300}?".join(parts).removeprefix(".{1,300}?"))


PATTERNS = {sentence: _pattern(sentence) for sentence in RULES} | {
    "{} stored: {}": re.compile(r"\d+ faults? (is|are) stored: "),
    "{} more": re.compile(r"\d more "),
    "No faults are stored": re.compile(r"No faults are stored( now)?;"),
    "not read": re.compile(r"(Model|Program|Calibration) not read\b"),
    "Read {}.": re.compile(r"\bRead (at|on) "),
    "none": re.compile(r"(?<![\w-])none(?! of the)\b"),
}


def agrees(f: Findings, page: str = "") -> set[str]:
    """Check all rules, and return the sentences that are there."""
    page = page or page_of(f)
    there = {sentence for sentence, pattern in PATTERNS.items() if pattern.search(page)}
    holding = {sentence for sentence, rule in RULES.items() if rule(f)}
    assert there == holding, f"said without a rule {there - holding}; not said {holding - there}"
    return there


def erased(*codes: int, read: float, erased: bool = True, stored: tuple[int, ...] = ()) -> Findings:
    it = found(faults=stored)
    cleared = ClearedFaults(START + 59, tuple(map(shipped().fault, codes)), erased)
    return find(replace(it.subject, cleared=(cleared,), faults_read=START + read), it.measured)


def of_unit(unit: ReportedUnit | None) -> Findings:
    it = found()
    return replace(it, subject=replace(it.subject, unit=unit))


def after_a_test(outcome: str) -> Findings:
    verdict = Finding("a", "b", VerdictKind(outcome), Text("bad.", "плохо."), *_NO_TEXTS)
    it, title = found(), Text("Charging", "Зарядка")
    result = TestResult(
        "charging", title, START, START + 9, verdict.outcome, (verdict,), (), (), (), ()
    )
    return find(replace(it.subject, tests=(result,)), it.measured)


def appeared(code: int, *, seconds: float = 2.0, far: bool = False, erased: bool = False):
    """A fault that came twenty seconds after the start; `far`: at an unknown moment."""
    it = found(faults=() if erased else (code,))
    read = START + 20 + seconds
    values = rows(THR=lambda times: times)
    frame = None if far else frame_of(code, START + 20, read, values)
    came = (AppearedFault(code, START + 20, read, frame),)
    return find(replace(it.subject, appeared=came), it.measured)


def part(times):
    return np.where(times < 20, 0.0, np.nan)


def seldom(times):
    return np.where(np.isin(np.arange(times.size), (100, 200, 300, 400)), 9.9, np.nan)


def spikes(times):
    return np.where(np.isin(np.arange(times.size), (100, 300)), 117.0, 88.0)


def knocks(times):
    return np.where(np.isin(np.arange(times.size), (100, 103, 300)), 1.0, 0.0)


def own_references(tmp_path: Path) -> Findings:
    file = tmp_path / "own.toml"
    file.write_text("[parameter.TWAT]\nreference = [82, 97]\n")
    catalog = load(file)
    return find(replace(found().subject, catalog=catalog), measured(rows(), catalog=catalog))


def only(*names: str):
    return rows(**{name: None for name in GOOD if name not in names})


_NO_TEXTS = (Text("", ""), Text("", ""), GuidedConfidence.LOW)
CLOCK = ClockChanged(START + 9, 3600.0, slept=False, before=START, after=START + 3600)
GAP = Gap(START + 15, START + 10, START + 15, Text("no echo", "нет эха"))


def cases(tmp_path: Path) -> list[Findings]:
    model = shipped().model(0x0A)
    return [
        found(), found(rows(JAIR=11.2, UACC=12.9)), found(faults=(41, 12, 99, 53)),
        found(faults=None), found(faults=(12,)), found(faults=(13,)), found(faults=(21, 71)),
        found(faults=(195,)), found(faults=(23, 17)), found(rows(UACC=seldom)),
        found(rows(TWAT=45), faults=(21,)), found(rows(FREQ=1520.0)),
        found(rows(8)), found(rows(0), faults=None),
        found(rows(THR=None, RXX=None)), found(rows(THR=part)), found(rows(THR=part, RXX=None)),
        found(rows(TWAT=lambda t: np.where(t < 20, 45.0, np.nan))),
        found(only("TWAT", "FREQ", "RXX"), faults=(21, 53)), found(only("TAIR")),
        found(only("TWAT", "RXX", "FREQ"), faults=(53,)),
        found(rows(TWAT=spikes)), found(rows(TWAT=117.0, UACC=9.0), faults=(22,)),
        found(rows(TWAT=lambda t: np.where(t < 20, 101.0, 88.0))),
        found(rows(TWAT=None), events=[event(10, "warning", 101.0)]),
        found(rows(FREQ=3400.0, DET=knocks, RDET=1.0)), found(rows(RDET=1.0)),
        found(rows(DET=knocks)), found(rows(INJ=0.0, JAIR=0.0)),
        erased(13, 53, read=60), erased(13, read=5000), erased(99, read=60, erased=False),
        erased(12, read=60), erased(13, read=60, stored=(13,)),
        found(interruptions=None), found(interruptions=(GAP,) * 5, sessions=3, ports=2, damaged=1),
        found(clock=(CLOCK,)), found(clock=(CLOCK,) * 4), found(rows(0), faults=None, empty=True),
        found(sessions=2, cars=(Text("A 1", "А 1"), Text("B 2", "Б 2"))),
        found(file="", port="sim:"), found(file="", date=None), found(port="sim:?scenario=city"),
        found(errors=2, method="stream", other_methods=True),
        of_unit(None), of_unit(ReportedUnit(model)), own_references(tmp_path),
        of_unit(ReportedUnit(model, (None,) * 3, (None,) * 5)),
        of_unit(ReportedUnit(model, ("A",), (None,))),
        _without_references(tmp_path), after_a_test("attention"), after_a_test("good"),
        appeared(13), appeared(71, seconds=0.1), appeared(17, far=True), appeared(195),
        appeared(21, erased=True), appeared(12), appeared(99),
        leaking(), leaking(faults=None), with_causes(found(), CauseVerdict.SOUND, NOTHING),
        with_causes(found(faults=None), CauseVerdict.SOUND, NOTHING),
        with_causes(found(faults=(13,)), CauseVerdict.SOUND, NOTHING),
        with_causes(found(), CauseVerdict.CANNOT_TELL, SEVERAL, off=True),
    ]  # fmt: skip


def _without_references(tmp_path: Path) -> Findings:
    """A catalog's references can't be taken away, so channels with one are not recorded."""
    it = found(rows(60))
    idle_values = {n: s for n, s in it.measured.at_idle.items() if n in ("TAIR", "RXX")}
    channels = tuple(each for each in it.measured.channels if each.name in idle_values)
    curves = {n: c for n, c in it.measured.curves.items() if n in idle_values}
    bare = replace(
        it.measured, channels=channels, at_idle=idle_values, curves=curves, watched=frozenset()
    )
    return find(it.subject, bare)


def test_a_sentence_is_there_when_its_rule_holds_and_absent_when_it_does_not(tmp_path) -> None:
    said = [agrees(each) for each in cases(tmp_path)]
    for sentence in RULES:
        assert any(sentence in each for each in said), f"in no case: {sentence}"
        absent = any(sentence not in each for each in said)
        assert absent != (sentence in ALWAYS), f"in all cases: {sentence}"


NUMBERS = re.compile(r"\d+(?:[.,]\d+)?")
VALUES = {
    "TWAT": (45.0, 79.0, 80.0, 88.0, 95.0, 96.0, 99.9, 101.0), "FREQ": (790.0, 840.0, 7000.0),
    "UACC": (9.0, 13.4, 14.1, 18.5), "JAIR": (11.0, 14.5, 30.0), "THR": (0.0, 1.0, 50.0),
    "RXX": (0.0, 1.0),
}  # fmt: skip


@settings(max_examples=12, deadline=None)
@given(
    st.fixed_dictionaries(
        {name: st.sampled_from([None, *values]) for name, values in VALUES.items()}
    ),
    st.none() | st.lists(st.sampled_from([12, 13, 17, 21, 23, 41, 53, 71, 99, 195]), max_size=3),
    st.sampled_from([5.0, 15.0, 40.0]),
)
@example(dict.fromkeys(VALUES) | {"TWAT": 88.0}, [53, 71], 15.0)  # 71 concerns what 53 suspends
def test_sentences_and_page_agree_whatever_was_measured(values, faults, seconds) -> None:
    codes = None if faults is None else tuple(dict.fromkeys(faults))
    f = found(rows(seconds, 5, **values), faults=codes)
    page, russian = page_of(f), page_of(f, "ru")
    agrees(f, page)
    sensors = {n for code in codes or () for n in shipped().fault(code).sensor}
    for value in f.rated:
        low, high = value.channel.reference
        inside = low - 1e-9 <= value.stats.median <= high + 1e-9
        assert (value.mark is BandPosition.INSIDE) is inside
        assert value.channel.name not in sensors
    assert {value.mark for value in f.values if value.unrated} <= {BandPosition.NONE}
    crossed = any(each.limit.level is not Level.NONE for each in f.measured.alarms)
    assert crossed is (" Alarms " in page)
    assert crossed is ("alarm" in summary_sentence(f).en) is ("тревог" in summary_sentence(f).ru)
    assert (f.outcome is Outcome.ATTENTION) is ("Attention needed" in page)
    said = summary_sentence(f)
    assert _numbers(said.en) == _numbers(said.ru)
    assert _numbers(page) == _numbers(russian)


def _numbers(text: str) -> list[str]:
    """The numbers of a text, without those in names and words (`ЗМЗ-406`, `A4`)."""
    return sorted(number.replace(",", ".") for number in NUMBERS.findall(text))


@pytest.mark.parametrize("code", sorted(shipped().faults))
def test_a_fault_is_of_a_sensor_only_by_its_text(code) -> None:
    fault = shipped().fault(code)
    named = re.search(r"signal (low|high)|sensor", fault.text.en, re.IGNORECASE)
    no_channel = {15, 16, 54, 55}  # pressure, phase and road speed are not among the values
    assert bool(fault.sensor) is (bool(named) and code not in no_channel)
    assert set(fault.sensor) <= set(fault.parameters)
