"""Names that people use: words of a mechanic, of other programs, the catalog's own texts."""

from __future__ import annotations

from collections import Counter

import pytest

from mikas.catalog import shipped
from mikas.catalog.formula_syntax import FUNCTIONS, LONGEST, parse
from mikas.catalog.loading.loader import load_text
from mikas.catalog.synonyms import _table, normal
from mikas.errors import FormulaError, UnknownParameter

OWN = """
[derived.RPM]
formula = "FREQ / 2"
unit = "rpm"
text = "Half"

[derived.SLOW]
formula = "обороты / 2 + Batt_V + rpm"
unit = "rpm"
text = "Slow"
"""


@pytest.mark.parametrize(
    ("word", "name"),
    [
        ("Обороты", "FREQ"),
        ("оборот", "FREQ"),
        ("rpm", "FREQ"),
        ("freq", "FREQ"),
        ("Crankshaft speed", "FREQ"),
        ("обороты_хх", "FREQX"),
        ("Обороты ХХ", "FREQX"),
        ("Batt V", "UACC"),
        ("batt_v", "UACC"),
        ("ДТОЖ", "TWAT"),
        ("clt", "TWAT"),
        ("TPS", "THR"),
        ("Рхх", "FSM"),
        ("нагрузка", "FILLING"),
    ],
)
def test_a_word_means_a_channel(word, name):
    assert shipped().channel(word).name == name
    assert shipped().channel_of(f" {word} ") == name


def test_the_table_names_channels_each_by_names_of_its_own():
    names = [
        (channel, normal(name))
        for channel, (log, others) in _table().items()
        for name in {log, *others} - {""}
    ]
    assert {channel for channel, _ in names} <= set(shipped().channels)
    assert {n for n, count in Counter(name for _, name in set(names)).items() if count > 1} == set()
    assert not {name for _, name in names} & (set(FUNCTIONS) | {"if", "else", "and", "or", "not"})
    clash = {name.upper() for _, name in names} & set(shipped().channels)
    assert clash == set()


def test_an_abbreviation_of_two_channels_is_no_name_without_the_table():
    # «УОЗ» stands in the texts of UOZ and UOZOC, and the table gives it to UOZ.
    assert shipped().channel("уоз").name == "UOZ"
    with pytest.raises(UnknownParameter):
        shipped().channel("заданное положение")


def test_the_other_names_of_a_channel_mean_it():
    names = shipped().other_names
    assert {"rpm", "обороты"} <= set(names["FREQ"])
    assert {name for others in names.values() for name in others} == set(shipped().synonyms)
    assert all(shipped().channel_of(other) == name for name in names for other in names[name])


def test_a_wrong_letter_names_the_nearest():
    with pytest.raises(UnknownParameter, match="FREQ"):
        shipped().channel("оборты")


def test_a_formula_has_the_channels_own_names():
    parsed = parse(" обороты * 2 +обороты>k", {"k": 1}, shipped().channel_of)
    assert parsed.inputs == ("FREQ",)
    assert parsed.places == ((1, 8),)
    assert parsed.text == " FREQ * 2 +FREQ>k"
    assert parse(parsed.text, {"k": 1}).plain == parsed.plain


def test_a_formula_that_the_channels_own_names_make_too_long_is_refused():
    text = f"max({','.join(['load'] * 190)})"  # FILLING
    assert len(text) < LONGEST
    with pytest.raises(FormulaError, match=f"is longer than {LONGEST} signs"):
        parse(text, {}, shipped().channel_of)


def test_a_channel_and_a_constant_go_before_other_names():
    known = load_text("own.toml", OWN)
    assert known.channel("rpm").name == "RPM"
    assert known.derived["SLOW"].inputs == ("FREQ", "UACC", "RPM")
    assert known.derived["SLOW"].formula == "FREQ / 2 + UACC + rpm"
    assert known.derived["SLOW"].calculation().inputs == ("FREQ", "UACC", "RPM")
    assert parse("FREQ > rpm", {"rpm": 900}, shipped().channel_of).inputs == ("FREQ",)
