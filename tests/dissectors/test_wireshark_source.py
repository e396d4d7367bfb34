"""The dissector as a text: whole, in both languages, and safe from what a user's catalog holds."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mikas.catalog import INTERPRETATIONS, shipped
from mikas.dissectors import wireshark
from mikas.dissectors.wireshark.generator import MARK, lua, source
from mikas.dissectors.wireshark.labels import LABELS
from mikas.recording.exchanges import matching

PARTS = sorted(Path(wireshark.__file__).parent.glob("*.lua"))


def test_every_hand_written_part_is_in_it():
    text = source(shipped(), "en", "corrected", "1.2.3")
    assert text.startswith(MARK)
    assert "version 1.2.3" in text
    assert PARTS
    for part in PARTS:
        assert part.read_text("utf-8") in text


def test_every_word_is_used_and_every_used_word_is_there():
    text = "".join(part.read_text("utf-8") for part in PARTS)
    used = set(re.findall(r"LABELS\.(\w+)", text))
    named = set(re.findall(r'expert_info\("(\w+)"', text))
    used |= {f"expert_{name}" for name in named} | {"sent", "received"}
    assert set(LABELS) - used == {name for name in LABELS if name.startswith("confidence_")}
    assert used <= set(LABELS)


@pytest.mark.parametrize("interpretation", INTERPRETATIONS)
def test_the_interpretation_of_the_command_is_the_default(interpretation):
    assert f'local INTERPRETATION = "{interpretation}"' in source(
        shipped(), "ru", interpretation, "0"
    )


def test_the_limits_are_those_of_decode():
    text = "".join(part.read_text("utf-8") for part in PARTS)
    limits = {
        name.lstrip("_"): value
        for name, value in vars(matching).items()
        if name.isupper() and isinstance(value, int | float) and name != "NO_REQUEST"
    }
    found = {
        name: float(number)
        for name, number in re.findall(r"^local ([A-Z_]+) = ([\d.]+)", text, re.MULTILINE)
        if name in limits
    }
    assert found == {
        name: it
        for name, it in limits.items()
        if isinstance(it, int | float) and name != "NO_REQUEST"
    }


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (None, "nil"),
        (True, "true"),
        (-7, "-7"),
        (2**51, "2251799813685248"),
        ([], "{}"),
        ([1, "x"], '{ 1, "x" }'),
        ({10: {"a": False}}, '{ [10] = { ["a"] = false } }'),
        ('"]] .. os.exit() --\\', r'"\"]] .. os.exit() --\\"'),
        ("a\nb\0c\x1b9", r'"a\010b\000c\0279"'),
        ("°C «об/мин»", '"°C «об/мин»"'),
    ],
)
def test_a_value_is_written_as_a_literal_of_lua(value, expected):
    assert lua(value) == expected


def test_a_long_table_is_in_lines():
    one, two = "x" * 60, "y" * 60
    assert lua([one, two]) == f'{{\n  "{one}",\n  "{two}",\n}}'
