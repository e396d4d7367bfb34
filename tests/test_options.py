"""Options given as text: what is allowed, and what the error names."""

from __future__ import annotations

from enum import Enum

import pytest

from mikas.errors import UsageError
from mikas.options import OptionParser, check_choice, check_names, check_number


class Colour(Enum):
    RED = "red"
    BLUE = "blue"


def test_an_unknown_option_names_the_nearest_and_all():
    with pytest.raises(UsageError) as caught:
        check_names({"buad": "1"}, ("baud", "dtr"))
    assert "no option “buad”, only: baud, dtr. Did you mean baud?" in str(caught.value)
    assert "Может быть, baud?" in caught.value.text.ru


def test_a_long_list_is_left_out_where_a_name_is_near():
    names = [f"setting{number}" for number in range(20)] + ["speed"]
    with pytest.raises(UsageError, match=r"there is no option “sped”. Did you mean speed[?]$"):
        check_names({"sped": "1"}, names)
    with pytest.raises(UsageError, match="setting0, setting1"):
        check_names({"quux": "1"}, names)


def test_an_option_where_there_are_none_is_refused():
    with pytest.raises(UsageError, match="takes no options"):
        check_names({"a": "1"}, ())


def test_known_options_pass():
    check_names({"baud": "1"}, ("baud", "dtr"))


@pytest.mark.parametrize("text", ["", "x", "-1", "1.5", "0", "101", "²", "1_0"])
def test_an_integer_out_of_limits_is_refused_with_them(text):
    with pytest.raises(UsageError, match="valid value for n; allowed: 1 … 100"):
        OptionParser({"n": text}).integer("n", 5, lowest=1, highest=100)


def test_an_integer_within_limits_or_the_default_is_taken():
    assert OptionParser({"n": "100"}).integer("n", 5, lowest=1, highest=100) == 100
    assert OptionParser({}).integer("n", 5, lowest=1, highest=100) == 5
    assert OptionParser({"n": "-7"}).integer("n", 5) == -7


@pytest.mark.parametrize("text", ["", "x", "-1", "1001", "nan", "inf"])
def test_a_number_out_of_limits_is_refused_with_them(text):
    with pytest.raises(UsageError, match="valid value for n; allowed: 0 … 1000"):
        OptionParser({"n": text}).number("n", 5, highest=1000)


def test_a_number_within_limits_or_the_default_is_taken():
    assert OptionParser({"n": "0.5"}).number("n", 5, highest=1000) == 0.5
    assert OptionParser({}).number("n", 5, highest=1000) == 5


def test_a_switch_is_on_or_off_in_every_spelling():
    for text, on in {"1": True, "ON": True, "0": False, "no": False}.items():
        assert OptionParser({"s": text}).switch("s", default=not on) is on
    assert OptionParser({}).switch("s", default=True) is True
    with pytest.raises(UsageError, match="“maybe” is not a valid value for s; allowed: 0, 1"):
        OptionParser({"s": "maybe"}).switch("s", default=True)


def test_a_choice_outside_of_the_list_is_refused():
    given = OptionParser({"c": "blue", "d": "grey"})
    assert given.choice("c", "red", ("red", "blue")) == "blue"
    assert given.member("c", Colour.RED) is Colour.BLUE
    assert given.member("e", Colour.RED) is Colour.RED
    with pytest.raises(UsageError, match="“grey” is not a valid value for d; allowed: red, blue"):
        given.member("d", Colour.RED)


@pytest.mark.parametrize("value", [True, "1", None, -1, 1.5, float("nan"), float("inf"), 10**400])
def test_a_value_that_is_no_whole_number_from_0_up(value):
    with pytest.raises(UsageError, match="allowed: a whole number from 0 up") as caught:
        check_number("n", value, lowest=0, whole=True)
    shown = repr(value) if isinstance(value, str) else value
    assert f"«{shown}» не подходит для n" in caught.value.text.ru


def test_valid_values_pass():
    check_number("n", 0.5, lowest=0)
    check_number("n", 3, lowest=0, whole=True)
    check_choice("c", "a", ("a", "b"))
