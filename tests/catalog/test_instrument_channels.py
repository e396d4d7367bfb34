"""Channels of instruments in the catalog: their range, their names, keys of the own catalog."""

from __future__ import annotations

import pytest

from mikas.catalog import Level, load, shipped
from mikas.catalog.instrument_channels import InstrumentChannel, is_labelled, with_label
from mikas.catalog.own.changes import reset_keys, set_keys
from mikas.catalog.own.file import OwnCatalog
from mikas.errors import UnknownParameter
from mikas.i18n import Text

BOOST = InstrumentChannel("BOOST", Text("Boost", "Наддув"))


@pytest.mark.parametrize(
    ("given", "value", "taken"),
    [
        (None, -1e9, True),
        ((0.5, 1.5), 0.5, True),
        ((0.5, 1.5), 1.5, True),
        ((0.5, 1.5), 0.49, False),
        ((0.5, 1.5), 1.51, False),
    ],
)
def test_a_channel_takes_what_lies_in_its_range(given, value, taken) -> None:
    channel = InstrumentChannel("LAMBDA", Text("Mixture", "Смесь"), range=given)
    assert channel.takes(value) is taken


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("LAMBDA", "LAMBDA"),
        (with_label("LAMBDA", "left"), "LAMBDA"),
        ("GPS_SPEED_2", "GPS_SPEED"),
        ("FREQ", "FREQ"),
        ("LAMBDALEFT", None),
        ("BOOST", None),
    ],
)
def test_a_label_at_the_end_of_its_name_describes_it_all_the_same(name, found) -> None:
    channel = shipped().described(name)
    assert (channel.name if channel else None) == found


def test_a_name_that_only_begins_alike_is_another_one() -> None:
    assert is_labelled("GPS_SPEED", "GPS_SPEED")
    assert is_labelled(with_label("GPS_SPEED", "2"), "GPS_SPEED")
    assert not is_labelled("GPS_SPEEDO", "GPS_SPEED")


def test_its_limits_are_set_in_the_own_catalog(tmp_path) -> None:
    own = OwnCatalog(tmp_path / "catalog.toml")
    limits = {"warning_low": 0.8, "warning_high": 1.1}
    known = set_keys(own, shipped(), "lambda", {"limits": limits})
    set_limits = known.instruments["LAMBDA"].alarm_limits
    assert set_limits is not None
    assert set_limits.lows == ((Level.WARNING, 0.8),)
    assert list(own.entries()) == [("instrument", "LAMBDA")]
    assert own.load().catalog.instruments["LAMBDA"].alarm_limits == set_limits
    before = reset_keys(own, known, "LAMBDA", ["limits"]).instruments["LAMBDA"]
    assert before == shipped().instruments["LAMBDA"]


def beside():
    return shipped().with_beside([BOOST, InstrumentChannel("LAMBDA_LEFT", Text("Left", "Левая"))])


@pytest.mark.parametrize(
    ("word", "name"),
    [
        ("LAMBDA", "LAMBDA"),  # the meter's, not another name of the unit's VALF
        (" boost ", "BOOST"),
        ("lambda_left", "LAMBDA_LEFT"),
        ("freq", "FREQ"),
        ("0x05", "0x05"),
    ],
)
def test_a_formula_names_the_unit_s_channels_and_the_instruments_(word, name) -> None:
    assert beside().formula_channel(word).name == name


def test_a_channel_of_no_instrument_beside_is_unknown_with_the_nearest() -> None:
    with pytest.raises(UnknownParameter) as caught:
        beside().formula_channel("BOOTS")
    assert "BOOST" in caught.value.suggestions
    with pytest.raises(UnknownParameter):
        shipped().formula_channel("BOOST")


@pytest.mark.parametrize(
    ("name", "example"),
    [
        ("AFR", "aem="),
        ("lambda_left", "aem="),
        ("GPS_ALT", "nmea="),
    ],
)
def test_an_instrument_s_channel_among_the_unit_s_names_its_instrument(name, example) -> None:
    with pytest.raises(UnknownParameter) as caught:
        shipped().channel(name)
    assert example in caught.value.advice.en
    assert example in caught.value.advice.ru


def test_what_a_derived_channel_needs_beside_the_unit_is_found_through_others(tmp_path) -> None:
    own = tmp_path / "catalog.toml"
    own.write_text(
        '[derived.D]\ntext = "d"\nformula = "LAMBDA - VALF"\n'
        '[derived.TWICE]\ntext = "t"\nformula = "2 * D + GPS_SPEED"\n',
        "utf-8",
    )
    catalog = load(own)

    assert catalog.required_beside(["TWICE"]) == ("GPS_SPEED", "LAMBDA")
    assert catalog.required_beside(["D", "LAMBDA", "FREQ"]) == ("LAMBDA",)
    assert catalog.required_beside(["FREQ", "BOOST"]) == ()
    assert catalog.required_by(["TWICE"]) == ("VALF",)
