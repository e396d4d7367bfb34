"""Raw to value and back: exact for every raw number, in every interpretation."""

from __future__ import annotations

import math
import pickle
from fractions import Fraction
from typing import cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import INTERPRETATIONS, Conversion, Parameter, shipped
from mikas.catalog.lookup import is_corrected
from mikas.errors import UsageError, ValueDoesNotFit

NUMERIC = [each for each in shipped().parameters if not each.is_flag]
INTERPRETATIONS_THAT_DIFFER = [
    pytest.param(parameter, name, id=f"{parameter.name}-{name}")
    for parameter in NUMERIC
    for name, conversion in parameter.interpretations.items()
    if name == "corrected" or conversion != parameter.conversion
]
FLAGS = [each for each in shipped().parameters if each.is_flag]


@pytest.mark.parametrize(("parameter", "interpretation"), INTERPRETATIONS_THAT_DIFFER)
def test_every_raw_value_comes_back(parameter: Parameter, interpretation: str) -> None:
    conversion = parameter.interpretation(interpretation)
    for number in range(1 << (8 * parameter.size)):
        raw = number.to_bytes(parameter.size, "little")
        assert conversion.encode(conversion.decode(raw), parameter.name) == raw
    assert parameter.encode(parameter.decode(raw, interpretation), interpretation) == raw


@pytest.mark.parametrize(("parameter", "interpretation"), INTERPRETATIONS_THAT_DIFFER)
def test_every_value_is_the_float_nearest_to_the_exact_one(
    parameter: Parameter, interpretation: str
) -> None:
    conversion = parameter.interpretation(interpretation)
    low, high = conversion.raw_limits
    assert high - low + 1 == 1 << (8 * parameter.size)
    # (number - bias) * scale + offset, in whole numbers: their quotient is rounded once
    over, under = conversion.scale.as_integer_ratio()
    offset = conversion.offset * under
    over, under, offset = (
        over * offset.denominator,
        under * offset.denominator,
        offset.numerator,
    )
    kind = int if conversion.is_whole else float
    values = [conversion.value(number) for number in range(low, high + 1)]
    assert values == [
        ((number - conversion.bias) * over + offset) / under for number in range(low, high + 1)
    ]
    assert {type(value) for value in values} == {kind}
    # what a bulk decoder does with arrays of 64-bit floats
    numbers = np.arange(low, high + 1, dtype=np.float64)
    array = (numbers * conversion.numerator + conversion.constant) / conversion.denominator
    assert array.tolist() == values


@pytest.mark.parametrize("parameter", FLAGS, ids=lambda each: each.name)
def test_a_flag_is_true_exactly_where_its_bit_is_set(parameter: Parameter) -> None:
    mask = parameter.conversion.mask
    assert mask.bit_count() == 1
    for number in range(256):
        value = parameter.decode(bytes([number]))
        assert value is (number & mask == mask)


@pytest.mark.parametrize("offset", [Fraction(2**52 - 256, 3), Fraction(256 - 2**52, 3)])
def test_the_finest_that_is_allowed_comes_back(offset: Fraction) -> None:
    conversion = Conversion(1, scale=Fraction(1, 3), offset=offset)
    for number in range(256):
        assert conversion.encode(conversion.value(number), "X") == bytes([number])
    with pytest.raises(ValueError, match="too fine"):
        Conversion(1, scale=Fraction(1, 3), offset=offset + Fraction(1 if offset > 0 else -1, 3))


def test_interpretations_are_the_three_that_have_names() -> None:
    assert INTERPRETATIONS == ("corrected", "literal", "alternative", "family")
    for parameter in shipped().parameters:
        for name in INTERPRETATIONS:
            assert parameter.interpretation(name) == parameter.interpretations.get(
                name, parameter.conversion
            )


ratios = st.fractions(-1000, 1000, max_denominator=10_000)


@given(
    size=st.sampled_from([1, 2]),
    signed=st.booleans(),
    scale=ratios.filter(bool),
    bias=st.integers(-0xFFFF, 0xFFFF),
    offset=ratios,
    data=st.data(),
)
def test_any_sound_conversion_is_exact(
    size: int, signed: bool, scale: Fraction, bias: int, offset: Fraction, data: st.DataObject
) -> None:
    conversion = Conversion(size, signed=signed, scale=scale, bias=bias, offset=offset)
    raw = data.draw(st.binary(min_size=size, max_size=size))
    value = conversion.decode(raw)
    number = int.from_bytes(raw, "little", signed=signed)
    assert value == float((number - bias) * scale + offset)
    assert conversion.encode(value, "X") == raw
    assert conversion.encode((number - bias) * scale + offset, "X") == raw
    assert conversion.limits is not None
    assert conversion.limits[0] <= value <= conversion.limits[1]


@given(st.floats(-40.49, 215.49))
def test_the_nearest_step_is_taken(value: float) -> None:
    parameter = shipped().parameter("TWAT")
    assert abs(parameter.decode(parameter.encode(value)) - value) <= 0.5


def test_halfway_goes_to_the_higher_raw_number() -> None:
    parameter = shipped().parameter("TWAT")
    assert parameter.encode(0.5) == bytes([41])
    assert parameter.encode(-0.5) == bytes([40])
    assert Conversion(1, scale=Fraction(-2)).encode(-5, "X") == bytes([3])


