"""The names of numpy that mikas uses: this module stands in its place, and in numpy.typing's.

Any other name is an error that says so.
"""

# ruff: noqa: F401  (an import is all that a name of numpy needs here)

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Decimal
from typing import NoReturn

from mikas.browser.arrays.creation import (
    append,
    arange,
    array,
    asarray,
    concatenate,
    empty,
    frombuffer,
    full,
    linspace,
    ones,
    repeat,
    zeros,
)
from mikas.browser.arrays.dtypes import (
    bool_,
    dtype,
    dtype_of,
    float32,
    float64,
    int16,
    int32,
    int64,
    uint8,
)
from mikas.browser.arrays.elementwise import (
    absolute,
    add,
    ceil,
    clip,
    divide,
    equal,
    floor,
    fmax,
    fmin,
    frompyfunc,
    greater,
    greater_equal,
    isfinite,
    isnan,
    less,
    less_equal,
    logical_and,
    maximum,
    minimum,
    multiply,
    negative,
    not_equal,
    rint,
    rounded,
    sqrt,
    subtract,
    where,
)
from mikas.browser.arrays.ndarray import ndarray
from mikas.browser.arrays.ordering import (
    array_equal,
    bincount,
    count_nonzero,
    diff,
    flatnonzero,
    insert,
    isin,
    searchsorted,
    setdiff1d,
    sort,
    split,
    unique,
)
from mikas.browser.arrays.statistics import (
    cumsum,
    greatest,
    mean,
    median,
    nanargmax,
    nanargmin,
    nanmax,
    nanmin,
    percentile,
)

abs, max, round = absolute, greatest, rounded  # noqa: A001  (numpy's names)
inf, nan, nextafter = math.inf, math.nan, math.nextafter
intp = int64
generic = dtype
NDArray = list  # numpy.typing's: annotations only put a type in brackets behind it


class iinfo:  # noqa: N801  (numpy's name)
    """The least and the greatest number of a type of whole numbers."""

    def __init__(self, given: object) -> None:
        bits = 8 * dtype_of(given).itemsize
        self.min, self.max = -(1 << (bits - 1)), (1 << (bits - 1)) - 1


@contextmanager
def errstate(**_: str) -> Iterator[None]:
    """Do nothing: no operation here warns."""
    yield


def format_float_positional(value: float, *, trim: str) -> str:
    """Return the shortest decimal that reads back as `value`, never with an exponent."""
    if trim != "-":
        raise NotImplementedError(f"trim {trim!r}")
    text = format(Decimal(repr(value)), "f")
    return text.rstrip("0").rstrip(".") if "." in text else text


class MissingName(NotImplementedError, AttributeError):
    """A name of numpy that does not exist here."""


def __getattr__(name: str) -> NoReturn:
    if name.startswith("__"):  # the machinery of imports asks for some
        raise AttributeError(name)
    raise MissingName(f"the arrays of the browser have no numpy.{name}")
