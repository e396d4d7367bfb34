"""Scenarios: the shipped ones, a person's own file, what is refused and where, laps and keys."""

from __future__ import annotations

import re
from math import inf
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mikas.catalog.loading.source import parse_source
from mikas.errors import CatalogError, UsageError
from mikas.virtual.model.engine import Engine
from mikas.virtual.scenarios.scenario import (
    DEFAULT,
    FORM,
    SCENARIOS,
    Scenario,
    find,
    from_source,
    load,
)
from mikas.virtual.scenarios.timeline import ScenarioTimeline, Track

DOCS = Path(__file__).parents[2] / "docs" / "reference" / "scenarios.md"
KNOWN = [
    "mixed",
    "warm-idle",
    "cold-start",
    "city",
    "highway",
    "full-load",
    "key-off",
    "cranking-dip",
    "survey",
]


def scenario(text: str) -> Scenario:
    return from_source(parse_source("my.toml", text.encode()))


def test_the_shipped_scenarios_have_texts_and_pin_nothing() -> None:
    assert set(SCENARIOS) == set(KNOWN)
    assert next(iter(SCENARIOS)) == DEFAULT == "warm-idle"
    for name, shipped in SCENARIOS.items():
        assert shipped.name == name
        assert shipped.text.en
        assert re.search("[а-я]", shipped.text.ru)
        assert (shipped.values, shipped.raw, shipped.faults) == ({}, {}, frozenset())


def test_a_scenario_is_found_by_name_or_by_file(tmp_path: Path) -> None:
    assert find("city") is SCENARIOS["city"]
    file = tmp_path / "ride.toml"
    file.write_text("duration = 20\n", encoding="utf-8")
    own = find(str(file))
    assert (own.name, own.text.en, own.text.ru, own.timeline.duration) == (
        "ride",
        "ride",
        "ride",
        20,
    )
    with pytest.raises(UsageError, match=r"no file “cty”; scenarios: warm-idle, city, cold-start"):
        find("cty")
    with pytest.raises(CatalogError, match="can't be read"):
        load(tmp_path / "none.toml")


@pytest.mark.parametrize("name", ["", "x" * 300, "a\0b", "no/such.toml"])
def test_what_names_no_file_is_a_missing_one(name: str) -> None:
    with pytest.raises(UsageError, match="there is no scenario and no file") as caught:
        find(name)
    assert isinstance(caught.value, FileNotFoundError)


def test_a_folder_is_said_to_be_one(tmp_path: Path) -> None:
    with pytest.raises(CatalogError, match="folder") as caught:
        find(str(tmp_path))
    assert isinstance(caught.value, IsADirectoryError)


def test_a_file_sets_everything_that_it_can_say() -> None:
    own = scenario(
        """
        name = "mine"
        duration = 100
        after_end = "loop"
        loop_from = 40
        faults = [13, 53]
        passports = ["МИКАС 7.1", "X"]
        text = "Mine"
        [start]
        ambient = -5.5
        running = true
        battery = 0.8
        [timeline]
        key = [[0, 1], [90, 0]]
        load = 12.5
        throttle = [[0, 0], [10, 50]]
        [values]
        twat = 85.0
        RXX = true
        [raw]
        JAIR = "DC 05"
        [memory.code]
        8000 = "4D 49"
        "0xFF00" = "FF"
        """
    )
    assert own.name == "mine"
    assert own.text == ("Mine", "Mine")
    start = own.start
    assert (start.ambient, start.coolant, start.coolant_at_start) == (-5.5, -5.5, -5.5)
    assert (start.running, start.battery) == (True, 0.8)
    assert own.faults == {13, 53}
    assert own.passports == ("МИКАС 7.1", "X", "", "", "", "", "", "")
    assert own.values == {"TWAT": 85.0, "RXX": True}
    assert own.raw == {"JAIR": b"\xdc\x05"}
    assert own.memory == {"code": {0x8000: b"MI", 0xFF00: b"\xff"}}
    inputs = own.timeline.at(5)
    assert inputs.throttle == pytest.approx(25, abs=1e-3)
    assert (inputs.gear, inputs.speed, inputs.load) == (None, None, 12.5)
    assert [own.timeline.key_on(t) for t in (0, 89.9, 90, 99, 100, 149.9, 150, 160)] == [
        True, True, False, False, True, True, False, True,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        ("durtion = 5", 1, "unknown key `durtion`; the nearest is `duration`"),
        ("name = 'x'", 0, "has no `duration`"),
        ("\n\nduration = 0", 3, "`duration` must be a number from 1 to"),
        ("duration = 'long'", 1, "`duration` must be a number"),
        ("duration = 9\nafter_end = 'stop'", 2, '`after_end` must be one of "hold", "loop"'),
        ("duration = 9\nloop_from = 8.5", 2, "`loop_from` must be at least 1 s before the end"),
        (
            "duration = 9\n[start]\nambiant = 3",
            3,
            "the nearest is `ambient`",
        ),
        ("duration = 9\n[start]\nrunning = 1", 3, "`start.running` must be true or false"),
        ("duration = 9\n[timeline]\nspeed = 'fast'", 3, "must be a number or points"),
        ("duration = 9\n[timeline]\nspeed = [[0, 1, 2]]", 3, "must be a number or points"),
        ("duration = 9\n[timeline]\nspeed = []", 3, "must be a number or points"),
        ("duration = 9\n[timeline]\nspeed = [[3, 1]]", 3, "first point at second 0"),
        ("duration = 9\n[timeline]\nspeed = [[0, 1], [0, 2]]", 3, "later than the one before"),
        ("duration = 9\n[timeline]\nspeed = [[0, 1], [10, 2]]", 3, "a point after the end"),
        ("duration = 9\n[timeline]\nspeed = 900", 3, "must be a number from 0 to 200"),
        ("duration = 9\n[timeline]\ngear = 2.5", 3, "must be a whole number from 0 to 5"),
        ("duration = 9\n[timeline]\nspeed = [[0, nan]]", 3, "must be a number or points"),
        ("duration = 9\ntimeline = 3", 2, "`timeline` must be a table, as [timeline]"),
        (
            "duration = 9\n[condition]\nthrottle_stops = [0, 101]",
            3,
            "must be two openings",
        ),
        ("duration = 9\nfaults = [13, 256]", 2, "must be a list of fault numbers"),
        ("duration = 9\nfaults = 13", 2, "must be a list of fault numbers"),
        ("duration = 9\npassports = ['12345678901234567']", 2, "at most 16 characters"),
        ("duration = 9\npassports = ['€']", 2, "code page 866"),
        ("duration = 9\npassports = [1]", 2, "must be at most 8 texts"),
        ("duration = 9\n[raw]\nTWAT = '7'", 3, 'must be bytes in hex, as "7D"'),
        ("duration = 9\n[raw]\nTWAT = 7", 3, 'must be bytes in hex, as "7D"'),
        ("duration = 9\n[raw]\nTWAT = ''", 3, 'must be bytes in hex, as "7D"'),
        ("duration = 9\n[values]\nTWAT = '7'", 3, "must be a number, true or false"),
        ("duration = 9\n[memory.rom]\n0 = '00'", 2, "unknown key `rom`; the nearest is `ram`"),
        ("duration = 9\n[memory.ram]\nFF = '0011'", 3, "must be an address in hex"),
        ("duration = 9\n[memory.ram]\nxyz = '00'", 3, "must be an address in hex"),
        ("duration = ", 1, "this is not TOML"),
    ],
)
def test_errors_name_their_line(text: str, line: int, problem: str) -> None:
    with pytest.raises(CatalogError) as caught:
        scenario(text)
    assert (caught.value.file, caught.value.line) == ("my.toml", line)
    assert problem in str(caught.value)


