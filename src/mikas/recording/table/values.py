"""Responses to columns: the values of their data (§3, §4).

A conversion's normal form is three integers (`catalog.conversion`), and every quotient of 64-bit
floats below is the one that `Conversion.decode` computes: the values are the same, bit for bit. A
response whose length does not fit its request makes a row without a value. Which `01` is a refusal
(D10) is decided by `exchanges.groups`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from mikas.catalog import Catalog
from mikas.catalog.conversion import Conversion
from mikas.recording.exchanges.arrays import Bytes, Floats, side_by_side
from mikas.recording.exchanges.columnar import ResponseColumns
from mikas.recording.exchanges.groups import ResponseGroup
from mikas.recording.exchanges.layouts import Layouts
from mikas.recording.table.channels import Channel


class Definitions:
    """A catalog in one interpretation, as layouts and channels."""

    def __init__(self, catalog: Catalog, interpretation: str) -> None:
        self._catalog = catalog
        self._conversions = {p.name: p.interpretation(interpretation) for p in catalog.parameters}
        self.layouts = Layouts(catalog.size_of)

    def names(self, codes: Collection[int]) -> set[str]:
        """Return the parameters that have these codes."""
        return {p.name for code in codes for p in self._catalog.by_code(code)}

    def conversions(self, code: int) -> list[tuple[str, Conversion]]:
        """Return the parameters that have this code, with their conversions."""
        return [(p.name, self._conversions[p.name]) for p in self._catalog.by_code(code)]

    def channels(self, names: Collection[str]) -> tuple[Channel, ...]:
        """Return the columns of these parameters, in the order of the catalog."""
        return tuple(
            Channel(p.name, self._conversions[p.name].unit, p.text, p.is_flag, p.decimals)
            for p in self._catalog.parameters
            if p.name in names
        )


def converted(
    group: ResponseGroup,
    responses: ResponseColumns,
    definitions: Definitions,
    names: Collection[str],
) -> Iterator[tuple[str, Floats]]:
    """Yield the values of the group's fitting rows, a parameter at a time."""
    table = side_by_side(responses.bodies, responses.starts[group.fitting], group.layout.length)
    for code, begin, _ in group.layout.places:
        for name, conversion in definitions.conversions(code):
            if name in names:
                yield name, values(table[:, begin : begin + conversion.size], conversion)


def values(raw: Bytes, conversion: Conversion) -> Floats:
    """Return `Conversion.decode` of every row of raw bytes; flags are 0 and 1."""
    numbers = np.zeros(len(raw), np.int64)
    for at in range(conversion.size):
        numbers |= raw[:, at].astype(np.int64) << (8 * at)
    if conversion.signed:
        half = 1 << (8 * conversion.size - 1)
        numbers -= (numbers & half) << 1
    floats: Floats
    if conversion.is_flag:
        floats = ((numbers & conversion.mask) != 0).astype(np.float64)
    else:
        exact = numbers * conversion.numerator + conversion.constant
        floats = exact / float(conversion.denominator)
    return floats
