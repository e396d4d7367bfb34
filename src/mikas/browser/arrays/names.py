"""The names of numpy that mikas uses: this module stands in its place.

Any other name is an error that says so.
"""

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
    absolute as abs,  # noqa: A004  (numpy's name)
)
from mikas.browser.arrays.elementwise import (
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
    sqrt,
    subtract,
    where,
)
from mikas.browser.arrays.elementwise import (
    rounded as round,  # noqa: A004
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
    mean,
    median,
    nanargmax,
    nanargmin,
    nanmax,
    nanmin,
    percentile,
)
from mikas.browser.arrays.statistics import (
    greatest as max,  # noqa: A004
)

__all__ = [
    "abs",
    "add",
    "append",
    "arange",
    "array",
    "array_equal",
    "asarray",
    "bincount",
    "bool_",
    "ceil",
    "clip",
    "concatenate",
    "count_nonzero",
    "cumsum",
    "diff",
    "divide",
    "dtype",
    "empty",
    "equal",
    "errstate",
    "flatnonzero",
    "float32",
    "float64",
    "floor",
    "fmax",
    "fmin",
    "format_float_positional",
    "frombuffer",
    "frompyfunc",
    "full",
    "generic",
    "greater",
    "greater_equal",
    "iinfo",
    "inf",
    "insert",
    "int16",
    "int32",
    "int64",
    "intp",
    "isfinite",
    "isin",
    "isnan",
    "less",
    "less_equal",
    "linspace",
    "logical_and",
    "max",
    "maximum",
    "mean",
    "median",
    "minimum",
    "multiply",
    "nan",
    "nanargmax",
    "nanargmin",
    "nanmax",
    "nanmin",
    "ndarray",
    "negative",
    "nextafter",
    "not_equal",
    "ones",
    "percentile",
    "repeat",
    "rint",
    "round",
    "searchsorted",
    "setdiff1d",
    "sort",
    "split",
    "sqrt",
    "subtract",
    "uint8",
    "unique",
    "where",
    "zeros",
]

inf, nan = math.inf, math.nan
intp = int64
generic = dtype
nextafter = math.nextafter


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