def test_a_track_goes_along_lines_or_in_steps() -> None:
    line, step = Track((0, 10), (0, 100)), Track((0, 10), (0, 100), smooth=False)
    assert [line.at(t) for t in (-1, 0, 2.5, 10, 99)] == [0, 0, 25, 100, 100]
    assert [step.at(t) for t in (-1, 0, 9.9, 10, 99)] == [0, 0, 0, 100, 100]


def test_after_the_end_it_holds_or_begins_again() -> None:
    held = scenario("duration = 10\n[timeline]\nspeed = [[0, 0], [10, 50]]")
    speeds = [held.timeline.at(t).speed for t in (5, 10, 1e6)]
    assert speeds == pytest.approx([25, 50, 50], abs=1e-4)
    looped = scenario(
        "duration = 10\nafter_end = 'loop'\nloop_from = 6\n[timeline]\nspeed = [[0, 0], [10, 50]]"
    )
    speeds = [looped.timeline.at(t).speed for t in (5, 9, 10, 13, 14, 17)]
    assert speeds == pytest.approx([25, 45, 30, 45, 30, 45], abs=1e-4)
    assert looped.timeline.at(9).soon == pytest.approx(30, abs=1e-4)


@settings(max_examples=300)
@given(
    st.lists(st.integers(1, 1000), unique=True, max_size=4).map(sorted),
    st.booleans(),
    st.integers(0, 900),
    st.integers(1, 6000),
)
def test_key_changes_are_met_one_after_the_other(
    points: list[int], loops: bool, loop_from: int, scale: int
) -> None:
    """Odd lengths make times that floats can't hold exactly; still no change is missed."""
    unit = scale / 7000
    times = (0.0, *(point * unit for point in points))
    key = Track(times, tuple(float(i % 2) for i in range(len(times))), smooth=False)
    never = Track((0.0,), (0.0,))
    line = ScenarioTimeline(1000 * unit, loops, loop_from * unit, key, never, never, never)
    now, changes = 0.0, 0
    while (change := line.next_key_change(now)) < inf and changes < 30:
        assert change > now
        assert line.key_on(change) != line.key_on(now)
        halfway = (now + change) / 2
        assert line.key_on(halfway) == line.key_on(now)
        now, changes = change, changes + 1
    if not loops:
        assert changes == len(points)


def test_the_key_is_met_on_a_clock_that_counts_from_1970() -> None:
    key_off, start, now = SCENARIOS["key-off"], 1_790_000_000.123456, 0.0
    for _ in range(50):
        now = start + key_off.timeline.next_key_change(now)
        before = key_off.timeline.key_on(now - start - 0.001)
        assert key_off.timeline.key_on(now - start) != before
        now -= start


def test_the_key_is_turned_at_its_times_in_a_hundred_laps() -> None:
    key_off, now = SCENARIOS["key-off"], 0.0
    for lap in range(100):
        now = key_off.timeline.next_key_change(now)
        assert now == pytest.approx(60 * lap + 20)
        now = key_off.timeline.next_key_change(now)
        assert now == pytest.approx(60 * lap + 35)
    assert SCENARIOS["city"].timeline.next_key_change(5) == inf


def test_the_example_in_the_documentation_works() -> None:
    examples = re.findall(r"```toml\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    assert examples
    for example in examples:
        engine = Engine(scenario(example))
        engine.advance(10)
        assert engine.state.ignition_on


def test_the_documentation_names_every_scenario_and_key() -> None:
    text = DOCS.read_text(encoding="utf-8")
    keys = [key for table in ("start", "timeline", "condition") for key in FORM[table]]
    for word in (*SCENARIOS, "after_end", "loop_from", "passports", *keys):
        assert f"`{word}`" in text
