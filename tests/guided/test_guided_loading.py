"""Files of tests: the documented example, the user's folder, and mistakes with their line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from guided_rig import car_rows, run

from mikas.catalog import shipped
from mikas.catalog.loading.fields import schema_of
from mikas.catalog.loading.source import parse_source
from mikas.errors import CatalogError
from mikas.guided.definition import GuidedStep, GuidedTest, Measure, Rule, Statistic
from mikas.guided.loading import from_source, load

DOCS = (Path(__file__).parents[2] / "docs" / "reference" / "guided-tests.md").read_text("utf-8")
CAR, EXAMPLE = re.findall(r"```toml\n(.*?)```", DOCS, re.DOTALL)


def test_the_documented_example_loads_and_all_keys_are_documented() -> None:
    test = from_source(parse_source("fan.toml", EXAMPLE.encode()), shipped(), own=True)
    assert (test.name, test.title.ru, test.channels) == ("fan", "Вентилятор", ("TWAT", "FREQ"))
    assert (test.steps[0].whole, test.steps[0].watch, test.own) == (True, ("TWAT",), True)
    parts = (key for kind in (GuidedTest, GuidedStep, Measure, Rule) for key in schema_of(kind))
    for key in (*parts, *Statistic):
        assert f"`{key}`" in DOCS or f"`{key}." in DOCS or f"[{key}." in DOCS, key
    for name in load(shipped()).tests:
        assert f"| `{name}` |" in DOCS


def test_the_documented_car_has_the_fault_that_is_said() -> None:
    test = load(shipped()).tests["charging"]
    result = run(test, car_rows(CAR.replace("duration = 3600\n", ""), test.channels, 70, 10))
    assert result is not None
    assert [finding.rule for finding in result.findings] == ["no_charge"]


def test_a_wrong_file_of_the_users_is_named_and_the_others_load(tmp_path: Path) -> None:
    (tmp_path / "fan.toml").write_text(EXAMPLE, "utf-8")
    (tmp_path / "wrong.toml").write_text(EXAMPLE.replace("of = ", "off = "), "utf-8")
    (tmp_path / "Bad Name.toml").write_text(EXAMPLE, "utf-8")
    (tmp_path / "notes.txt").write_text("no test", "utf-8")
    (tmp_path / "charging.toml").write_text(EXAMPLE, "utf-8")
    found = load(shipped(), tmp_path)
    assert set(found.tests) == {*load(shipped()).tests, "fan"}
    assert found.tests["charging"].own
    assert sorted((Path(it.file).name, it.line) for it in found.errors) == [
        ("Bad Name.toml", 0),
        ("wrong.toml", EXAMPLE[: EXAMPLE.index("of = ")].count("\n") + 1),
    ]
    assert load(shipped(), tmp_path / "none").errors == ()


@pytest.mark.parametrize(
    ("before", "after", "problem"),
    [
        (
            "TWAT > 80",
            "TWATT > 80",
            "`start` names TWATT, which does not exist; the nearest",
        ),
        ("TWAT > 96 or", "TWAT > 96 and and", "`step.heat.until` is not a formula"),
        ("TWAT > 96 or", "FUEL_USED > 1 or", "names FUEL_USED, a total"),
        ('"max"', '"highest"', "`measure.HOTTEST.statistic` must be one of"),
        ('"max"', '"percentile"', '`measure.HOTTEST.percentile` goes with `statistic = "percent'),
        ('step = "heat"', 'step = "cool"', "`measure.HOTTEST.step` names cool"),
        ('"HOTTEST > 96"', '"WARMEST > 96"', "`rule.hot.when` names WARMEST"),
        ("reached {HOTTEST}", "reached {HOT!r}", "`rule.hot.text` names HOT"),
        ("reached {HOTTEST}", "reached {HOTTEST", "`rule.hot.text` has a single brace"),
        ("whole = true", "whole = 1", "`step.heat.whole` must be true or false"),
        ("whole = true", "wait = 4", "unknown key `wait`"),
        ('until = "TWAT > 96 or SECONDS > 420"', "", "`step.heat` needs `until`, or `hold`"),
        ("minutes = 8", "minutes = -8", "`minutes` must be a number from 0.1 to 600"),
        ("target.TWAT = [80, 96]", "target.TWAT = [96, 80]", "its low end 96 above its high end"),
        ("[rule.good]", "[rule.HOT]", "`rule.HOT` is there twice"),
        ("ru = ", "de = ", "unknown key `de`"),
    ],
)
def test_a_mistake_is_told_with_its_line(before: str, after: str, problem: str) -> None:
    assert before in EXAMPLE
    text = EXAMPLE.replace(before, after, 1)
    with pytest.raises(CatalogError, match=re.escape(problem)) as caught:
        from_source(parse_source("fan.toml", text.encode()), shipped())
    line = next(
        n
        for n, each in enumerate(EXAMPLE.splitlines(), 1)
        if before.split("\n", maxsplit=1)[0] in each
    )
    assert abs(caught.value.line - line) <= 3  # of the key, or of its table
    assert re.search("[а-я]", caught.value.problem.ru)
