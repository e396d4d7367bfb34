"""Raw bytes to columns: bit for bit what `Conversion.decode` gives (§4), and numpy missing."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.catalog import Conversion, shipped
from mikas.recording.table.conversion import values

ALL_OF = {
    size: [number.to_bytes(size, "little") for number in range(1 << (8 * size))] for size in (1, 2)
}


def decoded(raw, conversion):
    columns = (bytes(column) for column in zip(*raw, strict=True))
    return values([np.frombuffer(each, np.uint8) for each in columns], conversion).tolist()


@pytest.mark.parametrize("interpretation", ["corrected", "literal", "alternative", "family"])
@pytest.mark.parametrize("parameter", shipped().parameters, ids=lambda p: p.name)
def test_every_raw_number_of_the_catalog_is_decoded_alike(parameter, interpretation):
    raw = ALL_OF[parameter.size]
    conversion = parameter.interpretation(interpretation)
    assert decoded(raw, conversion) == [float(conversion.decode(row)) for row in raw]


def made(**fields):
    try:
        return Conversion(**fields)
    except ValueError:  # too fine to stay exact: there is no such conversion
        return None


numbers = st.fractions(-1000, 1000, max_denominator=99991)
conversions = st.builds(
    made,
    size=st.integers(1, 4),
    signed=st.booleans(),
    mask=st.sampled_from([0, 0, 0, 1, 0x40, 0x80]),
    scale=st.one_of(numbers.filter(bool), st.just(Fraction(1))),
    bias=st.integers(-300, 300),
    offset=numbers,
).filter(bool)


@given(conversions, st.lists(st.binary(min_size=4, max_size=4), max_size=20))
def test_any_conversion_decodes_alike(conversion, drawn):
    size = conversion.size
    raw = [it[:size] for it in drawn] + [bytes(size), b"\xff" * size, b"\x80" * size]
    assert decoded(raw, conversion) == [float(conversion.decode(it)) for it in raw]
