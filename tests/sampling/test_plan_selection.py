"""From names to what is asked."""

from __future__ import annotations

import pytest

from mikas.catalog import Derived, shipped
from mikas.errors import UnknownParameter, UsageError
from mikas.sampling.plan import select


def asked(*names: str) -> dict[str, int]:
    return {w.parameter.name: w.divisor for w in select(shipped(), names).parameters}


def test_no_names_are_all_parameters():
    selection = select(shipped(), [])
    assert selection.channels == shipped().parameters
    assert [w.parameter for w in selection.parameters] == list(shipped().parameters)
    assert not selection.explicit


def test_names_in_any_case_and_codes_are_selected():
    names = [" twat ", "0x1a", "0x3F:2", "Freq/10"]
    assert [c.name for c in select(shipped(), names).channels] == [
        "TWAT",
        "0x1A",
        "0x3F:2",
        "FREQ",
    ]
    assert asked(*names) == {"TWAT": 1, "0x1A": 1, "0x3F:2": 1, "FREQ": 10}


def test_the_smallest_divisor_of_a_repeated_name_applies():
    assert asked("FREQ/10", "FREQ/2") == {"FREQ": 2}
    assert len(select(shipped(), ["FREQ", "freq"]).channels) == 1


def test_inputs_are_requested_as_often_as_their_derived_channel():
    selection = select(shipped(), ["TWAT/10", "FUEL_FLOW/3", "FREQ/5"])
    assert [c.name for c in selection.channels] == ["TWAT", "FUEL_FLOW", "FREQ"]
    assert isinstance(selection.channels[1], Derived)
    assert selection.derived == ("FUEL_FLOW",)
    assert asked("TWAT/10", "FUEL_FLOW/3", "FREQ/5") == {"TWAT": 10, "FREQ": 3, "INJ": 3}


@pytest.mark.parametrize("name", ["TWTA", "", "/", "/10", "0x1A:9", "0xFFF"])
def test_unknown_names_are_refused(name):
    with pytest.raises(UnknownParameter):
        select(shipped(), ["FREQ", name])


@pytest.mark.parametrize(
    "name", ["FREQ/", "FREQ/0", "FREQ/-1", "FREQ/1.5", "FREQ/x", "FREQ/1001", "FREQ/²"]
)
def test_invalid_divisors_are_refused(name):
    with pytest.raises(UsageError):
        select(shipped(), [name])


def test_a_number_that_fills_the_screen_is_refused_like_any_other():
    with pytest.raises(UsageError):
        select(shipped(), ["FREQ/" + "9" * 10_000])


def test_one_code_with_two_sizes_is_ambiguous():
    with pytest.raises(UsageError, match="0x3F"):
        select(shipped(), ["INJ", "0x3F:1"])


def test_a_single_word_is_no_list_of_names():
    with pytest.raises(UsageError, match="list of words"):
        select(shipped(), [5])
