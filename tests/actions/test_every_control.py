"""The table has every button, link and menu of the page: a new one without a row fails here."""

from __future__ import annotations

from pathlib import Path

import pytest

from .controls import controls
from .screens import BEFORE, ELSEWHERE, NAMED, ROWS

TESTS = Path(__file__).parents[1]


def test_no_control_of_the_page_is_without_a_row_and_no_row_without_its_control():
    pressed = {name for row in (*BEFORE, *ROWS) for name in row.pressed()}
    assert sorted(set(controls()) - pressed - set(ELSEWHERE) - set(NAMED)) == []
    assert sorted((pressed | set(ELSEWHERE) | set(NAMED)) - set(controls())) == []
    assert sorted(pressed & set(ELSEWHERE)) == []


def test_what_is_driven_elsewhere_is_named_there():
    for control, file in ELSEWHERE.items():
        name = controls()[control].name
        assert (TESTS / file).is_file(), control
        words = name and name.pattern.strip("^$").replace("\\", "").split(".+")[0].split("|")[0]
        assert not words or words.strip() in (TESTS / file).read_text("utf-8"), control


def test_rows_have_names_of_their_own():
    names = [(row.screen, row.name) for row in ROWS]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    ("control", "role", "name"),
    [
        ("live/Screen edit", "button", "Edit"),
        ("report/Screen causes", "link", "Causes"),
        ("chart/Screen views", "tab", None),
        ("faults/Journal journal", "", "Journal of changes"),
        ("faults/EraseSheet erase_running", "button", "Erase with the engine running"),
        ("recordings/RowActions export_of", "button", "Export drive.pcapng"),
        ("chart/time/ChartHeader imageMenu", "button", "Image…"),
    ],
)
def test_controls_are_found_in_the_sources_with_their_english_names(control, role, name):
    found = controls()[control]
    assert found.role == role
    assert name is None or found.name.match(name)