@pytest.mark.parametrize("value", [-41, -40.51, 215.5, 216, 1e308, -1e308, 10**400])
def test_out_of_range_is_refused_with_the_range(value: float) -> None:
    with pytest.raises(ValueDoesNotFit) as caught:
        shipped().parameter("TWAT").encode(value)
    assert "TWAT: -40 to 215 °C, in steps of 1." in caught.value.text.en
    assert "TWAT: от -40 до 215 °C, шаг 1." in caught.value.text.ru


def test_the_refusal_gives_the_range_of_the_interpretation_in_use() -> None:
    with pytest.raises(ValueDoesNotFit, match=r"-12\.8 to 12\.7 V, in steps of 0\.1"):
        shipped().parameter("UACC").encode(14.2, "literal")
    with pytest.raises(ValueDoesNotFit, match=r"0 to 255, in steps of 1"):
        shipped().parameter("MINERR").encode(256)
    with pytest.raises(ValueDoesNotFit, match=r"-510 to 0, in steps of 2\.") as caught:
        Conversion(1, scale=Fraction(-2)).encode(2, "X")
    assert "от -510 до 0, шаг 2." in caught.value.text.ru


@pytest.mark.parametrize(
    "value", [math.nan, math.inf, -math.inf, True, False, "85", None, b"U", 1j]
)
def test_only_finite_numbers_are_encoded(value: object) -> None:
    with pytest.raises(ValueDoesNotFit, match="a finite number is needed"):
        shipped().parameter("TWAT").encode(cast("float", value))


@pytest.mark.parametrize("value", [True, False, 1, 0])
def test_a_flag_alone_is_not_encoded(value: bool) -> None:
    with pytest.raises(ValueDoesNotFit, match="write the whole byte raw") as caught:
        shipped().parameter("RXX").encode(value)
    assert "запишите байт целиком" in caught.value.text.ru


@pytest.mark.parametrize("raw", [b"", b"\x01", b"\x01\x02\x03"])
def test_raw_bytes_of_another_length_are_refused(raw: bytes) -> None:
    with pytest.raises(UsageError, match=rf"2 raw byte\(s\) are needed, not {len(raw)}") as caught:
        shipped().parameter("INJ").decode(raw)
    assert caught.value.received == raw


@pytest.mark.parametrize(
    ("conversion", "formula"),
    [
        (Conversion(1), "b"),
        (Conversion(2), "w"),
        (Conversion(3), "n"),
        (Conversion(1, signed=True), "s"),
        (Conversion(2, signed=True), "sw"),
        (Conversion(2, mask=0x100), "w & 0x0100"),
        (Conversion(1, offset=Fraction(5)), "b + 5"),
        (Conversion(1, bias=128), "b − 128"),
        (Conversion(1, bias=-3), "b + 3"),
        (Conversion(1, bias=128, offset=Fraction(1)), "(b − 128) + 1"),
        (Conversion(1, scale=Fraction(100, 255)), "b · 20 / 51"),
        (Conversion(1, scale=Fraction(5, 2), offset=Fraction(-1, 3)), "b·5/2 − 1/3"),
        (Conversion(1, scale=Fraction(-1, 2)), "−b / 2"),
        (Conversion(1, scale=Fraction(-3), offset=Fraction(-1)), "−1 − b·3"),
        (Conversion(1, scale=Fraction(-1), offset=Fraction(100)), "100 − b"),
    ],
)
def test_a_conversion_is_written_as_its_formula(conversion: Conversion, formula: str) -> None:
    assert conversion.formula == formula


@pytest.mark.parametrize(
    ("conversion", "kind"),
    [
        (Conversion(1), "unsigned"),
        (Conversion(2), "word"),
        (Conversion(1, signed=True), "signed"),
        (Conversion(2, signed=True), "signed"),
        (Conversion(1, mask=4), "flag"),
    ],
)
def test_a_conversion_knows_its_kind(conversion: Conversion, kind: str) -> None:
    assert conversion.kind == kind


@pytest.mark.parametrize(
    ("scale", "offset"),
    [
        (Fraction(0), Fraction(0)),
        (Fraction(1, 2**52), Fraction(0)),
        (Fraction(1), Fraction(2**52)),
        (Fraction(-(2**45)), Fraction(0)),
    ],
)
def test_what_could_not_be_exact_is_no_conversion(scale: Fraction, offset: Fraction) -> None:
    with pytest.raises(ValueError, match="too fine"):
        Conversion(1, scale=scale, offset=offset)


def test_parameters_can_be_pickled_and_hashed() -> None:
    for parameter in shipped().parameters:
        assert pickle.loads(pickle.dumps(parameter)) == parameter
        assert len({parameter, parameter}) == 1


def test_an_unknown_interpretation_is_an_error_and_not_the_default() -> None:
    known = "corrected, literal, alternative, family"
    with pytest.raises(UsageError, match=f"no interpretation “litteral”; there are: {known}"):
        shipped().parameter("UACC").decode(b"\x8e", "litteral")


def test_an_interpretation_is_the_corrected_one_where_no_erratum_changes_the_formula() -> None:
    catalog = shipped()
    assert is_corrected(catalog.parameter("TWAT"), "literal")
    assert not is_corrected(catalog.parameter("FREQ"), "literal")
    assert is_corrected(catalog.parameter("FREQ"), "corrected")
    assert is_corrected(catalog.channel("FUEL_FLOW"), "literal")  # from corrected values
